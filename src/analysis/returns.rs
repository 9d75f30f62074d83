//! When a motion repeats after several periods.

use crate::analysis::changes::{contraction, distance, envelope};

/// Largest ratio of the distance after p periods to the distance after a proper divisor of p, for an orbit of
/// p periods. A motion that spirals into a shorter orbit may also return closer after a multiple of its
/// period.
const CLOSER: f64 = 1e-3;

/// Whether d_p <= `CLOSER` d_k for every proper divisor k of p: the orbit is p periods long and no shorter.
///
/// `returns` holds the distances d_1, d_2, ..., d_p after 1, 2, ..., p periods.
pub(crate) fn is_own_multiple(returns: &[f64]) -> bool {
    let (p, last) = (returns.len(), returns[returns.len() - 1]);
    (1..p).filter(|d| p.is_multiple_of(*d)).all(|d| last <= CLOSER * returns[d - 1])
}

/// A change that is rounding, as a share of the range of the motion `[1]`: it need not shrink.
const STILL: f64 = 1e-12;

/// A return of the strobed states y_0 (newest), y_1, y_2, ... of a motion.
pub(crate) struct Return {
    /// The minimum p with |y_k - y_(k + p)| <= tolerance for k = 0 .. p that [is its own](is_own_multiple); 0
    /// if there is none.
    pub(crate) multiple: usize,
    /// |y_p - y_0|; without a multiple the minimum of |y_d - y_0| over all d for which the run is long enough.
    pub(crate) change: f64,
    /// Estimate of the distance from the orbit, from the changes after p, 2 p, ... periods: a motion that
    /// decays slowly changes little long before it repeats.
    pub(crate) left: f64,
}

impl Return {
    /// The return of `states`, the newest first, after at most `longest` periods. `apart`: their distance.
    pub(crate) fn of(
        states: &[&[f64]],
        longest: usize,
        tolerance: f64,
        mut apart: impl FnMut(&[f64], &[f64]) -> f64,
    ) -> Self {
        let mut returns = Vec::with_capacity(longest);
        for p in (1..=longest).take_while(|p| states.len() > 2 * p) {
            returns.push(apart(states[0], states[p]));
            if is_own_multiple(&returns) && (0..=p).all(|k| apart(states[k], states[k + p]) <= tolerance) {
                let each: Vec<&[f64]> = states.iter().copied().step_by(p).collect();
                let changes: Vec<f64> = each.windows(2).map(|two| apart(two[0], two[1])).collect();
                let mu = contraction(&changes);
                let left = if changes[0] <= STILL { 0.0 } else { distance(envelope(&changes, mu), mu) };
                return Return { multiple: p, change: changes[0], left };
            }
        }
        let closest = returns.into_iter().fold(f64::INFINITY, f64::min);
        Return { multiple: 0, change: closest, left: f64::INFINITY }
    }
}
