//! Location of points between two points of a curve.

use crate::branches::curve::engine::Engine;
use crate::branches::curve::equations::{Curve, CurveError};
use crate::branches::curve::point::CurvePoint;
use crate::numeric::search::brent::Brent;
use crate::numeric::search::hermite::{Distance, Hermite};
use crate::numeric::search::parabola::CURVED;
use nalgebra::DVector;

/// Interval of the arclength within which a point is located, as a share of the step `[1]`.
pub(super) const LOCATED_WITHIN: f64 = 1e-11;

/// Maximum number of points computed to locate one.
const MAX_POINTS: usize = 80;

/// Largest value of a test at a located point, as a share of the values at the ends `[1]`. A larger one is a
/// jump.
pub(super) const JUMP: f64 = 1e-3;

/// Maximum number of parabolas in the search of an extremum.
const PARABOLAS: usize = 8;

/// Distance of two places of this search, as a share of the interval `[1]`.
const CLOSEST: f64 = 1e-4;

/// The curve may reach beyond a turn of its cubic by this share of the way from the nearer point to the turn
/// `[1]`.
const BEYOND: f64 = 0.1;

/// Cubic Hermite interpolation of a curve between two of its points, over the distance σ along the tangent of
/// the first.
pub(crate) struct Between<'p, S> {
    pub(super) a: &'p CurvePoint<S>,
    /// Place of the second point from the first, and dx/dσ there, in the units of the first.
    end: DVector<f64>,
    slope: DVector<f64>,
    pub(super) ds: f64,
}

impl<'p, S> Between<'p, S> {
    /// `ds`: distance of `b` from `a` along the tangent of `a`.
    pub(crate) fn new(a: &'p CurvePoint<S>, b: &CurvePoint<S>, ds: f64) -> Self {
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

    /// The distance of the two points.
    pub(crate) fn length(&self) -> f64 {
        self.ds
    }

    /// The parameters of the two points. If the curve turns back between them, it reaches a parameter beyond
    /// one of them. A bound of this parameter replaces that of the nearer point.
    pub(crate) fn parameters(&self, end: f64) -> [f64; 2] {
        let n = self.end.len() - 1;
        let at = |value: f64, tangent: f64| Distance { value, rate: self.ds * tangent };
        let cubic = Hermite::new(at(0.0, self.a.tangent[n]), at(self.end[n], self.slope[n]));
        let mut range = [self.a.p, end];
        for z in cubic.extrema().into_iter().flatten() {
            let turn = self.at(z * self.ds).1;
            let k = usize::from((turn - range[1]).abs() < (turn - range[0]).abs());
            if (turn - range[0]) * (turn - range[1]) > 0.0 {
                range[k] = turn + BEYOND * (turn - range[k]);
            }
        }
        range
    }

    /// The first of the two points.
    pub(crate) fn start(&self) -> &CurvePoint<S> {
        self.a
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
        test: &mut Test<'_, C>,
    ) -> Result<Option<CurvePoint<C::Solution>>, CurveError> {
        let (Some(at_a), Some(at_b)) = (test(self, a), test(self, b)) else { return Ok(None) };
        let ends = [[0.0, at_a], [ds, at_b]];
        self.locate_between(&Between::new(a, b, ds), ends, test)
    }

    /// The point between two distances σ with values of the test, at which the test changes its sign. `None`
    /// if the test has no value at some point, or the same sign at both ends, or jumps over 0.
    pub(crate) fn locate_between(
        &mut self,
        between: &Between<'_, C::Solution>,
        ends: [[f64; 2]; 2],
        test: &mut Test<'_, C>,
    ) -> Result<Option<CurvePoint<C::Solution>>, CurveError> {
        self.bracketed(between, ends, test, JUMP)
    }

    /// The fold between two distances σ with values of the slope dp/dσ: a zero of the slope or, on a curve
    /// with corners, a corner at which it changes its sign.
    pub(crate) fn locate_fold(
        &mut self,
        between: &Between<'_, C::Solution>,
        ends: [[f64; 2]; 2],
        test: &mut Test<'_, C>,
    ) -> Result<Option<CurvePoint<C::Solution>>, CurveError> {
        let jump = if self.curve.has_corners() { f64::INFINITY } else { JUMP };
        self.bracketed(between, ends, test, jump)
    }

    /// `jump`: largest value of the test at the place found, as a share of those at the ends.
    fn bracketed(
        &mut self,
        between: &Between<'_, C::Solution>,
        ends: [[f64; 2]; 2],
        test: &mut Test<'_, C>,
        jump: f64,
    ) -> Result<Option<CurvePoint<C::Solution>>, CurveError> {
        let Some(Narrowed { at, nearest, failed }) = self.narrowed(between, ends, jump, test) else {
            return Ok(None);
        };
        match (failed, nearest) {
            (Some(failed), _) => Err(failed),
            (None, Some(point)) => Ok(Some(point)),
            (None, None) => self.point_at(between, at).map(Some),
        }
    }

    /// Narrows down the place between two distances σ at which `test` changes its sign; `None` if the test
    /// has no value at some point, or the same sign at both ends, or jumps over 0.
    pub(super) fn narrowed(
        &mut self,
        between: &Between<'_, C::Solution>,
        [from, to]: [[f64; 2]; 2],
        jump: f64,
        test: &mut Test<'_, C>,
    ) -> Option<Narrowed<C::Solution>> {
        if from[1].is_nan() || to[1].is_nan() || (from[1] > 0.0) == (to[1] > 0.0) {
            return None;
        }
        let mut brent = Brent::new(from, to, LOCATED_WITHIN * between.ds);
        let mut nearest: Option<(f64, CurvePoint<C::Solution>)> = None;
        for _ in 0..MAX_POINTS {
            let Some(sigma) = brent.next() else { break };
            let point = match self.point_at(between, sigma) {
                Err(failed) => return Some(Narrowed { at: sigma, nearest: None, failed: Some(failed) }),
                Ok(point) => point,
            };
            let value = test(self, &point)?;
            brent.take(sigma, value);
            if nearest.as_ref().is_none_or(|(least, _)| value.abs() <= *least) {
                nearest = Some((value.abs(), point));
            }
        }
        let is_jump = |(least, _): &(f64, _)| *least > jump * from[1].abs().max(to[1].abs());
        if nearest.as_ref().is_some_and(is_jump) {
            return None;
        }
        Some(Narrowed { at: brent.best(), nearest: nearest.map(|(_, point)| point), failed: None })
    }

    /// The point at the distance σ.
    pub(crate) fn point_at(
        &mut self,
        between: &Between<'_, C::Solution>,
        sigma: f64,
    ) -> Result<CurvePoint<C::Solution>, CurveError> {
        let (x, p) = between.at(sigma);
        self.correct(between.a, &between.a.tangent, sigma, x, p)
    }

    /// A distance between two others at which `test` has the opposite sign, and its value; `None` if none
    /// is found. Parabolas approach the extremum of the test, as long as their extremum is near 0.
    /// `turned`: a guess of the place, if the extremum is known to lie between; the parabolas then go on in
    /// any case.
    pub(crate) fn dip_between(
        &mut self,
        between: &Between<'_, C::Solution>,
        [from, to]: [[f64; 2]; 2],
        turned: Option<f64>,
        test: &mut Test<'_, C>,
    ) -> Result<Option<[f64; 2]>, CurveError> {
        let (sign, width) = (from[1].signum(), to[0] - from[0]);
        let (mut ends, mut inner) = ([from, to], None);
        let mut next = turned.unwrap_or(0.5 * (from[0] + to[0]));
        for _ in 0..PARABOLAS {
            let point = self.point_at(between, next)?;
            let Some(value) = test(self, &point) else { break };
            if sign * value < 0.0 {
                return Ok(Some([next, value]));
            }
            let middle = match inner {
                None => [next, value],
                Some(old) => narrow(&mut ends, old, [next, value]),
            };
            inner = Some(middle);
            let [[x0, y0], [x2, y2]] = ends;
            let [x1, y1] = middle;
            let (h0, h1) = (x1 - x0, x2 - x1);
            let (left, right) = ((y1 - y0) / h0, (y2 - y1) / h1);
            let curvature = (right - left) / (h0 + h1);
            let slope = right - curvature * h1;
            let vertex = -0.5 * slope / curvature;
            let lowest = y1 - 0.25 * slope * slope / curvature;
            let least = y0.abs().min(y1.abs()).min(y2.abs());
            next = x1 + vertex;
            let is_new = [x0, x1, x2].iter().all(|x| (next - x).abs() > CLOSEST * width);
            // A test of another shape than a parabola may lie lower.
            let longest = h0.max(h1);
            let is_low = turned.is_some()
                || sign * lowest < 0.5 * least
                || least < 0.25 * CURVED * curvature.abs() * longest * longest;
            if !(curvature * sign > 0.0 && x0 < next && next < x2 && is_new && is_low) {
                break;
            }
        }
        Ok(None)
    }
}

/// Moves one of two ends to the higher one of two places between them, and returns the lower one.
fn narrow(ends: &mut [[f64; 2]; 2], one: [f64; 2], other: [f64; 2]) -> [f64; 2] {
    let [low, high] = if one[1].abs() < other[1].abs() { [one, other] } else { [other, one] };
    ends[usize::from(high[0] > low[0])] = high;
    low
}

/// Where the search of a change of sign ended.
pub(super) struct Narrowed<S> {
    /// The distance σ that was asked last.
    pub(super) at: f64,
    /// The point with the least value of the test; `None` if none was computed, or the last one was not.
    pub(super) nearest: Option<CurvePoint<S>>,
    /// Why the last point was not computed.
    pub(super) failed: Option<CurveError>,
}

/// A function of a point of the curve whose sign changes at the points looked for.
pub(crate) type Test<'t, C> =
    dyn FnMut(&mut Engine<C>, &CurvePoint<<C as Curve>::Solution>) -> Option<f64> + 't;
