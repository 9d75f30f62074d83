//! The flow with its derivative.

use super::size::Sizes;
use super::tangent::Tangent;
use crate::model::{Model, State};
use crate::ode::{Dop853, IntegrateError, Integrator};
use nalgebra::DMatrix;

/// Runs a model together with the derivative of its motion by the start, tooth edges handled: located, and with the jump of the
/// derivative (saltation matrix) where a contact force jumps.
///
/// δx' = ∂f/∂x δx between edges; δx⁺ = δx + (f⁺ - f⁻) (∇h·δx)/h' across them.
///
/// A force that jumps is seen through [`accel_on_pieces`](Model::accel_on_pieces); a model without it is taken to be continuous.
///
/// ```
/// use gear_dynamics::{Model, State, Variation};
/// struct Spring;
/// impl Model for Spring {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) { a[0] = -q[0]; }
/// }
/// let turn = Variation::new().run(&Spring, &State::new(0.0, &[1.0], &[0.0]), 1.0)?;
/// assert!((turn.matrix[(0, 1)] - 1f64.sin()).abs() < 1e-9); // ∂q(1)/∂v(0)
/// # Ok::<(), gear_dynamics::IntegrateError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variation {
    tolerance: f64,
}

impl Default for Variation {
    fn default() -> Self {
        Variation::new()
    }
}

impl Variation {
    /// To 1e-12 of the range of motion.
    pub fn new() -> Self {
        Variation { tolerance: 1e-12 }
    }
    /// Local error of the motion, as a share of the range of each coordinate and velocity; that of the derivative is ten times
    /// larger.
    pub fn tolerance(self, tolerance: f64) -> Self {
        Variation { tolerance }
    }

    /// From `start` to `t_end`.
    ///
    /// # Errors
    /// [`IntegrateError`].
    pub fn run<M: Model + ?Sized>(&self, model: &M, start: &State, t_end: f64) -> Result<Transition, IntegrateError> {
        self.run_any(&model, start, t_end)
    }

    fn run_any(&self, model: &dyn Model, start: &State, t_end: f64) -> Result<Transition, IntegrateError> {
        let mut sizes = Sizes::new(model.dof(), &[]);
        coarse(start).run(model, start, t_end, &mut sizes)?;
        sizes.see(start.t, &start.q, &start.v);
        let scale = sizes.ranges();
        let (state, scaled, crossings) = transition(model, &scale, self.tolerance, start, t_end)?;
        Ok(Transition { state, matrix: unscaled(&scaled, &scale), crossings })
    }
}

/// A run over a span of time and its derivative by the start.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, Variation};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let through = Variation::new().run(&pair, &pair.static_start()?, 10.0)?;
/// assert_eq!(through.crossings, 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Transition {
    /// Where it ends.
    pub state: State,
    /// ∂(q, v)(t1)/∂(q, v)(t0), in the units of the model.
    pub matrix: DMatrix<f64>,
    /// Tooth edges crossed.
    pub crossings: u64,
}

/// A solver good enough to see how far things move.
pub(super) fn coarse(start: &State) -> Dop853 {
    let largest = start.q.iter().chain(&start.v).fold(0.0, |m: f64, x| m.max(x.abs()));
    Dop853::new().rtol(1e-9).atol(1e-12 * if largest > 0.0 && largest.is_finite() { largest } else { 1.0 })
}

/// The end of a run and its derivative, both differences and their change in units of size.
pub(super) fn transition<M: Model + ?Sized>(
    model: &M,
    scale: &[f64],
    tolerance: f64,
    start: &State,
    t_end: f64,
) -> Result<(State, DMatrix<f64>, u64), IntegrateError> {
    let tangent = Tangent::new(model, scale.len(), scale, tolerance);
    let (end, crossings) = tangent.run(&tangent.solver(tolerance, start), tangent.start(start), t_end)?;
    let matrix = DMatrix::from_fn(scale.len(), scale.len(), |i, k| tangent.scaled(&end, i, k));
    Ok((tangent.motion(&end), matrix, crossings))
}

/// S X S⁻¹.
pub(super) fn unscaled(scaled: &DMatrix<f64>, scale: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(scale.len(), scale.len(), |i, j| scaled[(i, j)] * scale[i] / scale[j])
}
