//! What a proof begins with: nodes, legs and the sequence of contacts, in plain numbers.

use crate::certify::flow::algebra::Coefficients;
use crate::certify::flow::field::Field;
use crate::certify::flow::leg::{Event, Leg};
use crate::certify::square::Square;
use crate::certify::unproved::Unproved;
use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::interval::number::Interval;
use crate::model::{Model, Periodic, State};
use crate::ode::Step;
use crate::periodic::ShootingOrbit;
use std::ops::ControlFlow;

/// Nodes of a closed chain with the legs between them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Proposal {
    pub(crate) legs: Vec<Leg>,
    /// Coordinates, then velocities, at the start of each leg; relative ones apart from a rigid motion.
    pub(crate) nodes: Vec<Vec<f64>>,
    /// The coordinate to which all others are relative, if a rigid motion is left out.
    pub(crate) relative_to: Option<usize>,
}

/// What ends a part of the motion.
#[derive(Clone, Debug)]
enum Mark {
    /// One crossing, or several within a window.
    Crossings(Vec<Event>),
    DriveEdge(f64),
    End,
}

/// Share of the size of the motion that the last term of a step may have `[1]`.
const LAST_TERM: f64 = 1e-14;

/// Share of its initial value that the last term of the derivative of the motion may have `[1]`: the Newton
/// operator needs it to few digits.
const LAST_SLOPE: f64 = 1e-10;

/// Distance over which the derivative of the motion is estimated, as a share of the size of the motion `[1]`.
const BESIDE: f64 = 1e-3;

/// Share of the step by that rule that is taken, since the terms over a box are larger.
const CAUTION: f64 = 0.6;

/// Marks closer to each other than this share of the period are not ordered: crossings are taken together
/// `[1]`.
const APART: f64 = 1e-9;

/// Largest number of legs.
const MOST_LEGS: usize = 100_000;

impl Proposal {
    /// The chain along an orbit. `scale`: size of the motion, of coordinates and velocities; `shorter`: the
    /// share of the steps that is taken.
    pub(crate) fn along(
        orbit: &ShootingOrbit,
        model: &dyn Periodic,
        field: &Field<'_>,
        scale: &[f64],
        shorter: f64,
    ) -> Result<Self, Unproved> {
        let turns = orbit.period_multiple() as f64;
        let period = field.drives.period() * turns;
        let (from, turn) = (orbit.states()[0].t, orbit.period());
        let crossings = crossings(orbit, model)?;
        let mut all = [crossings.clone(), edges(model, from, turn)].concat();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        // The chain starts in the middle of the longest part without a mark.
        let (mut longest, mut start, mut last) = (0.0, from, from);
        for t in all.iter().map(|mark| mark.0).chain([from + turn]) {
            if t - last > longest {
                (longest, start) = (t - last, 0.5 * (t + last));
            }
            last = t;
        }
        let first = if all.is_empty() { orbit.states()[0].clone() } else { orbit.at(model, start)? };
        // Moved to the first turn, where times are rounded least.
        let back = (first.t / turn).floor() * turn;
        let (start, behind) = ((first.t - back).max(0.0), first.t);
        let moved = |(t, mark): &(f64, Mark)| {
            let later = t - back + if *t <= behind { turn } else { 0.0 };
            let moved = |event: &Event| Event { near: event.near - t + later, ..*event };
            match mark {
                Mark::Crossings(events) => (later, Mark::Crossings(events.iter().map(moved).collect())),
                other => (later, other.clone()),
            }
        };
        let mut marks: Vec<(f64, Mark)> = crossings.iter().map(moved).collect();
        marks.extend(edges(model, start, turn));
        marks.sort_by(|a, b| a.0.total_cmp(&b.0));
        let end = Interval::from(start) + period;
        marks.push((start + turn, Mark::End));
        let marks = gathered(marks, APART * turn)?;
        let mut walk = Walk {
            field,
            scale,
            caution: CAUTION * shorter,
            legs: Vec::new(),
            nodes: Vec::new(),
            time: Interval::from(start),
            x: match &field.relative {
                None => first.q.iter().chain(&first.v).copied().collect(),
                Some(relative) => [&first.q, &first.v].map(|x| relative.coordinates(x)).concat(),
            },
            pieces: pieces(model, &first),
        };
        walk.through(&marks, end)?;
        let relative_to = field.relative.as_ref().map(|relative| relative.root);
        Ok(Proposal { legs: walk.legs, nodes: walk.nodes, relative_to })
    }
}

/// Crossings that are not ordered as one mark. Each contact crosses once, and none rebounds.
fn gathered(marks: Vec<(f64, Mark)>, apart: f64) -> Result<Vec<(f64, Mark)>, Unproved> {
    let mut all: Vec<(f64, Mark)> = Vec::with_capacity(marks.len());
    let mut last = f64::NEG_INFINITY;
    for (t, mark) in marks {
        if t - last >= apart {
            all.push((t, mark));
        } else if let (Some((_, Mark::Crossings(events))), Mark::Crossings(more)) = (all.last_mut(), &mark)
            && events.iter().chain(more).all(|event| !event.rebounds)
            && more.iter().all(|event| events.iter().all(|other| other.contact != event.contact))
        {
            events.extend(more);
        } else {
            return Err(Unproved::Together { t: last, after: t });
        }
        last = t;
    }
    Ok(all)
}

/// The pieces of all contacts at a state.
fn pieces(model: &dyn Model, state: &State) -> Vec<Piece> {
    let mut contacts = vec![Contact::default(); model.contacts()];
    let mut u = vec![0.0; model.drives()];
    model.drive(state.t, Side::After, &mut u);
    model.contact(&u, &state.q, &state.v, &mut contacts);
    contacts.iter().map(Contact::piece).collect()
}

/// Crossings along an orbit, by time.
fn crossings(orbit: &ShootingOrbit, model: &dyn Model) -> Result<Vec<(f64, Mark)>, Unproved> {
    let mut marks = Vec::new();
    let mut collect = |step: &mut Step<'_>| {
        let t = step.t1();
        marks.extend(step.crossings().iter().map(|c| {
            let event = Event { contact: c.contact, to: c.to, rebounds: c.rebounds, near: t };
            (t, Mark::Crossings(vec![event]))
        }));
        ControlFlow::Continue(())
    };
    orbit.observe(model, &mut collect)?;
    Ok(marks)
}

/// Drive edges over a turn.
fn edges(model: &dyn Model, from: f64, turn: f64) -> Vec<(f64, Mark)> {
    let mut marks = Vec::new();
    let mut t = from;
    while let Some(edge) = model.next_edge(t).filter(|edge| *edge < from + turn) {
        marks.push((edge, Mark::DriveEdge(edge)));
        t = edge;
    }
    marks
}

struct Walk<'w, 'm> {
    field: &'w Field<'m>,
    scale: &'w [f64],
    caution: f64,
    legs: Vec<Leg>,
    nodes: Vec<Vec<f64>>,
    time: Interval,
    x: Vec<f64>,
    pieces: Vec<Piece>,
}

impl Walk<'_, '_> {
    fn through(&mut self, marks: &[(f64, Mark)], end: Interval) -> Result<(), Unproved> {
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
            if let Mark::Crossings(events) = mark {
                let last = events.iter().fold(*t, |last, event| last.max(event.near));
                let (next, other) = &marks[i + 1];
                let between = matches!(other, Mark::Crossings(_));
                self.across(events, last, if between { 0.5 * (next + last) } else { *next })?;
            }
        }
        Ok(())
    }

    /// Plain legs up to a time; before a crossing the last part stays open.
    fn plain_to(&mut self, until: Interval, crossing: bool) -> Result<(), Unproved> {
        loop {
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

    /// A leg over crossings up to the time `last`, and on to a node before `next`.
    fn across(&mut self, events: &[Event], last: f64, next: f64) -> Result<(), Unproved> {
        let (start, node) = (self.time, self.x.clone());
        self.move_by(last - self.time.middle());
        let mut leg = Leg { start, end: start, pieces: self.pieces.clone(), events: events.to_vec() };
        for event in events.iter().filter(|event| event.rebounds) {
            let n = self.field.n;
            let x: Vec<Interval> = self.x.iter().map(|x| Interval::from(*x)).collect();
            let u = self.field.drive_series(Interval::from(last), last, 2);
            let (columns, delays) = (Square::identity(2 * n), vec![Interval::ZERO; 2 * n]);
            let impact = (event.contact, event.to);
            let after = self.field.rebound(impact, &leg.pieces, &x, (&columns, &delays), &u)?;
            let velocities = after.velocities.into_iter().map(Interval::middle);
            self.x[n..].iter_mut().zip(velocities).for_each(|(x, v)| *x = v);
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
        self.legs.push(Leg { start: self.time, end, pieces: self.pieces.clone(), events: Vec::new() });
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
