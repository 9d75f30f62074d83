//! The flow from a box on fixed pieces, enclosed over a stretch of time.

use crate::certify::algebra::{Algebra, Coefficients};
use crate::certify::unproved::Unproved;
use crate::contact::Piece;
use crate::interval::number::Interval;
use crate::model::recording::Enclosed;
use crate::periodic::flow::tangent_tape::tangent;
use crate::series::PowerSeries;
use crate::tape::operations::{FormId, Tape};

/// Inflation of the enclosure of a stretch in its three attempts, as a share of its size `[1]`.
const INFLATIONS: [f64; 3] = [1e-8, 1e-4, 1e-1];

/// The equations of a model on intervals.
pub(super) struct Field<'m> {
    /// Number of degrees of freedom.
    pub(super) n: usize,
    pub(super) motion: Algebra,
    /// The motion with its derivatives with respect to the 2n initial values.
    pub(super) tangent: Algebra,
    /// The derivative of each distance.
    pub(super) edge_slopes: Vec<[Option<Algebra>; 2]>,
    pub(super) drives: Box<dyn Enclosed + 'm>,
    /// Order of the remainder.
    pub(super) order: usize,
}

impl<'m> Field<'m> {
    pub(super) fn new(tape: Tape, drives: Box<dyn Enclosed + 'm>, order: usize) -> Self {
        let n = tape.dof;
        let tangent = Algebra::new(tangent(&tape, 2 * n, &[]));
        // A tape whose accelerations k n are the distance (k = 0) and its differences.
        let slopes = |form: FormId| {
            let tape = Tape { accelerations: vec![form; n], ..tape.clone() };
            Algebra::new(self::tangent(&tape, 2 * n, &[]))
        };
        let edge_slopes = tape.distances.iter().map(|both| both.map(|form| form.map(slopes))).collect();
        Field { n, motion: Algebra::new(tape), tangent, edge_slopes, drives, order }
    }
    /// The velocities after an impact, with their differences, in place of accelerations.
    pub(super) fn impact(&self, contact: usize, on: Piece) -> Result<Algebra, Unproved> {
        let tape = self.drives.impact(contact, on).0;
        let needed = tape.needed();
        let moves = self.drive_series(Interval::ZERO, 0.0, 2);
        let moving = (0..tape.drives).any(|d| needed[2 * tape.dof + d] && moves[d].coefficients().len() > 1);
        match moving || tape.kink().is_some() {
            true => Err(Unproved::NoEnclosure {
                what: format!("the impact of contact {contact} on a stop that moves"),
            }),
            false => Ok(Algebra::new(tangent(&tape, 2 * self.n, &[]))),
        }
    }
    pub(super) fn drive_series(
        &self,
        time: Interval,
        inside: f64,
        coefficients: usize,
    ) -> Vec<PowerSeries<Interval>> {
        let mut u = vec![PowerSeries::from(0.0); self.motion.tape.drives];
        self.drives.drives(time, inside, coefficients.max(2), &mut u);
        u
    }

    /// The box with its derivatives: coordinates, velocities and the columns of a matrix, as the tape of the
    /// tangent reads them.
    pub(super) fn with_columns(&self, x: &[Interval], columns: &Square) -> Vec<Interval> {
        let (n, d) = (self.n, 2 * self.n);
        let mut all = vec![Interval::ZERO; 2 * n * (1 + d)];
        for half in 0..2 {
            for i in 0..n {
                let start = half * n * (1 + d);
                all[start + i] = x[half * n + i];
                for k in 0..d {
                    all[start + n * (1 + k) + i] = columns.at(half * n + i, k);
                }
            }
        }
        all
    }
}

/// A square matrix of intervals, by rows.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Square {
    pub(super) size: usize,
    pub(super) entries: Vec<Interval>,
}

impl Square {
    pub(super) fn from_fn(size: usize, entry: impl Fn(usize, usize) -> Interval) -> Self {
        let entries = (0..size * size).map(|i| entry(i / size, i % size)).collect();
        Square { size, entries }
    }
    pub(super) fn identity(size: usize) -> Self {
        Square::from_fn(size, |i, j| if i == j { Interval::ONE } else { Interval::ZERO })
    }
    pub(super) fn at(&self, i: usize, j: usize) -> Interval {
        self.entries[i * self.size + j]
    }
    pub(super) fn times(&self, other: &Square) -> Square {
        Square::from_fn(self.size, |i, j| {
            (0..self.size).fold(Interval::ZERO, |sum, k| sum + self.at(i, k) * other.at(k, j))
        })
    }
    pub(super) fn middle(&self) -> nalgebra::DMatrix<f64> {
        nalgebra::DMatrix::from_fn(self.size, self.size, |i, j| self.at(i, j).middle())
    }
}

/// The motion from all points of a box over [0, length] on fixed pieces, with its derivatives.
pub(super) struct Stretch<'f, 'm> {
    field: &'f Field<'m>,
    /// Coefficients from the box, up to the order before the last.
    wide: Coefficients,
    /// The last coefficients, over the enclosure of the whole stretch.
    rest: Coefficients,
    pub(super) length: f64,
    time: Interval,
    inside: f64,
    /// Drives after the start.
    drives: Vec<PowerSeries<Interval>>,
    pieces: Vec<Piece>,
}

impl<'f, 'm> Stretch<'f, 'm> {
    /// The stretch from a box at a time; `None` if no enclosure is found: the stretch is too long.
    ///
    /// An enclosure B is proved by the inclusion X + Σ [0, h]^j X_j + [0, h]^K B_K ⊂ B.   Source: Nedialkov,
    /// Jackson & Pryce, Reliable Computing 7, 449 (2001).
    pub(super) fn new(
        field: &'f Field<'m>,
        pieces: &[Piece],
        time: Interval,
        x: &[Interval],
        length: f64,
    ) -> Option<Self> {
        let (tape, order) = (&field.tangent.tape, field.order);
        let inside = time.middle() + 0.5 * length;
        let start = field.with_columns(x, &Square::identity(2 * field.n));
        let drives = field.drive_series(time, inside, order + 2);
        let wide = field.tangent.expand(pieces, &start, &drives, order - 1);
        let span = Interval::of_ends(0.0, length);
        let during = field.drive_series(time + span, inside, order + 2);
        let polynomial: Vec<Interval> = (0..2 * tape.dof)
            .map(|i| (0..order).rev().fold(Interval::ZERO, |sum, k| sum * span + wide.slot(i, k)))
            .collect();
        if !polynomial.iter().all(|x| x.is_bounded()) {
            return None;
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
            let rest = field.tangent.expand(pieces, &guess, &during, order);
            let proved = |(i, x): (usize, &Interval)| (*x + power * rest.slot(i, order)).lies_in(guess[i]);
            if polynomial.iter().enumerate().all(proved) {
                let pieces = pieces.to_vec();
                return Some(Stretch { field, wide, rest, length, time, inside, drives, pieces });
            }
        }
        None
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
        let (n, all) = (self.field.n, self.field.tangent.tape.dof);
        if i < n { i } else { all + i - n }
    }

    /// The coefficients of each coordinate and velocity.
    pub(super) fn series(&self) -> Vec<Vec<Interval>> {
        let of = |i| (0..=self.field.order).map(|k| self.slot(self.place(i), k)).collect();
        (0..2 * self.field.n).map(of).collect()
    }
    /// The coefficients of some forms of another tape of the same motion, evaluated as its distances from the
    /// lower edges.
    pub(super) fn series_of(&self, other: &Algebra) -> Vec<Vec<Interval>> {
        let (field, order) = (self.field, self.field.order);
        let x: Vec<Interval> = (0..2 * field.n).map(|i| self.slot(self.place(i), 0)).collect();
        let wide = other.expand(&self.pieces, &x, &self.drives, order - 1);
        let span = Interval::of_ends(0.0, self.length);
        let during = field.drive_series(self.time + span, self.inside, order + 2);
        let rest = other.expand(&self.pieces, &self.state(span), &during, order);
        let of = |form| (0..=order).map(|k| if k < order { &wide } else { &rest }.form(form, k)).collect();
        other.tape.distances.iter().filter_map(|both| both[0]).map(of).collect()
    }

    /// Coordinates and velocities at the times s after the start.
    pub(super) fn state(&self, s: Interval) -> Vec<Interval> {
        (0..2 * self.field.n).map(|i| self.sum(s, |k| self.slot(self.place(i), k))).collect()
    }
    /// The derivative of the state with respect to that at the start.
    pub(super) fn slope(&self, s: Interval) -> Square {
        let (n, all) = (self.field.n, self.field.tangent.tape.dof);
        Square::from_fn(2 * n, |i, j| {
            let slot = if i < n { n * (1 + j) + i } else { all + n * (1 + j) + i - n };
            self.sum(s, |k| self.slot(slot, k))
        })
    }
    /// The distance of a contact from an edge, positive in the gap.
    pub(super) fn distance(&self, form: FormId, s: Interval) -> Interval {
        self.sum(s, |k| self.form(form, k))
    }
    /// The rate of a distance.
    pub(super) fn rate(&self, form: FormId, s: Interval) -> Interval {
        (1..=self.field.order).rev().fold(Interval::ZERO, |sum, k| sum * s + self.form(form, k) * k as f64)
    }

    /// The states after the times `s` from the points `x` at a time within that of the stretch, both narrower
    /// than those of the stretch.
    pub(super) fn narrow(&self, time: Interval, x: &[Interval]) -> Narrow<'_, 'f, 'm> {
        let own = |drives: &[PowerSeries<Interval>]| {
            self.field.motion.expand(&self.pieces, x, drives, self.field.order - 1)
        };
        let c = match time == self.time {
            true => own(&self.drives),
            false => own(&self.field.drive_series(time, self.inside, self.field.order + 1)),
        };
        Narrow { stretch: self, c }
    }
    pub(super) fn start(&self) -> Interval {
        self.time
    }
}

/// The motion from a narrower box, with the remainder of the stretch.
pub(super) struct Narrow<'s, 'f, 'm> {
    stretch: &'s Stretch<'f, 'm>,
    c: Coefficients,
}

impl Narrow<'_, '_, '_> {
    pub(super) fn state(&self, s: Interval) -> Vec<Interval> {
        let stretch = self.stretch;
        let order = stretch.field.order;
        let of = |i: usize| {
            stretch.sum(s, |k| if k < order { self.c.slot(i, k) } else { stretch.slot(stretch.place(i), k) })
        };
        (0..2 * stretch.field.n).map(of).collect()
    }
    /// The distance of a contact from an edge: forms of the motion and of its tangent count alike.
    pub(super) fn distance(&self, motion: FormId, tangent: FormId, s: Interval) -> Interval {
        let stretch = self.stretch;
        let order = stretch.field.order;
        stretch.sum(s, |k| if k < order { self.c.form(motion, k) } else { stretch.form(tangent, k) })
    }
}
