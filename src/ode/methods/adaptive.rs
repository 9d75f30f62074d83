//! The interface of the adaptive solvers.

use crate::model::equations::Model;
use crate::model::state::State;
use crate::ode::driver::drive;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::integrator::Integrator;
use crate::ode::outcome::Finish;
use crate::ode::step::Observer;
use crate::ode::stepping::control::{Limits, StepRule, Tolerances};
use crate::ode::stepping::engine::Tableau;
use std::marker::PhantomData;

/// An adaptive embedded Runge-Kutta method: [`Rk45`](crate::Rk45) or [`Dop853`](crate::Dop853).
///
/// A step is accepted if the root mean square of e_j/(atol_j + rtol max(|y0_j|, |y1_j|)) over the components
/// j is at most 1, with the local error estimate e. A PI controller sets the step size; the first step
/// follows Hairer, Nørsett & Wanner I, Sect. II.4. Edges of the gaps are located unless
/// [`plain`](Adaptive::plain) is set. No step extends over a drive edge.
///
/// ```
/// use gear_dynamics::{Dop853, Integrator, State, model::from_fn};
/// let spring = from_fn(1, |_, q, _, a| a[0] = -q[0])?;
/// let solver = Dop853::new().rtol(1e-10).atol_each(&[1e-12, 1e-9]).max_step(0.1);
/// let end = solver.end(&spring, &State::new(0.0, &[1.0], &[0.0]), 1.0)?;
/// assert!((end.q[0] - 1f64.cos()).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
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
    /// Defaults: rtol 1e-9, atol 1e-12, edges located, no maximum step, at most 10⁸ steps.
    pub fn new() -> Self {
        let tolerances =
            Tolerances { rtol: 1e-9, atol: vec![1e-12], first: None, max: f64::INFINITY, beta: T::BETA };
        Adaptive { tolerances, limits: Limits::default(), tableau: PhantomData }
    }
    /// Relative tolerance, positive. Default: 1e-9.
    pub fn rtol(mut self, rtol: f64) -> Self {
        self.tolerances.rtol = rtol;
        self
    }
    /// Absolute tolerance of every coordinate and velocity, positive, in the units of the model. Default:
    /// 1e-12.
    pub fn atol(self, atol: f64) -> Self {
        self.atol_each(&[atol])
    }
    /// Absolute tolerance per component, 2 dof values: the coordinates, then the velocities.
    pub fn atol_each(mut self, atol: &[f64]) -> Self {
        self.tolerances.atol = atol.to_vec();
        self
    }
    /// First step, in the model's time unit. Default: estimated from the solution and its derivatives.
    pub fn first_step(mut self, step: f64) -> Self {
        self.tolerances.first = Some(step);
        self
    }
    /// Maximum step, in the model's time unit. Default: infinite.
    pub fn max_step(mut self, step: f64) -> Self {
        self.tolerances.max = step;
        self
    }
    /// β of the PI controller, in [0, 0.2); 0 is pure I control. Default: 0.04 for `Rk45`, 0.03 for `Dop853`.
    pub fn pi_beta(mut self, beta: f64) -> Self {
        self.tolerances.beta = beta;
        self
    }
    /// Does not locate edges of the gaps: steps run across them, controlled by the error estimate only.
    pub fn plain(mut self) -> Self {
        self.limits.locate = false;
        self
    }
    /// Maximum number of steps, rejected ones included. Default: 10⁸.
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
