//! The interface of the adaptive solvers.

use crate::model::{Model, State};
use crate::ode::integrate_error::IntegrateError;
use crate::ode::integrator::Integrator;
use crate::ode::outcome::Finish;
use crate::ode::step::Observer;
use crate::ode::stepping::control::{Limits, StepRule, Task, Tolerances};
use crate::ode::stepping::engine::Tableau;

/// An adaptive method: the embedded Runge-Kutta methods [`Rk45`](crate::Rk45) and [`Dop853`](crate::Dop853),
/// the Rosenbrock method [`Rodas`](crate::ode::Rodas), and [`Taylor`](crate::Taylor), which has a rule of its
/// own for the length of its steps.
///
/// A step of the others is accepted if the root mean square of e_j/(atol_j + rtol max(|y0_j|,
/// |y1_j|)) over the components j is at most 1, with the local error estimate e. A PI controller sets the
/// step size; the first step follows Hairer, Nørsett & Wanner I, Sect. II.4. Edges of the gaps are located
/// unless [`plain`](Adaptive::plain) is set. No step extends over a drive edge.
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
#[must_use = "a setting returns a new value"]
pub struct Adaptive<T> {
    pub(crate) tolerances: Tolerances,
    pub(crate) limits: Limits,
    pub(crate) method: T,
}

impl<T: Tableau> Default for Adaptive<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T> Adaptive<T> {
    /// A method with its tolerances: no maximum step, the default limits.
    pub(crate) fn of(method: T, [rtol, atol]: [f64; 2], beta: f64) -> Self {
        let tolerances = Tolerances { rtol, atol: vec![atol], first: None, max: f64::INFINITY, beta };
        Adaptive { tolerances, limits: Limits::default(), method }
    }
    /// Relative tolerance of every coordinate and velocity, above 0 and below 1; in 1e-16 ..= 0.1 for
    /// [`Taylor`](crate::Taylor). Default: 1e-9; 1e-12 for `Taylor`.
    pub fn rtol(mut self, rtol: f64) -> Self {
        self.tolerances.rtol = rtol;
        self
    }
    /// Absolute tolerance of every coordinate and velocity, positive, in the units of the model. Default:
    /// 1e-12; 1e-16 for [`Taylor`](crate::Taylor).
    pub fn atol(self, atol: f64) -> Self {
        self.atol_each(&[atol])
    }
    /// Absolute tolerance per component, 2 dof values: the coordinates, then the velocities. One value
    /// holds for all.
    pub fn atol_each(mut self, atol: &[f64]) -> Self {
        self.tolerances.atol = atol.to_vec();
        self
    }
    /// Maximum step, in the model's time unit. Default: infinite.
    pub fn max_step(mut self, step: f64) -> Self {
        self.tolerances.max = step;
        self
    }
    /// Maximum number of steps, rejected ones included. Default: 10⁸.
    pub fn max_steps(mut self, steps: usize) -> Self {
        self.limits.max_steps = steps;
        self
    }
}

impl<T: Tableau> Adaptive<T> {
    /// Defaults: rtol 1e-9, atol 1e-12, edges located, no maximum step, at most 10⁸ steps.
    pub fn new() -> Self {
        Adaptive::of(T::default(), [1e-9, 1e-12], T::BETA)
    }
    /// First step, in the model's time unit. Default: estimated from the solution and its derivatives.
    pub fn first_step(mut self, step: f64) -> Self {
        self.tolerances.first = Some(step);
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
}

/// An adaptive method with its loop over steps.
pub trait Method: Tableau {
    /// The loop over steps. It is not generic, so that this crate contains its code.
    ///
    /// # Errors
    /// [`IntegrateError`].
    fn run(task: Task<'_>) -> Result<Finish, IntegrateError>;
}

impl<T: Method> Integrator for Adaptive<T> {
    fn run(
        &self,
        model: &dyn Model,
        start: &State,
        t_end: f64,
        observer: &mut dyn Observer,
    ) -> Result<Finish, IntegrateError> {
        let (rule, limits) = (StepRule::Adaptive(&self.tolerances), self.limits);
        T::run(Task { rule, limits, model, start, t_end, observer, own: None })
    }
}
