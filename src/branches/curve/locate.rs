//! Location of points between two points of a curve.

use crate::branches::curve::engine::{CurvePoint, Engine};
use crate::branches::curve::equations::{Curve, CurveError};
use crate::numeric::brent::Brent;
use nalgebra::DVector;

/// Interval of the arclength within which a point is located, as a share of the step `[1]`.
const CLOSE: f64 = 1e-11;

/// Maximum number of points computed to locate one.
const MAX: usize = 80;

/// Cubic Hermite interpolation of a curve between two of its points, over the distance σ along the tangent of
/// the first.
struct Between<'p, S> {
    a: &'p CurvePoint<S>,
    /// Place of the second point from the first, and dx/dσ there, in the units of the first.
    end: DVector<f64>,
    slope: DVector<f64>,
    ds: f64,
}

impl<'p, S> Between<'p, S> {
    fn new(a: &'p CurvePoint<S>, b: &CurvePoint<S>, ds: f64) -> Self {
        let n = a.x.len();
        let end = DVector::from_fn(n + 1, |i, _| {
            let change = if i < n { b.x[i] - a.x[i] } else { b.p - a.p };
            change / a.units[i]
        });
        let mut slope = b.tangent.component_mul(&b.units);
        slope.component_div_assign(&a.units);
        slope /= a.tangent.dot(&slope);
        Between { a, end, slope, ds }
    }

    /// (x, p) at the distance σ.
    fn at(&self, sigma: f64) -> (DVector<f64>, f64) {
        let z = sigma / self.ds;
        let (z2, z3) = (z * z, z * z * z);
        let place = &self.end * (3.0 * z2 - 2.0 * z3)
            + &self.a.tangent * (self.ds * (z - 2.0 * z2 + z3))
            + &self.slope * (self.ds * (z3 - z2));
        self.a.along(&place, 1.0)
    }
}

impl<C: Curve> Engine<C> {
    /// The point between `a` and `b` at which `test` changes its sign. `ds`: distance of `b` from `a` along
    /// the tangent of `a`. `None` if the test has no value at some point, or the same sign at both ends.
    pub(crate) fn locate(
        &mut self,
        a: &CurvePoint<C::Solution>,
        b: &CurvePoint<C::Solution>,
        ds: f64,
        test: &mut dyn FnMut(&mut Self, &CurvePoint<C::Solution>) -> Option<f64>,
    ) -> Result<Option<CurvePoint<C::Solution>>, CurveError> {
        let (Some(at_a), Some(at_b)) = (test(self, a), test(self, b)) else { return Ok(None) };
        if at_a.is_nan() || at_b.is_nan() || (at_a > 0.0) == (at_b > 0.0) {
            return Ok(None);
        }
        let between = Between::new(a, b, ds);
        let mut brent = Brent::new([0.0, at_a], [ds, at_b], CLOSE * ds);
        let mut nearest = (at_b.abs(), b.clone());
        for _ in 0..MAX {
            let Some(sigma) = brent.next() else { break };
            let (x, p) = between.at(sigma);
            let point = self.correct(a, &a.tangent, sigma, x, p)?;
            let Some(value) = test(self, &point) else { return Ok(None) };
            brent.take(sigma, value);
            if value.abs() <= nearest.0 {
                nearest = (value.abs(), point);
            }
        }
        Ok(Some(nearest.1))
    }
}
