//! When a motion repeats after several periods.

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
