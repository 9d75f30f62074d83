//! Derivatives of the flow with respect to a parameter by differences.

use crate::branches::curve::equations::CurveError;
use crate::branches::orbits::by_shooting::orbit_curve::OrbitCurve;
use crate::error::ParameterError;
use crate::model::{Periodic, State};
use nalgebra::DVector;

impl OrbitCurve<'_> {
    /// ∂φ/∂c of all segments at c, for the models `model(c)`, in units of `scale`: central differences with
    /// the step h, one-sided at the end of the models.
    pub(crate) fn differences<'m>(
        &self,
        x: &DVector<f64>,
        c: f64,
        h: f64,
        model: &dyn Fn(f64) -> Result<Box<dyn Periodic + 'm>, ParameterError>,
    ) -> Result<Vec<DVector<f64>>, CurveError> {
        let ends = |c: f64| -> Result<Vec<State>, CurveError> {
            let model = model(c).map_err(|error| CurveError::Model { parameter: c, error })?;
            let period = self.period_of(&*model);
            let segments = self.segments(&*model, period, 0, Vec::new())?;
            segments.ends(&self.states(x, period), self.flow_tolerance(), self.meter()).map_err(Self::failed)
        };
        let (low, high, width) = match (ends(c - h), ends(c + h)) {
            (Ok(low), Ok(high)) => (low, high, (c + h) - (c - h)),
            (Ok(low), Err(_)) => (low, ends(c)?, c - (c - h)),
            (Err(_), high) => (ends(c)?, high?, (c + h) - c),
        };
        let scale = self.scale();
        let m = scale.len();
        let all = |s: &State, i: usize| if i < m / 2 { s.q[i] } else { s.v[i - m / 2] };
        let slope = |(low, high): (&State, &State)| {
            DVector::from_fn(m, |i, _| (all(high, i) - all(low, i)) / (scale[i] * width))
        };
        Ok(low.iter().zip(&high).map(slope).collect())
    }
}
