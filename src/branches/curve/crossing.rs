//! Location of crossings of branches.

use crate::branches::curve::engine::Engine;
use crate::branches::curve::equations::{Curve, CurveError};
use crate::branches::curve::locate::{Between, JUMP, LOCATED_WITHIN, Narrowed, Test};
use crate::branches::curve::point::CurvePoint;
use crate::numeric::search::brent::Brent;
use nalgebra::DVector;

/// A located point, and whether the branch turns back at it though it is no fold.
pub(crate) type Turning<S> = (CurvePoint<S>, bool);

/// Places beside a crossing of branches, in steps.
const PLACES_BESIDE: [f64; 4] = [-2.0, -1.0, 1.0, 2.0];

/// Length of these steps, as a share of the step between the points `[1]`.
const BESIDE_STEP: f64 = 0.02;

/// Accuracy of the parameter at a crossing at which a branch turns back, as a share of it `[1]`. Rounding
/// leaves it open by some 1e-10, and the place along the branch by the square root of that.
const CROSSING_PARAMETER: f64 = 1e-9;

/// Whether the parameter of a fold is that of a crossing of branches: a fold there is the crossing.
pub(crate) fn same_parameter(fold: f64, crossing: f64) -> bool {
    (fold - crossing).abs() < CROSSING_PARAMETER * crossing.abs()
}

/// Largest residual of an interpolated solution `[1]`.
const INTERPOLATED: f64 = 1e-9;

impl<C: Curve> Engine<C> {
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
        let narrowed = self.narrowed(between, ends, JUMP, test);
        self.at_crossing = false;
        // Next to the crossing the equations may not be solved: then it is near the place that was asked
        // last.
        let (middle, rough) = match narrowed {
            None => return Ok(None),
            Some(Narrowed { failed: Some(exhausted @ CurveError::Exhausted(_)), .. }) => {
                return Err(exhausted);
            }
            Some(Narrowed { nearest: Some(point), .. }) => (self.distance(between.a, &point), Some(point)),
            Some(Narrowed { at, .. }) => (at, None),
        };
        let width = ends[1][0] - ends[0][0];
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
            return Ok(rough.map(|rough| (rough, false)));
        }
        let mut brent = Brent::new(low, high, LOCATED_WITHIN);
        while let Some(z) = brent.next() {
            brent.take(z, value(z));
        }
        let weights = weights(brent.best());
        let near = rough.clone().unwrap_or_else(|| beside[1].2.clone());
        let n = near.x.len();
        let [before, after] = [&beside[1].2, &beside[2].2].map(CurvePoint::slope);
        // A slope that is 0 elsewhere is that of a fold beside the crossing.
        let slope: f64 = weights.iter().zip(&beside).map(|(w, (.., point))| w * point.slope()).sum();
        let to_fold = slope * slope / (after - before) * BESIDE_STEP * width * near.units[n];
        let turns = before * after < 0.0 && same_parameter(near.p + to_fold, near.p);
        let p = weights.iter().zip(&beside).map(|(w, (.., point))| w * point.p).sum();
        let x = weights.iter().zip(&beside).fold(DVector::zeros(n), |x, (w, (.., point))| x + &point.x * *w);
        let linear = self.curve.linearise(&x, p)?;
        let point = if linear.residual.amax() <= INTERPOLATED {
            Some(CurvePoint { x, p, solution: linear.solution, ..near })
        } else {
            rough
        };
        Ok(point.map(|point| (point, turns)))
    }
}
