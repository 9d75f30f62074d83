//! What divides a turn of an orbit: crossings and drive edges.

use crate::certify::flow::leg::LegCrossing;
use crate::certify::unproved::Unproved;
use crate::model::{Model, State};
use crate::ode::Step;
use crate::ode::budget::Meter;
use crate::periodic::ShootingOrbit;
use std::ops::ControlFlow;

/// What ends a part of the motion.
#[derive(Clone, Debug)]
pub(crate) enum Mark {
    /// One crossing, or several within a window.
    Crossings(Vec<LegCrossing>),
    DriveEdge(f64),
    End,
}

/// Marks closer to each other than this share of the period are not ordered: crossings are taken together
/// `[1]`.
pub(crate) const APART: f64 = 1e-9;

/// One turn of an orbit, from the middle of the longest part without a mark.
pub(crate) struct MarkedTurn {
    /// When the turn starts, moved by whole turns to where times are rounded least.
    pub(crate) start: f64,
    /// The state there, at the time of the orbit.
    pub(crate) state: State,
    /// By time; the last one is the end of the turn.
    pub(crate) marks: Vec<(f64, Mark)>,
}

impl MarkedTurn {
    pub(crate) fn of(orbit: &ShootingOrbit, model: &dyn Model, meter: &Meter<'_>) -> Result<Self, Unproved> {
        let (from, turn) = (orbit.states()[0].t, orbit.period());
        let crossings = crossings(orbit, model, meter)?;
        let mut all = [crossings.clone(), edges(model, from, turn, meter)?].concat();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut longest, mut middle, mut last) = (0.0, from, from);
        for t in all.iter().map(|mark| mark.0).chain([from + turn]) {
            if t - last > longest {
                (longest, middle) = (t - last, 0.5 * (t + last));
            }
            last = t;
        }
        let state =
            if all.is_empty() { orbit.states()[0].clone() } else { orbit.state_at(model, middle, meter)? };
        let back = (state.t / turn).floor() * turn;
        let start = (state.t - back).max(0.0);
        let moved = |(t, mark): &(f64, Mark)| {
            let later = t - back + if *t <= state.t { turn } else { 0.0 };
            let moved = |crossing: &LegCrossing| LegCrossing { near: crossing.near - t + later, ..*crossing };
            match mark {
                Mark::Crossings(crossings) => (later, Mark::Crossings(crossings.iter().map(moved).collect())),
                other => (later, other.clone()),
            }
        };
        let mut marks: Vec<(f64, Mark)> = crossings.iter().map(moved).collect();
        marks.extend(edges(model, start, turn, meter)?);
        marks.sort_by(|a, b| a.0.total_cmp(&b.0));
        marks.push((start + turn, Mark::End));
        Ok(MarkedTurn { start, state, marks: gathered(marks, APART * turn)? })
    }
}

/// Crossings that are not ordered as one mark. Each contact crosses once, and none rebounds.
fn gathered(marks: Vec<(f64, Mark)>, apart: f64) -> Result<Vec<(f64, Mark)>, Unproved> {
    let mut all: Vec<(f64, Mark)> = Vec::with_capacity(marks.len());
    let mut last = f64::NEG_INFINITY;
    for (t, mark) in marks {
        if t - last >= apart {
            all.push((t, mark));
        } else if let (Some((_, Mark::Crossings(crossings))), Mark::Crossings(more)) = (all.last_mut(), &mark)
            && crossings.iter().chain(more).all(|crossing| !crossing.rebounds)
            && more.iter().all(|crossing| crossings.iter().all(|other| other.contact != crossing.contact))
        {
            crossings.extend(more);
        } else {
            return Err(Unproved::Together { t: last, after: t });
        }
        last = t;
    }
    Ok(all)
}

/// Crossings along an orbit, by time.
fn crossings(
    orbit: &ShootingOrbit,
    model: &dyn Model,
    meter: &Meter<'_>,
) -> Result<Vec<(f64, Mark)>, Unproved> {
    let mut marks = Vec::new();
    let mut collect = |step: &mut Step<'_>| {
        let t = step.t1();
        marks.extend(step.crossings().iter().map(|c| {
            let crossing = LegCrossing { contact: c.contact, to: c.to, rebounds: c.rebounds, near: t };
            (t, Mark::Crossings(vec![crossing]))
        }));
        ControlFlow::Continue(())
    };
    orbit.observe_within(model, &mut collect, meter)?;
    Ok(marks)
}

/// Drive edges over a turn.
fn edges(model: &dyn Model, from: f64, turn: f64, meter: &Meter<'_>) -> Result<Vec<(f64, Mark)>, Unproved> {
    let mut marks = Vec::new();
    let mut t = from;
    while let Some(edge) = model.next_edge(t).filter(|edge| *edge < from + turn) {
        meter.spend()?;
        marks.push((edge, Mark::DriveEdge(edge)));
        t = edge;
    }
    Ok(marks)
}
