//! The flow from a box on fixed pieces, enclosed over a stretch of time.

use crate::certify::flow::algebra::{Algebra, Coefficients};
use crate::certify::flow::field::{Drives, Field};
use crate::certify::flow::part::Part;
use crate::certify::square::Square;
use crate::certify::unproved::Unproved;
use crate::contact::Piece;
use crate::interval::number::Interval;
use crate::tape::operations::FormId;

/// Inflation of the enclosure of a stretch in its three attempts, as a share of its size `[1]`.
const INFLATIONS: [f64; 3] = [1e-8, 1e-4, 1e-1];

/// The motion from all points of a box over [0, length] on fixed pieces, with its derivatives.
pub(crate) struct Stretch<'f, 'm> {
    pub(crate) field: &'f Field<'m>,
    /// Coefficients from the box, up to the order before the last.
    wide: Coefficients,
    /// The last coefficients, over the enclosure of the whole stretch.
    rest: Coefficients,
    pub(crate) length: f64,
    pub(crate) time: Interval,
    inside: f64,
    /// Drives after the start.
    drives: Drives,
    pieces: Vec<Piece>,
}

impl<'f, 'm> Stretch<'f, 'm> {
    /// The stretch from a box at a time. `inside`: a time between the drive edges between which it lies.
    ///
    /// An enclosure B is proved by the inclusion X + Σ [0, h]^j X_j + [0, h]^K B_K ⊂ B.   Source: Nedialkov,
    /// Jackson & Pryce, Reliable Computing 7, 449 (2001).
    ///
    /// # Errors
    /// [`Unproved::Wrapping`] if no enclosure is found: the stretch is too long.
    pub(crate) fn new(
        field: &'f Field<'m>,
        pieces: &[Piece],
        (time, inside): (Interval, f64),
        x: &[Interval],
        length: f64,
    ) -> Result<Self, Unproved> {
        let wrapping = Unproved::Wrapping { t: time.middle(), length };
        let (tape, order) = (&field.tangent.tape, field.order);
        let start = field.with_columns(x, &Square::identity(2 * field.n));
        let drives = field.kept_drives(time, inside, order + 2);
        let wide = field.tangent.expand(pieces.into(), &start, &drives, order - 1);
        let span = Interval::of_ends(0.0, length);
        let during = field.kept_drives(time + span, inside, order + 2);
        let polynomial: Vec<Interval> = (0..2 * tape.dof)
            .map(|i| (0..order).rev().fold(Interval::ZERO, |sum, k| sum * span + wide.slot(i, k)))
            .collect();
        if !polynomial.iter().all(|x| x.is_bounded()) {
            return Err(wrapping);
        }
        let mut power = Interval::ONE;
        for _ in 0..order {
            power = power * Interval::from(length);
        }
        let power = Interval::of_ends(0.0, power.high());
        for inflation in INFLATIONS {
            let room = |x: &Interval| {
                *x + Interval::symmetric(inflation * (x.magnitude() + x.width()) + f64::MIN_POSITIVE)
            };
            let guess: Vec<Interval> = polynomial.iter().map(room).collect();
            let rest = field.tangent.expand(pieces.into(), &guess, &during, order);
            let proved = |(i, x): (usize, &Interval)| (*x + power * rest.slot(i, order)).lies_in(guess[i]);
            if polynomial.iter().enumerate().all(proved) {
                let pieces = pieces.to_vec();
                return Ok(Stretch { field, wide, rest, length, time, inside, drives, pieces });
            }
        }
        Err(wrapping)
    }

    /// Σ c_k s^k with the remainder in the last coefficient, by Horner's rule.
    fn sum(&self, s: Interval, coefficient: impl Fn(usize) -> Interval) -> Interval {
        (0..=self.field.order).rev().fold(Interval::ZERO, |sum, k| sum * s + coefficient(k))
    }
    /// Coefficient k of a coordinate or velocity of the tangent tape.
    fn slot(&self, slot: usize, k: usize) -> Interval {
        if k < self.field.order { self.wide.slot(slot, k) } else { self.rest.slot(slot, k) }
    }
    fn form(&self, form: FormId, k: usize) -> Interval {
        if k < self.field.order { self.wide.form(form, k) } else { self.rest.form(form, k) }
    }
    fn place(&self, i: usize) -> usize {
        self.field.place(i, 0)
    }

    /// Coordinates and velocities at the times s after the start.
    pub(crate) fn state(&self, s: Interval) -> Vec<Interval> {
        (0..2 * self.field.n).map(|i| self.sum(s, |k| self.slot(self.place(i), k))).collect()
    }
    /// The derivative of the state with respect to that at the start.
    pub(crate) fn slope(&self, s: Interval) -> Square {
        Square::from_fn(2 * self.field.n, |i, j| {
            let slot = self.field.place(i, 1 + j);
            self.sum(s, |k| self.slot(slot, k))
        })
    }
    /// The distance of a contact from an edge, positive in the gap.
    pub(crate) fn distance(&self, form: FormId, s: Interval) -> Interval {
        self.sum(s, |k| self.form(form, k))
    }
    /// The rate of a distance.
    pub(crate) fn rate(&self, form: FormId, s: Interval) -> Interval {
        (1..=self.field.order).rev().fold(Interval::ZERO, |sum, k| sum * s + self.form(form, k) * k as f64)
    }

    /// The states after the times `s` from the points `x` at a time within that of the stretch, both narrower
    /// than those of the stretch.
    pub(crate) fn narrow(&self, time: Interval, x: &[Interval]) -> Narrow<'_, 'f, 'm> {
        let drives = match time == self.time {
            true => self.drives.clone(),
            false => self.field.drive_series(time, self.inside, self.field.order + 1),
        };
        let c = self.field.motion.expand(self.pieces[..].into(), x, &drives, self.field.order - 1);
        Narrow { stretch: self, c }
    }
}

/// A stretch up to a time after its start.
pub(crate) struct Until<'s, 'f, 'm>(pub(crate) &'s Stretch<'f, 'm>, pub(crate) Interval);

impl Part for Until<'_, '_, '_> {
    fn start(&self) -> Interval {
        self.0.time
    }
    fn until(&self) -> Interval {
        self.1
    }
    fn pieces(&self, contact: usize) -> [Piece; 2] {
        [self.0.pieces[contact]; 2]
    }
    fn series(&self) -> Vec<Vec<Interval>> {
        let stretch = self.0;
        let of = |i| (0..=stretch.field.order).map(|k| stretch.slot(stretch.place(i), k)).collect();
        (0..2 * stretch.field.n).map(of).collect()
    }
    fn series_of(&self, other: &Algebra) -> Vec<Vec<Interval>> {
        let stretch = self.0;
        let (field, order, pieces) = (stretch.field, stretch.field.order, &stretch.pieces[..]);
        let x: Vec<Interval> = (0..2 * field.n).map(|i| stretch.slot(stretch.place(i), 0)).collect();
        let wide = other.expand(pieces.into(), &x, &stretch.drives, order - 1);
        let span = Interval::of_ends(0.0, stretch.length);
        let during = field.drive_series(stretch.time + span, stretch.inside, order + 2);
        let rest = other.expand(pieces.into(), &stretch.state(span), &during, order);
        let of = |form| (0..=order).map(|k| if k < order { &wide } else { &rest }.form(form, k)).collect();
        other.tape.distances.iter().filter_map(|both| both[0]).map(of).collect()
    }
}

/// The motion from a narrower box, with the remainder of the stretch.
pub(crate) struct Narrow<'s, 'f, 'm> {
    stretch: &'s Stretch<'f, 'm>,
    c: Coefficients,
}

impl Narrow<'_, '_, '_> {
    pub(crate) fn state(&self, s: Interval) -> Vec<Interval> {
        let stretch = self.stretch;
        let order = stretch.field.order;
        let of = |i: usize| {
            stretch.sum(s, |k| if k < order { self.c.slot(i, k) } else { stretch.slot(stretch.place(i), k) })
        };
        (0..2 * stretch.field.n).map(of).collect()
    }
    /// The distance of a contact from an edge: forms of the motion and of its tangent count alike.
    pub(crate) fn distance(&self, motion: FormId, tangent: FormId, s: Interval) -> Interval {
        let stretch = self.stretch;
        let order = stretch.field.order;
        stretch.sum(s, |k| if k < order { self.c.form(motion, k) } else { stretch.form(tangent, k) })
    }
}
