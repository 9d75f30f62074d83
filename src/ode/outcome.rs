//! How a run ended and what it took.

use crate::model::equations::State;

/// How a run ended.
///
/// ```
/// use gear_dynamics::{ode::{Finish, Stats}, State};
/// let finish = Finish { state: State::new(2.5, &[1.0], &[0.0]), stopped: false, stats: Stats::default() };
/// assert_eq!(finish.state.t, 2.5);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Finish {
    /// The last state.
    pub state: State,
    /// Whether the observer stopped it.
    pub stopped: bool,
    /// What it took.
    pub stats: Stats,
}

/// What a run took.
///
/// ```
/// use gear_dynamics::{Integrator, Model, Rk4, State, ode::Step};
/// use std::ops::ControlFlow;
/// struct Rest;
/// impl Model for Rest {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) { a[0] = 0.0; }
/// }
/// let mut quiet = |_: &mut Step<'_>| ControlFlow::Continue(());
/// let stats = Rk4::new(0.25).run(&Rest, &State::at_rest(1), 1.0, &mut quiet)?.stats;
/// assert_eq!((stats.steps, stats.evaluations), (4, 16));
/// # Ok::<(), gear_dynamics::ode::IntegrateError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Accepted steps.
    pub steps: u64,
    /// Rejected ones.
    pub rejected: u64,
    /// Evaluations of the acceleration.
    pub evaluations: u64,
    /// Tooth edges crossed and rigid stops met; a contact that finds itself on another piece at the start of a step, because its edges jumped or its gap is
    /// zero, is not counted.
    pub crossings: u64,
    /// Jumps of the drives met.
    pub drive_edges: u64,
}
