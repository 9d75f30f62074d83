//! The initial guess of shooting: checked states at the nodes, the ranges of motion, the drifts.

use crate::analysis::motion_size::MotionSize;
use crate::error::check;
use crate::linear::statics::default_start;
use crate::model::equations::early;
use crate::model::period::check_period;
use crate::model::structure::drifts::Drifts;
use crate::model::{Model, Periodic, State};
use crate::ode::budget::Meter;
use crate::ode::{IntegrateError, Step};
use crate::periodic::flow::flow_method::Chosen;
use crate::periodic::flow::variation::metered;
use crate::periodic::shooting::failure::{Iterate, ShootingError};
use std::ops::ControlFlow;

/// Settings of shooting that the guess depends on.
pub(crate) struct NodePlan {
    pub(crate) multiple: usize,
    pub(crate) segments: Option<usize>,
    pub(crate) flow_tolerance: f64,
    pub(crate) method: Chosen,
}

pub(crate) struct Guess {
    pub(crate) states: Vec<State>,
    /// Units of coordinates and velocities without drifts, then the ranges.
    pub(crate) scales: [Vec<f64>; 2],
    pub(crate) drifts: Drifts,
    /// Time at which the orbit closes.
    pub(crate) end: f64,
}

/// Default number of segments: one per 32 steps of the coarse run, at most 128.
const STEPS_PER_SEGMENT: usize = 32;

const MAX_SEGMENTS: usize = 128;

/// A last state within this share of the period of the end repeats the first state and is dropped.
const SAME_TIME: f64 = 1e-9;

impl Guess {
    pub(crate) fn of(
        model: &dyn Periodic,
        plan: &NodePlan,
        guess: &[State],
        meter: &Meter<'_>,
    ) -> Result<Guess, ShootingError> {
        let period = plan.multiple as f64 * check::scale("period of the model", model.period())?;
        let mut states = guess.to_vec();
        if states.is_empty() {
            states.push(default_start(model).map_err(ShootingError::NoStaticState)?);
        }
        let moved = states[0].t - early(states[0].t, period);
        if moved != 0.0 {
            states.iter_mut().for_each(|state| state.t -= moved);
        }
        let first = &states[0].clone();
        first.check(model.dof())?;
        check_period(model, first)?;
        let end = first.t + period;
        if states.len() > 1 && states.last().is_some_and(|last| (last.t - end).abs() <= SAME_TIME * period) {
            states.pop();
        }
        let mut after = f64::NEG_INFINITY;
        for (index, state) in states.iter().enumerate() {
            state.check(model.dof())?;
            if !(state.t > after && state.t < end) {
                return Err(ShootingError::GuessTime { index, time: state.t, from: first.t, to: end });
            }
            after = state.t;
        }
        if let Some(wanted) = plan.segments.filter(|wanted| *wanted < states.len()) {
            states = (0..wanted).map(|i| states[i * states.len() / wanted].clone()).collect();
        }
        let model: &dyn Model = model;
        let drifts = Drifts::of(model, period);
        let mut motion = MotionSize::new(model.dof(), &drifts);
        let fail = |segment: usize, error: IntegrateError, states: &[State]| {
            let last = Iterate { states: states.to_vec(), corrections: Vec::new() };
            ShootingError::of_segment(segment, error, last)
        };
        for (i, state) in states.iter().enumerate() {
            motion.see(state.t, &state.q, &state.v);
            let until = states.get(i + 1).map_or(end, |next| next.t);
            metered(first, &plan.method, model, state, until, &mut motion.along(model), meter)
                .map_err(|error| fail(i, error, &states))?;
        }
        if states.len() == 1 {
            let count = plan.segments.unwrap_or((motion.steps / STEPS_PER_SEGMENT).clamp(1, MAX_SEGMENTS));
            let times: Vec<f64> = (0..count).map(|i| first.t + period * (i as f64 / count as f64)).collect();
            let (mut nodes, mut y) = (vec![first.clone()], vec![0.0; 2 * model.dof()]);
            let mut left = &times[1..];
            let mut keep = |step: &mut Step<'_>| {
                step.sample(&mut left, &mut y, |t, y| {
                    let (q, v) = y.split_at(model.dof());
                    nodes.push(State::new(t, q, v));
                });
                ControlFlow::Continue(())
            };
            if let Some(&last) = times[1..].last() {
                metered(first, &plan.method, model, first, last, &mut keep, meter)
                    .map_err(|error| fail(0, error, &states))?;
            }
            states = nodes;
        }
        let scales = [motion.units(plan.flow_tolerance), motion.ranges()];
        Ok(Guess { states, scales, drifts, end })
    }
}
