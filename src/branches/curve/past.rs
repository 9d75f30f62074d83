//! Prediction of a point from the two before it.

use crate::branches::curve::point::CurvePoint;
use nalgebra::DVector;

/// The point before the last one: (x, p) and the direction of the tangent, in units of the equations.
pub(crate) struct Past {
    place: DVector<f64>,
    direction: DVector<f64>,
}

/// Largest step over the step before it for which the cubic polynomial is used.
const MAX_RATIO: f64 = 2.0;

impl Past {
    pub(crate) fn new<S>(point: &CurvePoint<S>) -> Self {
        let n = point.x.len();
        Past {
            place: point.x.clone().insert_row(n, point.p),
            direction: point.tangent.component_mul(&point.units),
        }
    }

    /// (x, p) at the distance `ds` along the tangent of `from`, on the cubic polynomial through both points
    /// with their tangents: P(σ) = t σ + α (σ/h)² + β (σ/h)³, with the distance h of the points along t.
    pub(crate) fn extrapolate<S>(&self, from: &CurvePoint<S>, ds: f64) -> (DVector<f64>, f64) {
        let (n, t) = (from.x.len(), &from.tangent);
        let mut back = self.place.clone();
        back.rows_mut(0, n).axpy(-1.0, &from.x, 1.0);
        back[n] -= from.p;
        back.component_div_assign(&from.units);
        let mut slope = self.direction.component_div(&from.units);
        let h = -t.dot(&back);
        let along = t.dot(&slope);
        if !(h > 0.0 && along > 0.0 && ds <= MAX_RATIO * h) {
            return from.along(t, ds);
        }
        slope /= along;
        let r = ds / h;
        let place = DVector::from_fn(n + 1, |i, _| {
            let (a, b) = (back[i] + t[i] * h, h * (slope[i] - t[i]));
            t[i] * ds + (b + 3.0 * a) * r * r + (b + 2.0 * a) * r * r * r
        });
        from.along(&place, 1.0)
    }
}
