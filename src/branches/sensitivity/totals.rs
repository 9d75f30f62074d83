//! Total derivatives of an orbit with respect to all constants of its model.

use crate::branches::curve::bordered::Bordered;
use crate::branches::curve::equations::CurveError;
use crate::branches::family::{Family, Models};
use crate::branches::orbits::by_shooting::orbit_curve::{OrbitCurve, Passage, Slopes};
use crate::error::ParameterError;
use crate::model::drive_slope::DriveSlope;
use crate::model::equations::Constants;
use crate::model::{Channel, Periodic, State};
use crate::ode::budget::Meter;
use crate::periodic::{Shooting, ShootingOrbit};
use nalgebra::{DMatrix, DVector};
use std::rc::Rc;
use std::sync::Arc;

/// The model of these constants at any parameter.
struct Alone<'m>(&'m dyn Constants);

impl<'m> Alone<'m> {
    fn family(constants: &'m dyn Constants) -> Family<'m> {
        let parameters = [Channel::new("none", "1")];
        Family { parameters, constants: None, models: Arc::new(Alone(constants)) }
    }
}

impl Models<1> for Alone<'_> {
    fn at(&self, _: [f64; 1]) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        self.0.with_values(&[])
    }
}

/// dx/dc = -(∂G/∂x)⁻¹ ∂G/∂c for the nodes x of an orbit and all constants c, each in its own unit.
pub(crate) struct Totals<'f> {
    pub(crate) curve: OrbitCurve<'f>,
    pub(crate) x: DVector<f64>,
    pub(crate) passage: Passage,
    pub(crate) by_x: DMatrix<f64>,
    pub(crate) by_c: DMatrix<f64>,
    /// Slopes of the drives, in units of the constants.
    pub(crate) forced: Vec<DriveSlope>,
    /// Unit of each constant.
    pub(crate) units: Vec<f64>,
}

/// Least effect of a change by the unit of a constant, as a share of the size of the motion `[1]`.
const WEAK: f64 = 1e-2;

/// Largest residual of an orbit of the model, in units of the motion `[1]`.
const LARGEST_RESIDUAL: f64 = 1e-6;

impl<'f> Totals<'f> {
    /// Evaluates ∂G/∂x and ∂G/∂c at an orbit.
    pub(crate) fn new(
        model: &dyn Periodic,
        constants: &'f dyn Constants,
        orbit: &ShootingOrbit,
        meter: Rc<Meter<'f>>,
    ) -> Result<Self, CurveError> {
        let curve = OrbitCurve::new(Alone::family(constants), (0.0, 1.0), orbit, &Shooting::new(), meter)?;
        let x = curve.unknowns_of(orbit);
        let unit = |value: f64| if value == 0.0 { 1.0 } else { value.abs() };
        let units: Vec<f64> = constants.values().iter().map(|value| unit(*value)).collect();
        let slopes = |units: &[f64]| -> Vec<DriveSlope> {
            units.iter().enumerate().map(|(i, unit)| constants.drive_slope(i).times(*unit)).collect()
        };
        let by_c = curve.slopes(model, &x, &slopes(&units))?.by_c;
        // A change by the unit of a constant moves the end of a segment by WEAK to 1 of the size of the
        // motion: the value of a constant may be 0 or small in its unit.
        let bounded = |(i, unit): (usize, &f64)| match by_c.column(i).amax() {
            0.0 => *unit,
            effect if effect < WEAK => unit * (WEAK / effect),
            effect => unit / effect.max(1.0),
        };
        let units: Vec<f64> = units.iter().enumerate().map(bounded).collect();
        let forced = slopes(&units);
        let Slopes { residual, by_x, by_c, passage } = curve.slopes(model, &x, &forced)?;
        let residual = residual.amax();
        if residual.is_nan() || residual > LARGEST_RESIDUAL {
            return Err(CurveError::NoSolution { residual });
        }
        Ok(Totals { curve, x, passage, by_x, by_c, forced, units })
    }

    /// dx/dc for all constants, one column each, in units of the constants.
    pub(crate) fn solve(&self) -> Result<DMatrix<f64>, CurveError> {
        let scaled = DMatrix::from_fn(self.x.len(), self.x.len(), |i, j| self.by_x[(i, j)] * self.size(j));
        let factors = Bordered::new(scaled).ok_or(CurveError::Singular)?;
        let mut all = DMatrix::zeros(self.x.len(), self.forced.len());
        for (k, mut column) in all.column_iter_mut().enumerate() {
            let solution = factors.solve(-self.by_c.column(k));
            for (j, x) in solution.iter().enumerate() {
                column[j] = x * self.size(j);
            }
        }
        Ok(all)
    }

    /// Size of unknown j.
    pub(crate) fn size(&self, j: usize) -> f64 {
        let m = self.curve.scale().len();
        if j < m * self.passage.states.len() { self.curve.scale()[j % m] } else { self.curve.sizes()[j] }
    }

    /// The state at node i with the derivatives of it, as the start of the tangent flow: δq and δv - ε v.
    pub(crate) fn start(&self, i: usize, slopes: &DMatrix<f64>) -> State {
        let mut state = self.passage.states[i].clone();
        let n = state.q.len();
        for (k, by) in self.forced.iter().enumerate() {
            for j in 0..n {
                state.q.push(slopes[(2 * n * i + j, k)]);
                let turned = by.speed * state.v[j];
                state.v.push(slopes[(2 * n * i + n + j, k)] - turned);
            }
        }
        state
    }
}
