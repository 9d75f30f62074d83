//! The walk along an orbit, in plain numbers: from mark to mark, by legs of a length that has an enclosure.

use crate::certify::chain::marks::{APART, Mark, MarkedTurn};
use crate::certify::flow::algebra::Coefficients;
use crate::certify::flow::field::Field;
use crate::certify::flow::leg::{Leg, LegCrossing};
use crate::certify::square::Square;
use crate::certify::unproved::Unproved;
use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::interval::number::Interval;
use crate::model::{Model, State};
use crate::ode::budget::Meter;

/// Share of the size of the motion that the last term of a step may have `[1]`.
const LAST_TERM: f64 = 1e-14;

/// Share of its initial value that the last term of the derivative of the motion may have `[1]`: the Newton
/// operator needs it to few digits.
const LAST_SLOPE: f64 = 1e-10;

/// Distance over which the derivative of the motion is estimated, as a share of the size of the motion `[1]`.
const BESIDE: f64 = 1e-3;

/// Share of the step by that rule that is taken, since the terms over a box are larger.
const CAUTION: f64 = 0.6;

/// Largest number of legs.
const MOST_LEGS: usize = 100_000;

/// The end of the walk so far, with the legs and nodes behind it.
pub(crate) struct NodeWalk<'w, 'm> {
    field: &'w Field<'m>,
    scale: &'w [f64],
    caution: f64,
    meter: &'w Meter<'w>,
    pub(crate) legs: Vec<Leg>,
    pub(crate) nodes: Vec<Vec<f64>>,
    time: Interval,
    x: Vec<f64>,
    pieces: Vec<Piece>,
}

impl<'w, 'm> NodeWalk<'w, 'm> {
    /// A walk from the start of a turn. `scale`: size of the motion, of coordinates and velocities;
    /// `shorter`: the share of the steps that is taken.
    pub(crate) fn of(
        turn: &MarkedTurn,
        model: &dyn Model,
        field: &'w Field<'m>,
        scale: &'w [f64],
        shorter: f64,
        meter: &'w Meter<'_>,
    ) -> Self {
        let State { q, v, .. } = &turn.state;
        NodeWalk {
            field,
            scale,
            caution: CAUTION * shorter,
            meter,
            legs: Vec::new(),
            nodes: Vec::new(),
            time: Interval::from(turn.start),
            x: match &field.relative {
                None => [&q[..], v].concat(),
                Some(relative) => [q, v].map(|x| relative.coordinates(x)).concat(),
            },
            pieces: pieces(model, &turn.state),
        }
    }

    /// Walks over all marks of a turn. `end`: the end of the turn, enclosed.
    pub(crate) fn through(&mut self, marks: &[(f64, Mark)], end: Interval) -> Result<(), Unproved> {
        for (i, (t, mark)) in marks.iter().enumerate() {
            let until = match mark {
                Mark::Crossings(_) => Interval::from(*t),
                // Wider than the edge, which may be found again with another rounding.
                Mark::DriveEdge(at) => {
                    let edge = self.field.drives.edge(*at);
                    edge + Interval::symmetric(edge.width())
                }
                Mark::End => end,
            };
            self.plain_to(until, matches!(mark, Mark::Crossings(_)))?;
            if let Mark::Crossings(crossings) = mark {
                let last = crossings.iter().fold(*t, |last, crossing| last.max(crossing.near));
                let (next, other) = &marks[i + 1];
                let between = matches!(other, Mark::Crossings(_));
                self.across(crossings, last, if between { 0.5 * (next + last) } else { *next })?;
            }
        }
        Ok(())
    }

    /// Adds legs without crossings up to a time; before a crossing the last part stays open.
    fn plain_to(&mut self, until: Interval, crossing: bool) -> Result<(), Unproved> {
        loop {
            self.meter.spend_slowly()?;
            let t = self.time.middle();
            let left = until.middle() - t;
            let step = self.step(t);
            let count = (left / step).ceil();
            if crossing && count <= 1.0 {
                return Ok(());
            }
            if count <= 1.0 {
                return self.leg_to(until);
            }
            self.leg_to(Interval::from(t + left / count))?;
        }
    }

    /// Adds a leg: the motion over the crossings, of which the last is at the time `last`, and on to a new
    /// node before the time `next`.
    fn across(&mut self, crossings: &[LegCrossing], last: f64, next: f64) -> Result<(), Unproved> {
        let (start, node) = (self.time, self.x.clone());
        self.move_by(last - self.time.middle());
        let mut leg = Leg { start, end: start, pieces: self.pieces.clone(), crossings: crossings.to_vec() };
        for crossing in crossings.iter().filter(|crossing| crossing.rebounds) {
            let x: Vec<Interval> = self.x.iter().map(|x| Interval::from(*x)).collect();
            let u = self.field.drive_series(Interval::from(last), last, 2);
            let (impact, none) = ((crossing.contact, crossing.to), Square::identity(0));
            let after = self.field.rebound(impact, &leg.pieces, &x, (&none, &[]), &u)?;
            let velocities = after.velocities.into_iter().map(Interval::middle);
            self.x[self.field.n..].iter_mut().zip(velocities).for_each(|(x, v)| *x = v);
        }
        self.pieces = leg.pieces_after();
        self.time = Interval::from(last);
        let step = self.step(last).min(next - last);
        let end = last + step * if next - last - step < 0.3 * step { 0.5 } else { 1.0 };
        self.move_by(end - last);
        leg.end = Interval::from(end);
        self.time = leg.end;
        self.nodes.push(node);
        self.legs.push(leg);
        Ok(())
    }

    fn leg_to(&mut self, end: Interval) -> Result<(), Unproved> {
        if self.legs.len() >= MOST_LEGS {
            return Err(Unproved::Wrapping { t: self.time.middle(), length: (end - self.time).middle() });
        }
        self.nodes.push(self.x.clone());
        self.legs.push(Leg { start: self.time, end, pieces: self.pieces.clone(), crossings: Vec::new() });
        self.move_by((end - self.time).middle());
        self.time = end;
        Ok(())
    }

    /// Coefficients from the present state, moved by a share of the size of the motion.
    fn coefficients(&self, t: f64, beside: f64) -> Coefficients {
        // Unequal shares, since equal members may not feel equal ones.
        let share = |i: usize| 1.0 - (i as f64 * 0.618_033_988_749_895).fract();
        let moved = self.x.iter().zip(self.scale).enumerate();
        let x: Vec<Interval> =
            moved.map(|(i, (x, scale))| Interval::from(x + beside * share(i) * scale)).collect();
        // Behind the edge on which the node may lie, and before the next mark.
        let inside = self.time.high().max(t) + 0.5 * APART * self.field.drives.period().middle();
        let u = self.field.drive_series(self.time, inside, self.field.order + 1);
        self.field.motion.expand(self.pieces[..].into(), &x, &u, self.field.order)
    }

    /// A step over which the last terms are negligible, those of the motion and of its derivative: the motion
    /// may be almost at rest.
    fn step(&self, t: f64) -> f64 {
        let order = self.field.order;
        let [c, beside] = [0.0, BESIDE].map(|beside| self.coefficients(t, beside));
        let last = |k: usize| {
            let share = (0..self.x.len()).map(|i| {
                let [own, other] = [&c, &beside].map(|c| c.slot(i, k).middle());
                // A law may end between the two states: NaN.
                own.abs().max((other - own).abs() / BESIDE * (LAST_TERM / LAST_SLOPE)) / self.scale[i]
            });
            (LAST_TERM / share.fold(f64::MIN_POSITIVE, f64::max)).powf(1.0 / k as f64)
        };
        self.caution * last(order).min(last(order - 1))
    }

    fn move_by(&mut self, h: f64) {
        let c = self.coefficients(self.time.middle(), 0.0);
        for (i, x) in self.x.iter_mut().enumerate() {
            *x = (0..=self.field.order).rev().fold(0.0, |sum, k| sum * h + c.slot(i, k).middle());
        }
    }
}

/// The pieces of all contacts at a state.
fn pieces(model: &dyn Model, state: &State) -> Vec<Piece> {
    let mut contacts = vec![Contact::default(); model.contacts()];
    let mut u = vec![0.0; model.drives()];
    model.drive(state.t, Side::After, &mut u);
    model.contact(&u, &state.q, &state.v, &mut contacts);
    contacts.iter().map(Contact::piece).collect()
}
