//! Points of a curve by pseudo-arclength.

use crate::branches::curve::bordered::Bordered;
use crate::branches::curve::equations::{Curve, CurveError, Linear};
use crate::branches::curve::past::Past;
use crate::branches::curve::point::CurvePoint;
use nalgebra::{DMatrix, DVector};

/// Finds points of a curve.
pub(crate) struct Engine<C> {
    pub(crate) curve: C,
    /// Unit of the parameter.
    pub(crate) unit: f64,
    /// Largest accepted last correction `[1]`.
    pub(crate) tolerance: f64,
    pub(crate) max_corrections: usize,
    /// Whether a crossing of branches is being located.
    pub(crate) at_crossing: bool,
}

/// A correction below this that no longer decreases is noise of the integration.
const NOISE: f64 = 1e-9;

/// Number of rounding errors of an unknown, as a share of its range, that a correction may consist of.
/// Coordinates far larger than their motion have corrections of this noise.
const ROUNDINGS: f64 = 16.0;

/// Residual, in units of the motion, below which corrections that no longer decrease are noise even if they
/// are larger; [`ShootingOrbit::accuracy`](crate::periodic::ShootingOrbit::accuracy) tells their size.
const NOISY: f64 = 1e-10;

/// Largest correction of that kind.
const UNSTEADY: f64 = 1e-6;

/// Residual, in units of the motion, of solved equations next to a branch point.
const SOLVED: f64 = 1e-12;

/// Largest residual of a start, in units of the motion.
const START: f64 = 1e-6;

/// A correction that exceeds the one before by this factor ends the corrections.
const DIVERGES: f64 = 2.0;

/// Maximum correction `[1]`: a larger one leads to another branch.
const LARGEST: f64 = 3.0;

impl<C: Curve> Engine<C> {
    /// The derivative in scaled unknowns, bordered by the direction `row`.
    fn bordered(
        &self,
        linear: &Linear<C::Solution>,
        units: &DVector<f64>,
        row: &DVector<f64>,
    ) -> Option<Bordered> {
        let n = linear.residual.len();
        Bordered::new(DMatrix::from_fn(n + 1, n + 1, |i, j| match (i < n, j < n) {
            (true, true) => linear.by_x[(i, j)] * units[j],
            (true, false) => linear.by_p[i] * units[n],
            (false, _) => row[j],
        }))
    }

    pub(crate) fn units(&self) -> DVector<f64> {
        let own = self.curve.units();
        let n = own.len();
        own.insert_row(n, self.unit)
    }

    /// The point of a solution x at the parameter p, with its tangent towards increasing p.
    pub(crate) fn start(&mut self, x: DVector<f64>, p: f64) -> Result<CurvePoint<C::Solution>, CurveError> {
        let linear = self.curve.linearise(&x, p)?;
        let residual = linear.residual.amax();
        if residual.is_nan() || residual > START.max(self.tolerance) {
            return Err(CurveError::NoSolution { residual });
        }
        let units = self.units();
        let n = x.len();
        let up = DVector::from_fn(n + 1, |i, _| if i == n { 1.0 } else { 0.0 });
        let bordered = self.bordered(&linear, &units, &up).ok_or(CurveError::Singular)?;
        let tangent = bordered.solve(up).normalize();
        let (sign, logarithm) = (bordered.sign, bordered.logarithm);
        let corrections = Vec::new();
        Ok(CurvePoint { x, p, tangent, units, sign, logarithm, corrections, solution: linear.solution })
    }

    /// [`start`](Engine::start) with the tangent in the direction of the sign of dp/ds.
    pub(crate) fn start_towards(
        &mut self,
        x: DVector<f64>,
        p: f64,
        slope: f64,
    ) -> Result<CurvePoint<C::Solution>, CurveError> {
        let mut point = self.start(x, p)?;
        if slope < 0.0 {
            point.tangent.neg_mut();
            point.sign = -point.sign;
        }
        Ok(point)
    }

    /// The point at the parameter `bound`, corrected from the prediction at the distance `ds` along the
    /// tangent of `from`, with its tangent in the direction of the bound. For bounds beyond which there is no
    /// model.
    pub(crate) fn at_bound(
        &mut self,
        from: &CurvePoint<C::Solution>,
        ds: f64,
        bound: f64,
    ) -> Result<CurvePoint<C::Solution>, CurveError> {
        let (x, _) = from.along(&from.tangent, ds);
        let n = x.len();
        let way = (bound - from.p).signum();
        let direction = DVector::from_fn(n + 1, |i, _| if i == n { way } else { 0.0 });
        let distance = direction.dot(&from.scaled(&x, bound));
        let mut point = self.correct(from, &direction, distance, x, bound)?;
        point.p = bound;
        Ok(point)
    }

    /// The point at the distance `ds` from `from` along its tangent. `before`: the point before it, for the
    /// prediction.
    pub(crate) fn advance(
        &mut self,
        before: Option<&Past>,
        from: &CurvePoint<C::Solution>,
        ds: f64,
    ) -> Result<CurvePoint<C::Solution>, CurveError> {
        let (x, p) = match before {
            Some(past) => past.extrapolate(from, ds),
            None => from.along(&from.tangent, ds),
        };
        self.correct(from, &from.tangent, ds, x, p)
    }

    /// The point whose distance from `from` along `direction` is `ds`, by Newton's method from (x, p).
    ///
    /// It is not damped, unlike [`Newton`](crate::roots::Newton): where corrections grow, the curve is
    /// followed by shorter steps.
    pub(crate) fn correct(
        &mut self,
        from: &CurvePoint<C::Solution>,
        direction: &DVector<f64>,
        ds: f64,
        mut x: DVector<f64>,
        mut p: f64,
    ) -> Result<CurvePoint<C::Solution>, CurveError> {
        let n = x.len();
        let count = (n as f64).sqrt();
        let mut corrections: Vec<f64> = Vec::new();
        loop {
            let linear = self.curve.linearise(&x, p)?;
            let bordered = self.bordered(&linear, &from.units, direction).ok_or(CurveError::Singular)?;
            let behind = ds - direction.dot(&from.scaled(&x, p));
            let right = DVector::from_fn(n + 1, |i, _| if i < n { -linear.residual[i] } else { behind });
            let step = bordered.solve(right);
            // The units contain the square root of the number of unknowns.
            let size = step.rows(0, n).amax() * count;
            let size = size.max(step[n].abs());
            let before = corrections.last().copied().unwrap_or(f64::INFINITY);
            corrections.push(size);
            let stalled = size > 0.5 * before;
            // Next to a branch point the equations hardly determine one direction: corrections along it do
            // not decrease as they do elsewhere.
            let residual = linear.residual.amax().max(behind.abs());
            let solved = self.at_crossing && residual <= SOLVED;
            // The noise of an integration over hundreds of edges, amplified by the equations.
            let noisy = residual <= NOISY && size <= UNSTEADY;
            let rounding = (0..n).fold(0.0, |m: f64, i| m.max(x[i].abs() / from.units[i])) * count;
            let noise = NOISE.max((ROUNDINGS * f64::EPSILON * rounding).min(UNSTEADY));
            let is_last = !self.at_crossing && size <= self.curve.last_correction();
            if is_last {
                step.rows(0, n).iter().enumerate().for_each(|(i, step)| x[i] += step * from.units[i]);
                p += step[n] * from.units[n];
            }
            if is_last || size <= self.tolerance || solved || (stalled && (size <= noise || noisy)) {
                let ahead = DVector::from_fn(n + 1, |i, _| if i == n { 1.0 } else { 0.0 });
                let tangent = bordered.solve(ahead).normalize();
                let (sign, logarithm, units) = (bordered.sign, bordered.logarithm, from.units.clone());
                return Ok(CurvePoint {
                    x,
                    p,
                    tangent,
                    units,
                    sign,
                    logarithm,
                    corrections,
                    solution: linear.solution,
                });
            }
            let hopeless = size > DIVERGES * before || !size.is_finite() || size > LARGEST;
            if hopeless || corrections.len() >= self.max_corrections {
                return Err(CurveError::NotConverged { corrections });
            }
            for i in 0..n {
                x[i] += step[i] * from.units[i];
            }
            p += step[n] * from.units[n];
        }
    }

    /// Distance of a point from another along the tangent of the other.
    pub(crate) fn distance(&self, from: &CurvePoint<C::Solution>, to: &CurvePoint<C::Solution>) -> f64 {
        from.tangent.dot(&from.scaled_difference(to))
    }

    /// Expresses the tangent of a point in the present units of the curve.
    pub(crate) fn rescale(&self, point: &mut CurvePoint<C::Solution>) {
        let units = self.units();
        point.tangent.component_mul_assign(&point.units);
        point.tangent.component_div_assign(&units);
        point.tangent.normalize_mut();
        point.units = units;
    }

    /// The angle between the tangents of two points, in the units of the first `[rad]`.
    pub(crate) fn angle(from: &CurvePoint<C::Solution>, to: &CurvePoint<C::Solution>) -> f64 {
        between(&from.tangent, &from.tangent_of(to))
    }
    /// By how much the curve turns between two points `[rad]`: from the tangent of the first to the chord,
    /// and on to the tangent of the second. Between equal tangents it may turn and turn back.
    pub(crate) fn turn(from: &CurvePoint<C::Solution>, to: &CurvePoint<C::Solution>) -> f64 {
        let chord = from.scaled_difference(to).normalize();
        between(&from.tangent, &chord) + between(&chord, &from.tangent_of(to))
    }
}

/// The angle between two directions of length 1 `[rad]`.
fn between(a: &DVector<f64>, b: &DVector<f64>) -> f64 {
    a.dot(b).clamp(-1.0, 1.0).acos()
}
