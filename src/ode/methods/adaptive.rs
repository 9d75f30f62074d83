//! The adaptive solvers' common face.

use crate::model::equations::{Model, State};
use crate::ode::driver::drive;
use crate::ode::error::IntegrateError;
use crate::ode::integrator::Integrator;
use crate::ode::outcome::Finish;
use crate::ode::step::Observer;
use crate::ode::stepping::control::{Limits, StepRule, Tolerances};
use crate::ode::stepping::engine::Tableau;
use std::marker::PhantomData;

/// An adaptive embedded Runge-Kutta method: [`Rk45`](crate::Rk45) or [`Dop853`](crate::Dop853).
///
/// The local error is held below `atol + rtol max(|y0|, |y1|)` per component, in the root mean square; steps follow a PI
/// controller and start as Hairer, Nørsett & Wanner I, Sect. II.4, say. Tooth edges are located unless
/// [`plain`](Adaptive::plain); jumps of the drives are never straddled.
///
/// ```
/// use gear_dynamics::Dop853;
/// let solver = Dop853::new().rtol(1e-10).atol_each(&[1e-12, 1e-9]).max_step(0.1);
/// assert_eq!(solver, solver.clone());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Adaptive<T> {
    tolerances: Tolerances,
    limits: Limits,
    tableau: PhantomData<T>,
}

impl<T: Tableau> Default for Adaptive<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Tableau> Adaptive<T> {
    /// rtol 1e-9, atol 1e-12, edges located, no limit on the step, 10⁸ steps at most.
    pub fn new() -> Self {
        let tolerances =
            Tolerances { rtol: 1e-9, atol: vec![1e-12], first: None, max: f64::INFINITY, beta: T::BETA };
        Adaptive { tolerances, limits: Limits::default(), tableau: PhantomData }
    }
    /// Relative tolerance, positive.
    pub fn rtol(mut self, rtol: f64) -> Self {
        self.tolerances.rtol = rtol;
        self
    }
    /// Absolute tolerance of every coordinate and velocity, positive.
    pub fn atol(self, atol: f64) -> Self {
        self.atol_each(&[atol])
    }
    /// Absolute tolerance per component: the coordinates, then the velocities.
    pub fn atol_each(mut self, atol: &[f64]) -> Self {
        self.tolerances.atol = atol.to_vec();
        self
    }
    /// First step, in place of the estimated one.
    pub fn first_step(mut self, step: f64) -> Self {
        self.tolerances.first = Some(step);
        self
    }
    /// Largest step.
    pub fn max_step(mut self, step: f64) -> Self {
        self.tolerances.max = step;
        self
    }
    /// β of the PI controller: 0 is pure I control.
    pub fn pi_beta(mut self, beta: f64) -> Self {
        self.tolerances.beta = beta;
        self
    }
    /// Step straight across tooth edges and leave them to the error estimate.
    pub fn plain(mut self) -> Self {
        self.limits.locate = false;
        self
    }
    /// Give up after this many steps, rejected ones included.
    pub fn max_steps(mut self, steps: usize) -> Self {
        self.limits.max_steps = steps;
        self
    }
}

impl<T: Tableau> Integrator for Adaptive<T> {
    fn run<M: Model + ?Sized, O: Observer>(
        &self,
        model: &M,
        start: &State,
        t_end: f64,
        observer: &mut O,
    ) -> Result<Finish, IntegrateError> {
        drive::<T, M>(StepRule::Adaptive(&self.tolerances), self.limits, model, start, t_end, observer)
    }
}
