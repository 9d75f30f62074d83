//! A point of a curve.

use nalgebra::DVector;

/// A point of a curve, with its unit tangent in scaled unknowns.
#[derive(Clone, Debug)]
pub(crate) struct CurvePoint<S> {
    pub(crate) x: DVector<f64>,
    pub(crate) p: f64,
    /// Tangent (dx/ds over the units, dp/ds over the unit of p), of length 1.
    pub(crate) tangent: DVector<f64>,
    /// Units of the unknowns, then of p, in which the tangent is measured.
    pub(crate) units: DVector<f64>,
    /// Sign of det [J; tᵀ].
    pub(crate) sign: f64,
    /// ln |det [J; tᵀ]|, with the tangent t of the point from which this one was corrected.
    pub(crate) logarithm: f64,
    pub(crate) corrections: Vec<f64>,
    pub(crate) solution: S,
}

impl<S> CurvePoint<S> {
    /// dp/ds over the unit of p.
    pub(crate) fn slope(&self) -> f64 {
        self.tangent[self.tangent.len() - 1]
    }
    /// Unknown `k`; the parameter after the last one.
    pub(crate) fn value(&self, k: usize) -> f64 {
        if k < self.x.len() { self.x[k] } else { self.p }
    }
    pub(crate) fn value_mut(&mut self, k: usize) -> &mut f64 {
        if k < self.x.len() { &mut self.x[k] } else { &mut self.p }
    }
    /// The components of a vector of changes of (x, p) in the units of the point.
    pub(crate) fn scaled(&self, x: &DVector<f64>, p: f64) -> DVector<f64> {
        let n = self.x.len();
        DVector::from_fn(n + 1, |i, _| {
            if i < n { (x[i] - self.x[i]) / self.units[i] } else { (p - self.p) / self.units[n] }
        })
    }
    /// The change from this point to another in the units of this point.
    pub(crate) fn scaled_difference(&self, other: &CurvePoint<S>) -> DVector<f64> {
        self.scaled(&other.x, other.p)
    }
    /// The tangent of another point in the units of this point.
    pub(crate) fn tangent_of(&self, other: &CurvePoint<S>) -> DVector<f64> {
        other.tangent.component_mul(&other.units).component_div(&self.units).normalize()
    }
    /// Whether a step from `last` to `next` passes this point in the direction of its tangent.
    pub(crate) fn is_passed(&self, last: &CurvePoint<S>, next: &CurvePoint<S>, step: f64) -> bool {
        let [before, after] = [last, next].map(|point| self.scaled_difference(point));
        let [from, to] = [&before, &after].map(|difference| self.tangent.dot(difference));
        from < 0.0 && to >= 0.0 && after.norm() < 2.0 * step && self.tangent.dot(&next.tangent) > 0.9
    }
    /// (x, p) at the distance `ds` along a direction in scaled unknowns.
    pub(crate) fn along(&self, direction: &DVector<f64>, ds: f64) -> (DVector<f64>, f64) {
        let n = self.x.len();
        let x = DVector::from_fn(n, |i, _| self.x[i] + ds * direction[i] * self.units[i]);
        (x, self.p + ds * direction[n] * self.units[n])
    }
}
