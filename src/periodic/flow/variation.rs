//! The flow and its derivative with respect to the start.

use crate::analysis::motion_size::MotionSize;
use crate::error::check;
use crate::model::structure::drifts::Drifts;
use crate::model::{Model, State};
use crate::ode::budget::Meter;
use crate::ode::{Budget, Finish, IntegrateError, Integrator, Observer, Step, Taylor};
use crate::periodic::flow::continued::Continued;
use crate::periodic::flow::flow_method::{Accuracy, Chosen, Expansion, FlowMethod, OwnIntegrator};
use crate::periodic::flow::tangent::Tangent;
use nalgebra::DMatrix;
use std::ops::ControlFlow;

/// δx' = ∂f/∂x δx between edges; δx⁺ = δx + (f⁺ - f⁻) (∇h·δx)/h' at an edge.
///
/// Integrates a model and the derivative of its motion with respect to the start. Tooth edges are located.
/// Where a contact force jumps, the derivative jumps by the saltation matrix.
///
/// Both accelerations at an edge come from [`accel_on_pieces`](Model::accel_on_pieces). If the model does not
/// implement it, they are computed from the accelerations on the two sides of the edge.
///
/// ```
/// use gear_dynamics::{State, periodic::Variation, model::from_fn};
/// let spring = from_fn(1, |_, q, _, a| a[0] = -q[0])?;
/// let turn = Variation::new().run(&spring, &State::new(0.0, &[1.0], &[0.0]), 1.0)?;
/// assert!((turn.matrix[(0, 1)] - 1f64.sin()).abs() < 1e-9); // ∂q(1)/∂v(0)
/// # Ok::<(), gear_dynamics::ode::IntegrateError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct Variation {
    flow_tolerance: f64,
    budget: Budget,
    method: Chosen,
}

impl Default for Variation {
    fn default() -> Self {
        Variation::new()
    }
}

impl Variation {
    /// Defaults: tolerance 1e-12, the default [`Budget`], the method by the model.
    pub fn new() -> Self {
        Variation { flow_tolerance: 1e-12, budget: Budget::new(), method: Chosen::ByModel }
    }
    /// Local error of the motion, as a share of the range of each coordinate and velocity `[1]`, in [1e-16,
    /// 1). Default: 1e-12. The rounding error of the terms replaces it where that is larger.
    ///
    /// The local error of the derivative is ten times larger, as a share of the current size of each column.
    pub fn flow_tolerance(self, flow_tolerance: f64) -> Self {
        Variation { flow_tolerance, ..self }
    }
    /// The method. Default: Taylor series for a model that can be expanded, DOP853 for any other.
    pub fn flow_method(self, method: FlowMethod) -> Self {
        Variation { method: self.method.with(method), ..self }
    }
    /// Integrates the motion with its derivatives by an integrator of one's own, with its own steps and
    /// tolerances instead of `flow_tolerance`. The variational equations are a model for it. Where it reports
    /// [crossings](crate::ode::Step::crossings), the derivatives jump as they must; edges that it does not
    /// locate leave errors of its steps. The default method measures the ranges of motion, and reads results
    /// along orbits.
    pub fn integrator(self, integrator: impl Integrator + Send + Sync + 'static) -> Self {
        Variation { method: Chosen::Own(OwnIntegrator::new(integrator)), ..self }
    }
    /// Maximum number of steps and maximum time of a run.
    pub fn budget(self, budget: Budget) -> Self {
        Variation { budget, ..self }
    }

    /// Integrates from `start` to `t_end`.
    ///
    /// # Errors
    /// [`IntegrateError`].
    pub fn run(&self, model: &dyn Model, start: &State, t_end: f64) -> Result<Transition, IntegrateError> {
        check::tolerance("flow_tolerance", self.flow_tolerance)?;
        start.check(model.dof())?;
        let meter = self.budget.begin();
        let mut motion = MotionSize::new(model.dof(), &Drifts::default());
        motion.see(start.t, &start.q, &start.v);
        metered(start, &self.method, model, start, t_end, &mut motion.along(model), &meter)?;
        let scale = motion.units(self.flow_tolerance);
        let expansion = Expansion::new(model, scale.len(), &[], &self.method)?;
        let flow = Tangent::new(model, scale.len(), &[], &scale, self.flow_tolerance, &expansion);
        let (state, scaled, crossings) = transition(&flow, self.flow_tolerance, start, t_end, &meter)?;
        Ok(Transition { state, matrix: unscaled(&scaled, &scale), crossings, method: expansion.method() })
    }
}

/// Result of [`Variation`]: the end of a run and its derivative with respect to the start.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, periodic::Variation};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let through = Variation::new().run(&pair, &pair.on_drive_flank()?, 10.0)?;
/// assert_eq!(through.crossings, 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Transition {
    /// State at the end.
    pub state: State,
    /// ∂(q, v)(t1)/∂(q, v)(t0), in the units of the model.
    pub matrix: DMatrix<f64>,
    /// Number of tooth edges crossed.
    pub crossings: u64,
    /// The method of the integration.
    pub method: FlowMethod,
}

/// The coarse run that measures the ranges of motion: tolerance 1e-9, by the method that is chosen or by
/// the one that the model allows. `first`: a state whose size is that of the motion.
pub(crate) fn coarse_run(
    first: &State,
    chosen: &Chosen,
    model: &dyn Model,
    start: &State,
    t_end: f64,
    observer: &mut dyn Observer,
) -> Result<Finish, IntegrateError> {
    let (atol, order) = (1e-12 * largest(first), Taylor::order_for(1e-9));
    let accuracy = Accuracy { rtol: 1e-9, atol: &[atol], order, first: 0.0 };
    let mut watch = |step: &mut Step<'_>| observer.step(step);
    Expansion::of_motion(model, chosen).run(&accuracy, model, start, t_end, &mut watch)
}

/// max |q_i|, |v_i|; 1 if that is 0 or not finite.
fn largest(start: &State) -> f64 {
    let largest = start.q.iter().chain(&start.v).fold(0.0, |m: f64, x| m.max(x.abs()));
    if largest > 0.0 && largest.is_finite() { largest } else { 1.0 }
}

/// A [`coarse_run`] within a budget.
pub(crate) fn metered(
    first: &State,
    chosen: &Chosen,
    model: &dyn Model,
    start: &State,
    t_end: f64,
    observer: &mut dyn Observer,
    meter: &Meter<'_>,
) -> Result<State, IntegrateError> {
    let crude = vec![largest(start); 2 * model.dof()];
    let (model, mut spend) = (&Continued::new(model, &crude), meter);
    let mut watch = |step: &mut Step<'_>| {
        if observer.step(step).is_break() { ControlFlow::Break(()) } else { spend.step(step) }
    };
    let finish = coarse_run(first, chosen, model, start, t_end, &mut watch)?;
    meter.left().map_err(|exhausted| IntegrateError::Exhausted { t: finish.state.t, exhausted })?;
    Ok(finish.state)
}

/// The end state of a run, its derivative S⁻¹ X S in units of `scale` (S = diag(scale)) followed by the
/// columns S⁻¹ ∂x/∂p of the parameters, and the number of crossings.
pub(crate) fn transition(
    tangent: &Tangent<'_>,
    tolerance: f64,
    start: &State,
    t_end: f64,
    meter: &Meter<'_>,
) -> Result<(State, DMatrix<f64>, u64), IntegrateError> {
    let scale = tangent.scale;
    let (end, crossings) = tangent.flow(tolerance, tangent.start(start), t_end, meter, None)?;
    let matrix = DMatrix::from_fn(scale.len(), tangent.columns, |i, k| tangent.scaled(&end, i, k));
    Ok((tangent.motion(&end), matrix, crossings))
}

/// S X S⁻¹, S = diag(scale): from units of `scale` to the units of the model.
pub(crate) fn unscaled(scaled: &DMatrix<f64>, scale: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(scale.len(), scale.len(), |i, j| scaled[(i, j)] * scale[i] / scale[j])
}
