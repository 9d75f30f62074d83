//! The result of a run: last state and counts of work.

use crate::error::{ParameterError, check};
use crate::model::State;
use crate::ode::integrate_error::IntegrateError;

/// The result of a run.
///
/// ```
/// use gear_dynamics::{Integrator, Rk4, State, ode::Step, model::from_fn};
/// use std::ops::ControlFlow;
/// let fall = from_fn(1, |_, _, _, a| a[0] = -2.0)?;
/// // q = -t²: the first step that ends below -0.1 ends at t = 0.5.
/// let mut watch = |step: &mut Step<'_>| {
///     if step.q1()[0] < -0.1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
/// };
/// let finish = Rk4::new(0.25).run(&fall, &State::at_rest(1), 9.0, &mut watch)?;
/// assert_eq!((finish.state.t, finish.stopped, finish.stats.steps), (0.5, true, 2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Finish {
    /// The state at the end of the last step. If this step ends with impacts on rigid stops, the velocities
    /// are those after the impacts. A further run can start from this state.
    pub state: State,
    /// Whether the observer stopped the run.
    pub stopped: bool,
    /// Counts of steps, evaluations and crossings.
    pub stats: Stats,
}

impl Finish {
    /// Checks the end of a run, whose solver may be that of a user: the state has `dof` coordinates and is
    /// finite, and the run ends at `t_end` unless the observer stopped it.
    ///
    /// # Errors
    /// [`IntegrateError`] if it does not.
    pub(crate) fn checked(self, dof: usize, t_end: f64) -> Result<Finish, IntegrateError> {
        let State { t, q, v } = &self.state;
        check::length("coordinates of the state in which the integrator ends", q.len(), dof)?;
        check::length("velocities of the state in which the integrator ends", v.len(), dof)?;
        if let Some(component) = q.iter().chain(v).position(|y| !y.is_finite()) {
            return Err(IntegrateError::NotFinite { t: *t, component });
        }
        let off = (t - t_end).abs();
        if !self.stopped && (off.is_nan() || off > LAST * t_end.abs()) {
            let must = format!("be {t_end:?}, the end that was asked for");
            let name = "time at which the integrator ends".into();
            return Err(ParameterError::Wrong { name, value: *t, must }.into());
        }
        Ok(self)
    }
}

/// Rounding of the time at which a run ends, as a share of it `[1]`.
const LAST: f64 = 16.0 * f64::EPSILON;

/// Counts of the work done in one run.
///
/// ```
/// use gear_dynamics::{Integrator, Rk4, State, ode::Step, model::from_fn};
/// use std::ops::ControlFlow;
/// let rest = from_fn(1, |_, _, _, a| a[0] = 0.0)?;
/// let mut quiet = |_: &mut Step<'_>| ControlFlow::Continue(());
/// let stats = Rk4::new(0.25).run(&rest, &State::at_rest(1), 1.0, &mut quiet)?.stats;
/// assert_eq!((stats.steps, stats.evaluations), (4, 16));
/// # Ok::<(), gear_dynamics::ode::IntegrateError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Stats {
    /// Number of accepted steps.
    pub steps: u64,
    /// Number of rejected steps.
    pub rejected: u64,
    /// Number of evaluations of the accelerations, with those for the rates of inner kinks of contact laws;
    /// for [`Taylor`](crate::Taylor) the orders count as evaluations.
    pub evaluations: u64,
    /// Number of crossings of edges and of impacts on rigid stops. A change of piece at the start of a step,
    /// because the edges jumped or the gap is zero, is not counted.
    pub crossings: u64,
    /// Number of drive edges passed.
    pub drive_edges: u64,
}

impl Stats {
    /// Adds the work of another run.
    pub(crate) fn add(&mut self, other: &Stats) {
        self.steps += other.steps;
        self.rejected += other.rejected;
        self.evaluations += other.evaluations;
        self.crossings += other.crossings;
        self.drive_edges += other.drive_edges;
    }
}
