//! What shooting starts from: checked states at the nodes, the ranges of motion, the rigid modes.

use super::ShootingError;
use super::rigid::rigid_modes;
use super::size::Sizes;
use super::variation::coarse;
use crate::error::{ParameterError, check};
use crate::model::{Model, Periodic, State};
use crate::ode::{IntegrateError, Integrator};

/// What is wanted of the guess.
pub(super) struct Plan {
    pub(super) multiple: usize,
    pub(super) segments: Option<usize>,
}

pub(super) struct Guess {
    pub(super) states: Vec<State>,
    /// Ranges of coordinates and velocities, rigid motion left out.
    pub(super) scale: Vec<f64>,
    pub(super) rigid: Vec<Vec<f64>>,
    pub(super) end: f64,
}

/// Steps of a run per segment, when the number of segments is left open.
const STEPS: usize = 32;
const MOST: usize = 128;
/// A last state this close to the end, in shares of the period, is the first one again.
const SAME: f64 = 1e-9;

impl Guess {
    pub(super) fn of(model: &dyn Periodic, plan: &Plan, guess: &[State]) -> Result<Guess, ShootingError> {
        let Some(first) = guess.first() else {
            return Err(ParameterError::Empty { name: "guess".into(), least: 1 }.into());
        };
        let period = plan.multiple as f64 * check::scale("period of the model", model.period())?;
        let end = first.t + period;
        let mut states = guess.to_vec();
        if states.len() > 1 && states.last().is_some_and(|last| (last.t - end).abs() <= SAME * period) {
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
        let rigid = rigid_modes(model, period);
        let mut sizes = Sizes::new(model.dof(), &rigid);
        let solver = coarse(first);
        let fail = |segment: usize, error: IntegrateError, states: &[State]| ShootingError::Flow {
            segment,
            error,
            last: super::Iterate { states: states.to_vec(), corrections: Vec::new() },
        };
        for (i, state) in states.iter().enumerate() {
            sizes.see(state.t, &state.q, &state.v);
            let until = states.get(i + 1).map_or(end, |next| next.t);
            solver.run(model, state, until, &mut sizes).map_err(|error| fail(i, error, &states))?;
        }
        if states.len() == 1 {
            let count = plan.segments.unwrap_or((sizes.steps / STEPS).clamp(1, MOST));
            let times: Vec<f64> = (0..count).map(|i| first.t + period * (i as f64 / count as f64)).collect();
            let run = solver.sample(model, first, &times).map_err(|failed| fail(0, failed.error, &states))?;
            states = (0..run.len()).map(|i| run.state(i)).collect();
        }
        Ok(Guess { states, scale: sizes.ranges(), rigid, end })
    }
}
