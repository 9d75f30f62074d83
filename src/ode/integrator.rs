//! The trait that all solvers implement.

use crate::model::reference::Pointer;
use crate::model::{Model, State};
use crate::ode::budget::Meter;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::outcome::Finish;
use crate::ode::step::{Observer, Step};
use crate::ode::trajectory::{Failed, Trajectory};
use std::ops::ControlFlow;

/// Runs of one model: from a start to a time, watched by an observer.
pub type Runs<'r> = dyn FnMut(&State, f64, &mut dyn Observer) -> Result<Finish, IntegrateError> + 'r;

/// Integrates the equations of motion of a model over time.
///
/// All solvers have these four methods; the analysis functions accept any `Integrator`.
///
/// ```
/// use gear_dynamics::{Integrator, Rk4, State, model::from_fn};
/// let spring = from_fn(1, |_, q, _, a| a[0] = -q[0])?;
/// let run = Rk4::new(0.01).sample(&spring, &State::new(0.0, &[1.0], &[0.0]), &[0.5, 1.0])?;
/// assert_eq!(run.times(), [0.5, 1.0]);
/// assert!((run.q(1)[0] - 1f64.cos()).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Integrator {
    /// Integrates from `start` to `t_end` and passes every accepted step to the observer. The last step ends
    /// exactly at `t_end`, unless the observer stops the run earlier.
    ///
    /// # Errors
    /// [`IntegrateError`]. The observer keeps what it received before the error.
    fn run(
        &self,
        model: &dyn Model,
        start: &State,
        t_end: f64,
        observer: &mut dyn Observer,
    ) -> Result<Finish, IntegrateError>;

    /// [`run`](Integrator::run) for many runs of one model. [`Taylor`](crate::Taylor) prepares the model at
    /// the first of them only.
    #[doc(hidden)]
    fn runs<'r>(&'r self, model: &'r dyn Model) -> Box<Runs<'r>> {
        Box::new(move |start, t_end, observer| {
            self.run(model, start, t_end, observer)?.checked(model.dof(), t_end)
        })
    }

    /// The state at `t_end`.
    ///
    /// # Errors
    /// [`IntegrateError`].
    fn end(&self, model: &dyn Model, start: &State, t_end: f64) -> Result<State, IntegrateError> {
        let finish = self.run(model, start, t_end, &mut |_: &mut Step<'_>| ControlFlow::Continue(()))?;
        Ok(finish.checked(model.dof(), t_end)?.state)
    }

    /// The start and the end of every accepted step.
    ///
    /// # Errors
    /// [`Failed`], which contains the trajectory up to the failure.
    fn trajectory(&self, model: &dyn Model, start: &State, t_end: f64) -> Result<Trajectory, Failed> {
        let mut trajectory = Trajectory::empty(model.dof(), start.t);
        if let Err(error) = start.check(model.dof()) {
            return trajectory.or_failed(Err(error.into()));
        }
        trajectory.push_state(start);
        let run = self.run(model, start, t_end, &mut |step: &mut Step<'_>| {
            trajectory.push(step.t1(), step.y1());
            ControlFlow::Continue(())
        });
        trajectory.or_failed(run.and_then(|finish| finish.checked(model.dof(), t_end)))
    }

    /// The states at the given times. The times must not decrease, and none may lie before the start.
    ///
    /// At t + k T with the period T of the drives they are the *strobed* states, a Poincaré section at a
    /// fixed phase of the drives:
    ///
    /// ```
    /// use gear_dynamics::{Dop853, Integrator, NfgPair, NfgParams, Periodic};
    /// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
    /// let turns = [1.0, 2.0, 3.0].map(|k| k * pair.period());
    /// let strobed = Dop853::new().sample(&pair, &pair.on_drive_flank()?, &turns)?;
    /// assert!((strobed.q(2)[0] - strobed.q(1)[0]).abs() < 1e-9); // nearly periodic after two turns
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`Failed`], which contains the states up to the failure.
    fn sample(&self, model: &dyn Model, start: &State, times: &[f64]) -> Result<Trajectory, Failed> {
        sample(self, model, start, times, None)
    }
}

/// `&I`, `Box<I>`, `Rc<I>` and `Arc<I>` are integrators as I is; I may be `dyn Integrator`.
impl<P: Pointer<Target: Integrator>> Integrator for P {
    fn run(
        &self,
        model: &dyn Model,
        start: &State,
        t_end: f64,
        observer: &mut dyn Observer,
    ) -> Result<Finish, IntegrateError> {
        (**self).run(model, start, t_end, observer)
    }
    fn runs<'r>(&'r self, model: &'r dyn Model) -> Box<Runs<'r>> {
        (**self).runs(model)
    }
}

/// [`Integrator::sample`], until the budget of a meter is spent.
pub(crate) fn sample<I: Integrator + ?Sized>(
    integrator: &I,
    model: &dyn Model,
    start: &State,
    times: &[f64],
    meter: Option<&Meter<'_>>,
) -> Result<Trajectory, Failed> {
    let mut trajectory = Trajectory::empty(model.dof(), start.t);
    if let Err(error) = start
        .check(model.dof())
        .map_err(IntegrateError::from)
        .and_then(|()| crate::ode::trajectory::check_times(start.t, times))
    {
        return trajectory.or_failed(Err(error));
    }
    let mut left = times;
    while let [first, rest @ ..] = left
        && *first == start.t
    {
        trajectory.push_state(start);
        left = rest;
    }
    let Some(&last) = left.last() else {
        return Ok(trajectory);
    };
    let mut y = vec![0.0; 2 * model.dof()];
    let mut keep = |step: &mut Step<'_>| {
        step.sample(&mut left, &mut y, |t, y| trajectory.push(t, y));
        match meter {
            Some(mut meter) => meter.step(step),
            None => ControlFlow::Continue(()),
        }
    };
    let run = integrator.run(model, start, last, &mut keep);
    let run = run.and_then(|finish| finish.checked(model.dof(), last)).and_then(|finish| {
        match meter.and_then(Meter::exhausted) {
            Some(exhausted) => Err(IntegrateError::Exhausted { t: finish.state.t, exhausted }),
            None => Ok(finish),
        }
    });
    trajectory.or_failed(run)
}
