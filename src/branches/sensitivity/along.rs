//! Derivatives of functions of the multipliers along a direction.

use crate::branches::branch_error::BranchError;
use crate::branches::curve::equations::CurveError;
use crate::branches::sensitivity::totals::Totals;
use crate::error::ParameterError;
use crate::model::Periodic;
use crate::numeric::differences::{CENTRAL, ONE_SIDED};
use crate::periodic::Multipliers;
use nalgebra::DVector;

/// Step of the differences, in units of the constants.
const CONSTANT_STEP: f64 = 1e-4;

/// Shares of the step that follow if the first two derivatives differ.
const SMALLER_STEPS: [f64; 4] = [0.1, 0.03, 0.01, 0.003];

/// Difference of two derivatives that is rounding `[1]`.
const AGREES: f64 = 1e-6;

/// Shares of the step of one-sided differences, one a tenth of the other.
const DECADES: [f64; 4] = [1.0, 0.1, 0.01, 0.001];

/// Least growth of a difference over each decade that shows an unbounded derivative: a root grows by √10.
const UNBOUNDED_GROWTH: f64 = 2.0;

/// Differences below this over the smallest step are rounding `[1]`.
const ROUNDING: f64 = 1e-3;

/// [d-, d+] of a function of the multipliers at x + h `along` of the models `model(h)`: for decreasing and
/// for increasing h.
///
/// Near a change of the contact sequence the multipliers bend sharply: if a step ten times smaller gives
/// another derivative, smaller steps follow, and the two neighbours that agree best decide. If the number of
/// crossings differs on both sides even over the smallest step, the derivatives of both sides follow. On a
/// side without a model, where a constant is at the end of its range, the derivative is NaN.
pub(crate) fn along_direction<'m>(
    totals: &Totals<'_>,
    along: &DVector<f64>,
    model: &dyn Fn(f64) -> Result<Box<dyn Periodic + 'm>, ParameterError>,
    of: &dyn Fn(&Multipliers) -> Option<f64>,
) -> Result<[f64; 2], BranchError> {
    let length = (0..along.len()).map(|j| (along[j] / totals.size(j)).abs()).fold(1.0, f64::max);
    let unit = CONSTANT_STEP / length;
    // The value and the number of crossings.
    let at = |h: f64| -> Result<(f64, u64), BranchError> {
        let x = &totals.x + along * h;
        let passage = totals.curve.pass(&*model(h)?, &x)?;
        let value = passage.multipliers.as_ref().and_then(of);
        Ok((value.ok_or(CurveError::Singular)?, passage.crossings()))
    };
    // The derivative over places on both sides, and whether both sides cross equally many edges.
    let central = |share: f64| -> Result<(f64, bool), BranchError> {
        let (mut sum, mut sides) = (0.0, [0, 0]);
        for (place, weight) in CENTRAL {
            let (value, crossings) = at(place * share * unit)?;
            sum += weight * value / (share * unit);
            sides[usize::from(place > 0.0)] += crossings;
        }
        Ok((sum, sides[0] == sides[1]))
    };
    let one_sided = |way: f64| -> Result<f64, BranchError> {
        let mut slopes = [0.0; DECADES.len()];
        for (slope, share) in slopes.iter_mut().zip(DECADES) {
            for (place, weight) in ONE_SIDED {
                *slope += way * weight * at(way * place * share * unit)?.0 / (share * unit);
            }
        }
        let last = slopes[DECADES.len() - 1];
        if last.abs() > ROUNDING
            && slopes.windows(2).all(|two| two[1].abs() > UNBOUNDED_GROWTH * two[0].abs())
        {
            return Ok(f64::INFINITY.copysign(last));
        }
        let closest = (1..slopes.len()).min_by(|&i, &j| {
            let change = |k: usize| (slopes[k] - slopes[k - 1]).abs();
            change(i).total_cmp(&change(j))
        });
        Ok(slopes[closest.unwrap_or(0)])
    };
    let farthest = ONE_SIDED[ONE_SIDED.len() - 1].0 * unit;
    match [-farthest, farthest].map(|h| model(h).is_ok()) {
        [true, true] => {}
        [false, true] => return Ok([f64::NAN, one_sided(1.0)?]),
        [true, false] => return Ok([one_sided(-1.0)?, f64::NAN]),
        [false, false] => model(farthest).map(drop)?,
    }
    let (first, mut alike) = central(1.0)?;
    let (mut before, mut best, mut least) = (first, first, f64::INFINITY);
    for finer in SMALLER_STEPS {
        let (next, same) = central(finer)?;
        let change = (next - before).abs();
        if change <= AGREES * next.abs().max(1.0) && least == f64::INFINITY && alike {
            return Ok([first; 2]);
        }
        if change < least {
            (best, least) = (next, change);
        }
        (before, alike) = (next, same);
    }
    if alike {
        return Ok([best; 2]);
    }
    Ok([one_sided(-1.0)?, one_sided(1.0)?])
}

/// The derivative where both sides agree, or where one of them does not exist.
///
/// # Errors
/// [`CurveError::OneSided`] where they differ.
pub(crate) fn smooth([left, right]: [f64; 2]) -> Result<f64, CurveError> {
    match (left.is_nan(), right.is_nan()) {
        (true, _) => Ok(right),
        (_, true) => Ok(left),
        _ if left == right => Ok(left),
        _ => Err(CurveError::OneSided),
    }
}
