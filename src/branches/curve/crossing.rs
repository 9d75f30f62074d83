//! Location of crossings of branches.

use crate::branches::curve::engine::Engine;
use crate::branches::curve::equations::{Curve, CurveError};
use crate::branches::curve::locate::{Between, JUMP, LOCATED_WITHIN, Narrowed, Test};
use crate::branches::curve::point::CurvePoint;
use crate::numeric::search::brent::Brent;
use nalgebra::DVector;

/// A located point and, if the branch turns back at it though it is not a fold, the slope dp/ds before it.
pub(crate) type Turning<S> = (CurvePoint<S>, Option<f64>);

/// A crossing at a distance σ. If the branch turns back there, dp/ds changes its sign: the slope before it.
struct Crossing<S> {
    sigma: f64,
    point: CurvePoint<S>,
    turns: Option<f64>,
}

/// Places beside a crossing of branches, in steps.
const PLACES_BESIDE: [f64; 4] = [-2.0, -1.0, 1.0, 2.0];

/// Length of these steps, as a share of the step between the points `[1]`.
const BESIDE_STEP: f64 = 0.02;

/// How often a crossing at which the equations are not solved is approached, and the ratio of the steps.
const APPROACHES: i32 = 3;
const APPROACH: f64 = 0.125;

/// Change of the parameter below which such a crossing is located, as a share of it `[1]`.
const APPROACHED: f64 = 1e-8;

/// Accuracy of the parameter at a crossing at which a branch turns back, as a share of it `[1]`. Rounding
/// leaves it open by some 1e-10, and the place along the branch by the square root of that.
const CROSSING_PARAMETER: f64 = 1e-9;

/// Whether a fold and a crossing of branches have the same parameter up to rounding.
pub(crate) fn same_parameter(fold: f64, crossing: f64) -> bool {
    (fold - crossing).abs() < CROSSING_PARAMETER * crossing.abs()
}

/// Largest residual of an interpolated solution `[1]`.
const INTERPOLATED: f64 = 1e-9;

impl<C: Curve> Engine<C> {
    /// The crossing of branches between two distances σ, at which `test` changes its sign, and whether the
    /// branch turns back there.
    ///
    /// At the crossing itself the equations are singular, and next to it they may not be solved. The place is
    /// then approached from places beside it.
    pub(crate) fn locate_crossing(
        &mut self,
        between: &Between<'_, C::Solution>,
        ends: [[f64; 2]; 2],
        test: &mut Test<'_, C>,
    ) -> Result<Option<Turning<C::Solution>>, CurveError> {
        self.at_crossing = true;
        let narrowed = self.narrowed(between, ends, JUMP, test);
        self.at_crossing = false;
        let step = BESIDE_STEP * (ends[1][0] - ends[0][0]);
        let at = match narrowed {
            None => return Ok(None),
            Some(Narrowed { failed: Some(exhausted @ CurveError::Exhausted(_)), .. }) => {
                return Err(exhausted);
            }
            Some(Narrowed { nearest: Some(point), .. }) => {
                let middle = self.distance(between.a, &point);
                let crossing = self.crossing(between, middle, step, Some(&point), test)?;
                return Ok(crossing.map(|crossing| (crossing.point, crossing.turns)));
            }
            Some(Narrowed { at, .. }) => at,
        };
        let Some(mut crossing) = self.crossing(between, at, step, None, test)? else { return Ok(None) };
        for k in 1..=APPROACHES {
            let nearer = match self.crossing(between, crossing.sigma, step * APPROACH.powi(k), None, test) {
                Ok(Some(nearer)) => nearer,
                Err(exhausted @ CurveError::Exhausted(_)) => return Err(exhausted),
                Ok(None) | Err(_) => break,
            };
            let change = (nearer.point.p - crossing.point.p).abs();
            // The slopes next to the crossing are rounding: those of the longest steps count.
            crossing = Crossing { turns: crossing.turns, ..nearer };
            if change < APPROACHED * crossing.point.p.abs() {
                return Ok(Some((crossing.point, crossing.turns)));
            }
        }
        Ok(None)
    }

    /// The crossing by the cubic through four values of the test beside the distance `middle`, in steps of
    /// `step`. The solution is interpolated in the same way; where it does not solve the equations, it is
    /// `rough`. `None` if these values show no crossing.
    fn crossing(
        &mut self,
        between: &Between<'_, C::Solution>,
        middle: f64,
        step: f64,
        rough: Option<&CurvePoint<C::Solution>>,
        test: &mut Test<'_, C>,
    ) -> Result<Option<Crossing<C::Solution>>, CurveError> {
        let mut beside = Vec::with_capacity(PLACES_BESIDE.len());
        for place in PLACES_BESIDE {
            let point = self.point_at(between, middle + place * step)?;
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
        let given = |point: &CurvePoint<_>| Crossing { sigma: middle, point: point.clone(), turns: None };
        // Where the test does not rise or fall over all of them, its sign at a place between them is
        // rounding.
        let is_monotonic = beside.is_sorted_by(|a, b| a.1 < b.1) || beside.is_sorted_by(|a, b| a.1 > b.1);
        if (low[1] > 0.0) == (high[1] > 0.0) || (rough.is_none() && !is_monotonic) {
            return Ok(rough.map(given));
        }
        let mut brent = Brent::new(low, high, LOCATED_WITHIN);
        while let Some(z) = brent.next() {
            brent.take(z, value(z));
        }
        let (sigma, weights) = (middle + brent.best() * step, weights(brent.best()));
        let near = rough.unwrap_or(&beside[1].2);
        let n = near.x.len();
        let [before, after] = [&beside[1].2, &beside[2].2].map(CurvePoint::slope);
        // A slope that is 0 elsewhere is that of a fold beside the crossing.
        let slope: f64 = weights.iter().zip(&beside).map(|(w, (.., point))| w * point.slope()).sum();
        let to_fold = slope * slope / (after - before) * step * near.units[n];
        let turns = before * after < 0.0 && same_parameter(near.p + to_fold, near.p);
        let turns = turns.then_some(before);
        let p = weights.iter().zip(&beside).map(|(w, (.., point))| w * point.p).sum();
        let x = weights.iter().zip(&beside).fold(DVector::zeros(n), |x, (w, (.., point))| x + &point.x * *w);
        let linear = self.curve.linearise(&x, p)?;
        if linear.residual.amax() > INTERPOLATED {
            return Ok(rough.map(|rough| Crossing { turns, ..given(rough) }));
        }
        let point = CurvePoint { x, p, solution: linear.solution, ..near.clone() };
        Ok(Some(Crossing { sigma, point, turns }))
    }
}
