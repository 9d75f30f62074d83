//! Coordinates that are a rigid motion each alone.

/// A square of a component of an orthonormal motion that is rounding.
const ROUNDING: f64 = 1e-16;

/// Largest cosine between the shares of two coordinates that do not belong together.
const APART: f64 = 1e-6;

/// The coordinates i that nothing connects: a change of q_i alone is a rigid motion. `modes`: orthonormal
/// rigid motions r.
///
/// The sum P of r rᵀ projects onto all rigid motions. The coordinate is one of them if P_ii = 1 and all other
/// P_ij = 0. P_ij is compared with √(P_ii P_jj), since coordinates may be angles and lengths.
pub(crate) fn unconnected(modes: &[Vec<f64>]) -> Vec<usize> {
    let n = modes.first().map_or(0, Vec::len);
    let shared = |i: usize, j: usize| modes.iter().map(|r| r[i] * r[j]).sum::<f64>();
    let own: Vec<f64> = (0..n).map(|i| shared(i, i)).collect();
    let apart =
        |i: usize, j: usize| own[j] < ROUNDING || shared(i, j).abs() <= APART * (own[i] * own[j]).sqrt();
    let alone = |i: &usize| own[*i] > 0.5 && (0..n).all(|j| j == *i || apart(*i, j));
    (0..n).filter(alone).collect()
}

/// The text of the errors of an unconnected coordinate that accelerates.
pub(crate) fn accelerates(coordinate: &usize, gain: &f64) -> String {
    format!(
        "nothing connects coordinate {coordinate}, which gains the velocity {gain:?} in every period of the orbit: \
         there is no periodic orbit; balance the forces on it, or leave it out"
    )
}

#[cfg(test)]
mod tests {
    use super::unconnected;

    /// A body alone beside a pair that turns together, also when their motions are mixed, and in other units.
    #[test]
    fn a_pair_is_connected_and_a_single_body_is_not() {
        let half = 0.5f64.sqrt();
        assert_eq!(unconnected(&[vec![1.0, 0.0, 0.0], vec![0.0, half, half]]), [0]);
        assert_eq!(unconnected(&[vec![half, 0.5, 0.5], vec![half, -0.5, -0.5]]), [0]);
        assert_eq!(unconnected(&[vec![1.0, 1e-6]]), [0usize; 0]);
        assert_eq!(unconnected(&[vec![1.0, 0.0], vec![0.0, 1.0]]), [0, 1]);
        assert_eq!(unconnected(&[]), [0usize; 0]);
    }
}
