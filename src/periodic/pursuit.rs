//! The interface between the flow with its derivative and what it is integrated for.

use crate::model::State;
use crate::ode::{Exhausted, IntegrateError};

/// What the flow with its derivative is integrated for, interval by interval: exponents, or an orbit.
/// Whoever integrates asks for the [`target`](Pursuit::target), integrates from [`state`](Pursuit::state) to
/// it and reports the [`arrive`](Pursuit::arrive)d state.
pub(crate) trait Pursuit {
    /// Motion and differences at the start of the interval.
    fn state(&self) -> &State;
    /// The end of the interval; `None` if all is done.
    fn target(&self) -> Option<f64>;
    /// Local error of the flow in the interval.
    fn tolerance(&self) -> f64;
    /// Takes the state at the target. Returns whether the motion goes on from there: if not, the flow starts
    /// again at [`state`](Pursuit::state).
    ///
    /// # Errors
    /// A direction that vanishes.
    fn arrive(&mut self, ahead: &State) -> Result<bool, PursuitError>;
}

/// Errors of a pursuit, without what was computed before.
pub(crate) enum PursuitError {
    Integrate(IntegrateError),
    Exhausted(Exhausted),
    Vanished { direction: usize, t: f64 },
}

impl From<IntegrateError> for PursuitError {
    fn from(error: IntegrateError) -> Self {
        PursuitError::Integrate(error)
    }
}

impl From<Exhausted> for PursuitError {
    fn from(exhausted: Exhausted) -> Self {
        PursuitError::Exhausted(exhausted)
    }
}
