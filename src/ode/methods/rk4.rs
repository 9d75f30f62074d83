//! The classical Runge-Kutta method.

use crate::model::{Model, State};
use crate::ode::driver::drive;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::integrator::Integrator;
use crate::ode::outcome::Finish;
use crate::ode::step::Observer;
use crate::ode::stepping::control::{Limits, StepRule, Task};
use crate::ode::stepping::engine::{Engine, Tableau};
use crate::ode::stepping::tableau_row::TableauRow;
use crate::ode::stepping::vector::Vector;

/// The classical Runge-Kutta method of order 4, with a fixed step.
///
/// Source: Hairer, Nørsett & Wanner I, Table II.1.2.
///
/// Steps end on the grid `start.t + k h`; the last one ends exactly at the end of the run. Default: edges of
/// the gaps are located and split a step in two. This preserves order 4 if the force is continuous at the
/// edge or the model offers [`pieces`](crate::model::Offers::pieces). Without pieces a force that jumps at
/// the edge leaves an error of order 1 in h at each crossing. With [`plain`](Rk4::plain), steps run across
/// the edges, as in Yao 2020. No step extends over a drive edge.
///
/// ```
/// use gear_dynamics::{Integrator, Rk4, State, model::from_fn};
/// let spring = from_fn(1, |_, q, _, a| a[0] = -q[0])?;
/// let end = Rk4::new(0.01).end(&spring, &State::new(0.0, &[1.0], &[0.0]), 1.0)?;
/// assert!((end.q[0] - 1f64.cos()).abs() < 1e-10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct Rk4 {
    step: f64,
    limits: Limits,
}

impl Rk4 {
    /// Fixed step h, in the model's time unit.
    pub fn new(step: f64) -> Self {
        Rk4 { step, limits: Limits::default() }
    }
    /// Does not locate edges of the gaps: steps run across them.
    pub fn plain(mut self) -> Self {
        self.limits.locate = false;
        self
    }
    /// Maximum number of steps. Default: 10⁸.
    pub fn max_steps(mut self, steps: usize) -> Self {
        self.limits.max_steps = steps;
        self
    }
}

impl Integrator for Rk4 {
    fn run(
        &self,
        model: &dyn Model,
        start: &State,
        t_end: f64,
        observer: &mut dyn Observer,
    ) -> Result<Finish, IntegrateError> {
        let (rule, limits) = (StepRule::Fixed(self.step), self.limits);
        drive::<Classical>(Task { rule, limits, model, start, t_end, observer, own: None })
    }
}

/// The tableau of [`Rk4`].
#[derive(Default)]
pub(crate) struct Classical;

const A2: TableauRow<1> = [(0, 1.0 / 2.0)];

const A3: TableauRow<1> = [(1, 1.0 / 2.0)];

const A4: TableauRow<1> = [(2, 1.0)];

const B: TableauRow<4> = [(0, 1.0 / 6.0), (1, 1.0 / 3.0), (2, 1.0 / 3.0), (3, 1.0 / 6.0)];

impl Tableau for Classical {
    const ADAPTIVE: bool = false;
    const SLOTS: usize = 5;
    const EVALUATIONS: u64 = 3;
    const END: usize = 4;
    const DENSE: usize = 3;
    const DENSE_EVALUATIONS: u64 = 0;
    const EXPONENT: f64 = 1.0 / 4.0;
    const FACTORS: [f64; 2] = [1.0, 1.0];
    const BETA: f64 = 0.0;
    const NODES: &'static [f64] = &[0.5, 1.0];
    const PROBE: usize = 0;

    #[inline(always)]
    fn attempt<V: Vector, const FIXED: bool>(e: &mut Engine<'_, V>) {
        e.drive_nodes::<Classical>();
        e.stage_at::<FIXED, _>(0, 1, &A2);
        e.stage_at::<FIXED, _>(0, 2, &A3);
        e.stage_at::<FIXED, _>(1, 3, &A4);
        e.advance(&B);
    }
    fn error<V: Vector>(_: &mut Engine<'_, V>) -> f64 {
        0.0
    }
    fn dense<V: Vector, const FIXED: bool>(_: &mut Engine<'_, V>) {}
}
