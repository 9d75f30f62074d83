//! Location of points between two points of a curve.

use crate::branches::curve::engine::Engine;
use crate::branches::curve::equations::{Curve, CurveError};
use crate::branches::curve::point::CurvePoint;
use crate::numeric::search::brent::Brent;
use crate::numeric::search::hermite::{Distance, Hermite};
use crate::numeric::search::parabola::CURVED;
use nalgebra::DVector;

/// Interval of the arclength within which a point is located, as a share of the step `[1]`.
const LOCATED_WITHIN: f64 = 1e-11;

/// Maximum number of points computed to locate one.
const MAX_POINTS: usize = 80;

/// Places beside a crossing of branches, in steps.
const PLACES_BESIDE: [f64; 4] = [-2.0, -1.0, 1.0, 2.0];

/// Length of these steps, as a share of the step between the points `[1]`.
const BESIDE_STEP: f64 = 0.02;

/// Accuracy of the parameter at a crossing at which a branch turns back, as a share of it `[1]`. Rounding leaves it open by
/// some 1e-10, and the place along the branch by the square root of that.
const CROSSING_PARAMETER: f64 = 1e-9;

/// Whether the parameter of a fold is that of a crossing of branches: a fold there is the crossing.
pub(crate) fn same_parameter(fold: f64, crossing: f64) -> bool {
    (fold - crossing).abs() < CROSSING_PARAMETER * crossing.abs()
}

/// Largest residual of an interpolated solution `[1]`.
const INTERPOLATED: f64 = 1e-9;

/// Largest value of a test at a located point, as a share of the values at the ends `[1]`. A larger one is a
/// jump.
const JUMP: f64 = 1e-3;

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
    a: &'p CurvePoint<S>,
    /// Place of the second point from the first, and dx/dσ there, in the units of the first.
    end: DVector<f64>,
    slope: DVector<f64>,
    ds: f64,
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
        [from, to]: [[f64; 2]; 2],
        test: &mut Test<'_, C>,
        jump: f64,
    ) -> Result<Option<CurvePoint<C::Solution>>, CurveError> {
        if from[1].is_nan() || to[1].is_nan() || (from[1] > 0.0) == (to[1] > 0.0) {
            return Ok(None);
        }
        let mut brent = Brent::new(from, to, LOCATED_WITHIN * between.ds);
        let mut nearest: Option<(f64, CurvePoint<C::Solution>)> = None;
        for _ in 0..MAX_POINTS {
            let Some(sigma) = brent.next() else { break };
            let point = self.point_at(between, sigma)?;
            let Some(value) = test(self, &point) else { return Ok(None) };
            brent.take(sigma, value);
            if nearest.as_ref().is_none_or(|(least, _)| value.abs() <= *least) {
                nearest = Some((value.abs(), point));
            }
        }
        match nearest {
            Some((least, _)) if least > jump * from[1].abs().max(to[1].abs()) => Ok(None),
            Some((_, point)) => Ok(Some(point)),
            None => self.point_at(between, brent.best()).map(Some),
        }
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

    /// The crossing of branches between two distances σ, at which `test` changes its sign.
    ///
    /// At the crossing itself the equations are singular. The place is that of the root of the cubic through
    /// four values of the test beside the crossing, and the solution is interpolated in the same way. Also
    /// returns whether the branch turns back at the crossing: dp/ds changes its sign between the places next
    /// to it.
    pub(crate) fn locate_crossing(
        &mut self,
        between: &Between<'_, C::Solution>,
        ends: [[f64; 2]; 2],
        test: &mut Test<'_, C>,
    ) -> Result<Option<Turning<C::Solution>>, CurveError> {
        self.at_crossing = true;
        let rough = self.locate_between(between, ends, test);
        self.at_crossing = false;
        let Some(rough) = rough? else { return Ok(None) };
        let (width, middle) = (ends[1][0] - ends[0][0], self.distance(between.a, &rough));
        let mut beside = Vec::with_capacity(PLACES_BESIDE.len());
        for place in PLACES_BESIDE {
            let sigma = middle + place * BESIDE_STEP * width;
            let point = self.point_at(between, sigma)?;
            let Some(value) = test(self, &point) else { return Ok(None) };
            beside.push((place, value, point));
        }
        let weights = |z: f64| -> Vec<f64> {
            let weight = |i: usize| {
                let others = (0..PLACES_BESIDE.len()).filter(|&j| j != i);
                others.map(|j| (z - PLACES_BESIDE[j]) / (PLACES_BESIDE[i] - PLACES_BESIDE[j])).product()
            };
            (0..PLACES_BESIDE.len()).map(weight).collect()
        };
        let value =
            |z: f64| -> f64 { weights(z).iter().zip(&beside).map(|(w, (_, value, _))| w * value).sum() };
        let ends = [PLACES_BESIDE[0], PLACES_BESIDE[PLACES_BESIDE.len() - 1]];
        let [low, high] = ends.map(|z| [z, value(z)]);
        if (low[1] > 0.0) == (high[1] > 0.0) {
            return Ok(Some((rough, false)));
        }
        let mut brent = Brent::new(low, high, LOCATED_WITHIN);
        while let Some(z) = brent.next() {
            brent.take(z, value(z));
        }
        let weights = weights(brent.best());
        let [before, after] = [&beside[1].2, &beside[2].2].map(CurvePoint::slope);
        // A slope that is 0 elsewhere is that of a fold beside the crossing.
        let slope: f64 = weights.iter().zip(&beside).map(|(w, (.., point))| w * point.slope()).sum();
        let to_fold = slope * slope / (after - before) * BESIDE_STEP * width * rough.units[rough.x.len()];
        let turns = before * after < 0.0 && same_parameter(rough.p + to_fold, rough.p);
        let p = weights.iter().zip(&beside).map(|(w, (.., point))| w * point.p).sum();
        let x =
            weights.iter().zip(&beside).fold(rough.x.clone() * 0.0, |x, (w, (.., point))| x + &point.x * *w);
        let linear = self.curve.linearise(&x, p)?;
        let solved = linear.residual.amax() <= INTERPOLATED;
        let point = if solved { CurvePoint { x, p, solution: linear.solution, ..rough } } else { rough };
        Ok(Some((point, turns)))
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

/// A located point, and whether the branch turns back at it though it is no fold.
pub(crate) type Turning<S> = (CurvePoint<S>, bool);

/// A function of a point of the curve whose sign changes at the points looked for.
pub(crate) type Test<'t, C> =
    dyn FnMut(&mut Engine<C>, &CurvePoint<<C as Curve>::Solution>) -> Option<f64> + 't;
