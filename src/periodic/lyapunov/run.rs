//! Lyapunov exponents: the mean growth rates of small perturbations along a motion.

use crate::analysis::motion_size::MotionSize;
use crate::error::{ParameterError, check};
use crate::linear::statics::default_start;
use crate::model::equations::early;
use crate::model::period::check_period;
use crate::model::structure::drifts::Drifts;
use crate::model::{Model, Periodic, State};
use crate::ode::budget::Meter;
use crate::ode::{Budget, Integrator, Observer, Step};
use crate::periodic::flow::flow_method::{Chosen, Expansion, FlowMethod, OwnIntegrator};
use crate::periodic::flow::tangent::Tangent;
use crate::periodic::flow::variation::coarse_run;
use crate::periodic::lyapunov::exponents::{Exponents, LyapunovError};
use crate::periodic::lyapunov::growth::Growth;
use crate::periodic::lyapunov::progress::Progress;
use crate::periodic::pursuit::{Pursuit, PursuitError};
use std::ops::ControlFlow;

/// Lyapunov exponents by QR.
///
/// λ_i = lim 1/t Σ ln r_ii, with r_ii the lengths of the directions before each normalisation.
///
/// Small perturbations follow the variational equations, with their jumps at tooth edges. They are made
/// orthonormal at regular intervals.   Source: Benettin et al., Meccanica 15 (1980) 21.
///
/// The initial directions are random, so that each has components in every part of the model. Equal starts
/// give equal directions. If a direction shrinks to less than 1e-3 within a part of a period, that part is
/// halved.
///
/// A rigid mode has two exponents of zero. A rotor that only a drag holds has one, because no force depends
/// on its angle.
///
/// ```
/// use gear_dynamics::{Lyapunov, State, model::from_fn};
/// // q'' + 3 q' + 2 q = cos 2t: exponents -1 and -2
/// let swing = from_fn(1, |t, q, v, a| a[0] = (2.0 * t).cos() - 3.0 * v[0] - 2.0 * q[0])?;
/// let swing = swing.with_period(std::f64::consts::PI)?;
/// let exponents = Lyapunov::new().measure(20).run(&swing, &State::at_rest(1))?;
/// assert!((exponents.values()[0] + 1.0).abs() < 1e-7);
/// assert!((exponents.values().iter().sum::<f64>() + 3.0).abs() < 1e-7); // the mean divergence
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[must_use = "a setting returns a new value"]
pub struct Lyapunov {
    count: Option<usize>,
    settle: Option<usize>,
    align: usize,
    #[cfg_attr(feature = "serde", serde(alias = "periods"))]
    measure: usize,
    renormalisations: usize,
    flow_tolerance: f64,
    method: Chosen,
    #[cfg_attr(feature = "serde", serde(skip))]
    budget: Budget,
}

impl Default for Lyapunov {
    fn default() -> Self {
        Lyapunov::new()
    }
}

impl Lyapunov {
    /// Defaults: all exponents, 100 settling periods, 10 alignment periods, 200 measured periods, 16
    /// renormalisations per period, tolerance 1e-9, the default [`Budget`].
    pub fn new() -> Self {
        Lyapunov {
            count: None,
            settle: None,
            align: 10,
            measure: 200,
            renormalisations: 16,
            flow_tolerance: 1e-9,
            method: Chosen::ByModel,
            budget: Budget::new(),
        }
    }
    /// Computes only the `count` largest exponents. Default: all, in a sweep 1. `count = 1` is the fastest.
    pub fn count(self, count: usize) -> Self {
        Lyapunov { count: Some(count), ..self }
    }
    /// Number of settling periods before the directions are drawn. Default: 100, in a sweep 0.
    pub fn settle(self, settle: usize) -> Self {
        Lyapunov { settle: Some(settle), ..self }
    }
    /// Number of alignment periods: the directions turn into the directions of growth. Default: 10. They are
    /// counted in periods or spans, not in time: spans far below the time of the motion need more.
    pub fn align(self, align: usize) -> Self {
        Lyapunov { align, ..self }
    }
    /// Number of measured periods. Default: 200.
    pub fn measure(self, periods: usize) -> Self {
        Lyapunov { measure: periods, ..self }
    }
    /// Minimum number of renormalisations of the directions per period, 1 to 65536. Default: 16.
    pub fn renormalisations(self, renormalisations: usize) -> Self {
        Lyapunov { renormalisations, ..self }
    }
    /// Local error of the flow, as a share of the range of each coordinate and velocity `[1]`. Default: 1e-9.
    pub fn flow_tolerance(self, flow_tolerance: f64) -> Self {
        Lyapunov { flow_tolerance, ..self }
    }
    /// The method of the integration. Default: Taylor series for a model that can be expanded, DOP853 for
    /// any other.
    pub fn flow_method(self, method: FlowMethod) -> Self {
        Lyapunov { method: self.method.with(method), ..self }
    }
    /// Replaces the method: see [`Variation::integrator`](crate::periodic::Variation::integrator).
    pub fn integrator(self, integrator: impl Integrator + Send + Sync + 'static) -> Self {
        Lyapunov { method: Chosen::Own(OwnIntegrator::new(integrator)), ..self }
    }
    /// Maximum number of steps and maximum time of one call, settling included.
    pub fn budget(self, budget: Budget) -> Self {
        Lyapunov { budget, ..self }
    }

    /// The same settings with the defaults of a sweep: one exponent, and no settling periods besides those of
    /// the sweep.
    pub(crate) fn of_sweep(self) -> Self {
        Lyapunov { count: self.count.or(Some(1)), settle: self.settle.or(Some(0)), ..self }
    }

    /// Checks the settings in a sweep, whose rows contain one exponent.
    pub(crate) fn check_of_sweep(&self) -> Result<(), ParameterError> {
        check::count("count of the exponents in a sweep", &[self.count.unwrap_or(1)], 1)?;
        self.check_settings()
    }

    /// Computes the exponents along the motion from `start`; `None`: from the
    /// [static state](crate::linear::static_state).
    ///
    /// A start later than 64 periods begins at the same instant of the first period, whose time is not
    /// rounded so coarsely. [`run_over`](Lyapunov::run_over) keeps the time of its start.
    ///
    /// # Errors
    /// [`LyapunovError`]; after the checks of the settings it holds the exponents over the periods measured
    /// so far.
    pub fn run<'s>(
        &self,
        model: &dyn Periodic,
        start: impl Into<Option<&'s State>>,
    ) -> Result<Exponents, LyapunovError> {
        let mut start = match start.into() {
            Some(start) => start.clone(),
            None => default_start(model)?,
        };
        let period = model.period();
        start.t = early(start.t, period);
        start.check(model.dof())?;
        check_period(model, &start)?;
        self.run_over(model, &start, period)
    }

    /// [`run`](Lyapunov::run) for a model that is not periodic: `span` replaces the period.
    ///
    /// # Errors
    /// [`LyapunovError`]; after the checks of the settings it holds the exponents over the spans measured so
    /// far.
    pub fn run_over(&self, model: &dyn Model, start: &State, span: f64) -> Result<Exponents, LyapunovError> {
        self.run_while(model, start, span, &|| true)
    }

    /// [`run_over`](Lyapunov::run_over) while `go_on` returns `true`. Then it returns the exponents over the
    /// spans measured so far.
    pub(crate) fn run_while(
        &self,
        model: &dyn Model,
        start: &State,
        span: f64,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Exponents, LyapunovError> {
        let meter = self.meter(go_on);
        let settled = self.settled(model, start, span, &meter)?;
        let count = settled.exponents.grown.len();
        let expansion = match Expansion::new(model, count, &[], &self.method) {
            Ok(expansion) => expansion,
            Err(error) => return Err(LyapunovError::after(error.into(), settled.exponents)),
        };
        let tangent = self.tangent(model, &settled, &expansion);
        let mut progress = self.progress(&settled, start, &tangent, expansion.method());
        while let Some(target) = progress.target() {
            if !go_on() {
                break;
            }
            let state = progress.state().clone();
            let arrived = tangent
                .flow_with_fixed_tolerances(self.flow_tolerance, state, target, &meter)
                .map_err(PursuitError::from)
                .and_then(|(ahead, _)| {
                    meter.left()?;
                    progress.arrive(&ahead)
                });
            if let Err(failure) = arrived {
                return Err(LyapunovError::after(failure, progress.exponents.in_order()));
            }
        }
        Ok(progress.exponents.in_order())
    }

    /// Local error of the flow.
    pub(crate) fn tolerance(&self) -> f64 {
        self.flow_tolerance
    }
    /// Whether the flow may be integrated by Taylor series.
    pub(crate) fn allows_series(&self) -> bool {
        self.method.allows_series()
    }
    /// Number of exponents of a model with `dof` degrees of freedom.
    pub(crate) fn count_for(&self, dof: usize) -> usize {
        self.count.unwrap_or(2 * dof)
    }
    /// The work of one call, which is cancelled once `go_on` returns `false`.
    pub(crate) fn meter<'b>(&'b self, go_on: &'b dyn Fn() -> bool) -> Meter<'b> {
        self.budget.begin_while(go_on)
    }

    /// What the directions of a motion need: its state after settling, its sizes.
    ///
    /// # Errors
    /// Those of [`run`](Lyapunov::run).
    pub(crate) fn settled(
        &self,
        model: &dyn Model,
        start: &State,
        span: f64,
        meter: &Meter<'_>,
    ) -> Result<Settled, LyapunovError> {
        let (components, count) = (2 * model.dof(), self.count_for(model.dof()));
        self.check(count, components, start, span)?;
        let mut exponents = Exponents {
            span,
            grown: vec![Growth::new(self.renormalisations, self.measure); count],
            floor: 0.0,
            state: start.clone(),
            method: FlowMethod::Dop853,
        };
        let mut motion = MotionSize::new(model.dof(), &Drifts::of(model, span));
        if let Err(failure) = self.settle_down(model, span, &mut motion, &mut exponents.state, meter) {
            return Err(LyapunovError::after(failure, exponents));
        }
        exponents.floor = FLOOR * self.flow_tolerance;
        Ok(Settled { exponents, scale: motion.units(self.flow_tolerance) })
    }

    /// The flow of a motion with its directions.
    pub(crate) fn tangent<'m>(
        &self,
        model: &'m (dyn Model + 'm),
        settled: &'m Settled,
        expansion: &'m Expansion,
    ) -> Tangent<'m> {
        let count = settled.exponents.grown.len();
        Tangent::new(model, count, &[], &settled.scale, self.flow_tolerance, expansion)
    }

    /// The directions of a motion at their start.
    pub(crate) fn progress<'s>(
        &self,
        settled: &'s Settled,
        start: &State,
        tangent: &Tangent<'_>,
        method: FlowMethod,
    ) -> Progress<'s> {
        let exponents = Exponents { method, ..settled.exponents.clone() };
        let state = tangent.start(&exponents.state);
        let periods = [self.align, self.measure];
        Progress::new(
            exponents,
            state,
            start,
            &settled.scale,
            self.renormalisations,
            periods,
            self.flow_tolerance,
        )
    }

    /// Integrates the settling periods; `state` is always the last state reached. `motion` is measured over
    /// the last settling period. Without settling periods it is measured over the first period, and `state`
    /// stays at the start.
    fn settle_down(
        &self,
        model: &dyn Model,
        span: f64,
        motion: &mut MotionSize,
        state: &mut State,
        meter: &Meter<'_>,
    ) -> Result<(), PursuitError> {
        let settle = self.settle.unwrap_or(SETTLE);
        let settled = state.t + settle as f64 * span;
        if settle > 1 {
            let start = state.clone();
            let mut last = Last { state, meter };
            let finish = coarse_run(&start, &self.method, model, &start, settled - span, &mut last)?;
            *state = finish.state;
            meter.left()?;
        }
        motion.see(state.t, &state.q, &state.v);
        let start = state.clone();
        let mut ahead = start.clone();
        let mut last = Last { state: &mut ahead, meter };
        let mut along = motion.along(model);
        let mut observers = (&mut along, &mut last);
        let finish = coarse_run(&start, &self.method, model, &start, start.t + span, &mut observers);
        if settle > 0 {
            *state = ahead;
        }
        let finish = finish?;
        meter.left()?;
        if settle > 0 {
            *state = finish.state;
        }
        Ok(())
    }

    /// Checks the settings that do not depend on the model.
    pub(crate) fn check_settings(&self) -> Result<(), ParameterError> {
        let count = self.count.unwrap_or(1);
        for (name, value) in
            [("count", count), ("measure", self.measure), ("renormalisations", self.renormalisations)]
        {
            check::at_least(name, value, 1)?;
        }
        check::count("renormalisations", &[self.renormalisations], MAX_RENORMALISATIONS)?;
        check::tolerance("flow_tolerance", self.flow_tolerance).map(drop)
    }

    fn check(&self, count: usize, components: usize, start: &State, span: f64) -> Result<(), LyapunovError> {
        self.check_settings()?;
        check::at_least("degrees of freedom", components, 1)?;
        check::count("count", &[count], components)?;
        check::scale("span", span)?;
        Ok(start.check(components / 2)?)
    }
}

/// A motion after settling, before its directions are drawn.
pub(crate) struct Settled {
    pub(crate) exponents: Exponents,
    /// Units of coordinates and velocities.
    scale: Vec<f64>,
}

/// Number of settling periods outside sweeps.
const SETTLE: usize = 100;

/// Maximum number of renormalisations per period.
const MAX_RENORMALISATIONS: usize = 1 << 16;

/// Minimum standard error per period, in tolerances of the flow. The scatter of the growth does not show the
/// local errors of the flow.
const FLOOR: f64 = 10.0;

/// Stores the last state and counts the steps against the budget.
struct Last<'s> {
    state: &'s mut State,
    meter: &'s Meter<'s>,
}

impl Observer for Last<'_> {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        self.state.t = step.t1();
        self.state.q.copy_from_slice(step.q1());
        self.state.v.copy_from_slice(step.v1());
        let mut meter = self.meter;
        meter.step(step)
    }
}
