//! The trait of all solvers.

use crate::model::equations::{Model, State};
use crate::ode::error::IntegrateError;
use crate::ode::outcome::Finish;
use crate::ode::step::{Observer, Step};
use crate::ode::trajectory::{Failed, Trajectory};
use std::ops::ControlFlow;

/// Advances a model in time. Every solver offers the same five calls; analysis is written against this trait.
///
/// ```
/// use gear_dynamics::{Integrator, Model, Rk4, State};
/// struct Spring;
/// impl Model for Spring {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) { a[0] = -q[0]; }
/// }
/// let run = Rk4::new(0.01).sample(&Spring, &State::new(0.0, &[1.0], &[0.0]), &[0.5, 1.0])?;
/// assert_eq!(run.times(), [0.5, 1.0]);
/// assert!((run.q(1)[0] - 1f64.cos()).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Integrator {
    /// Runs from `start` to `t_end`, which is hit exactly, showing every accepted step to the observer.
    ///
    /// # Errors
    /// [`IntegrateError`]; what the observer has seen until then is still with the observer.
    fn run<M: Model + ?Sized, O: Observer>(
        &self,
        model: &M,
        start: &State,
        t_end: f64,
        observer: &mut O,
    ) -> Result<Finish, IntegrateError>;

    /// The state at `t_end`.
    ///
    /// # Errors
    /// [`IntegrateError`].
    fn end<M: Model + ?Sized>(&self, model: &M, start: &State, t_end: f64) -> Result<State, IntegrateError> {
        self.run(model, start, t_end, &mut |_: &mut Step<'_>| ControlFlow::Continue(()))
            .map(|finish| finish.state)
    }

    /// Every accepted step, the start included.
    ///
    /// # Errors
    /// [`Failed`], which holds the trajectory up to the failure.
    fn trajectory<M: Model + ?Sized>(
        &self,
        model: &M,
        start: &State,
        t_end: f64,
    ) -> Result<Trajectory, Failed> {
        let mut trajectory = Trajectory::empty(model.dof(), start.t);
        if let Err(error) = start.check(model.dof()) {
            return trajectory.or_failed(Err(error.into()));
        }
        trajectory.push_state(start);
        let run = self.run(model, start, t_end, &mut |step: &mut Step<'_>| {
            trajectory.push(step.t1(), step.y1());
            ControlFlow::Continue(())
        });
        trajectory.or_failed(run)
    }

    /// The states at given increasing times, none before the start.
    ///
    /// # Errors
    /// [`Failed`], which holds the states up to the failure.
    fn sample<M: Model + ?Sized>(
        &self,
        model: &M,
        start: &State,
        times: &[f64],
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
            while let [t, rest @ ..] = left
                && *t <= step.t1()
            {
                step.at(*t, &mut y);
                trajectory.push(*t, &y);
                left = rest;
            }
            ControlFlow::Continue(())
        };
        let run = self.run(model, start, last, &mut keep);
        trajectory.or_failed(run)
    }
}
