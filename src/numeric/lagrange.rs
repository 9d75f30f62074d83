//! Lagrange polynomials.

/// Coefficients of the Lagrange polynomials L_i of some nodes, L_i(x_i) = 1 and L_i(x_j) = 0: entry `[i][m]`
/// is that of x^m in L_i.
pub(crate) fn lagrange<const N: usize>(nodes: [f64; N]) -> [[f64; N]; N] {
    std::array::from_fn(|i| {
        let mut p = [0.0; N];
        p[0] = 1.0;
        for j in (0..N).filter(|&j| j != i) {
            let (root, scale) = (nodes[j], 1.0 / (nodes[i] - nodes[j]));
            for m in (0..N).rev() {
                p[m] = scale * (if m > 0 { p[m - 1] } else { 0.0 } - root * p[m]);
            }
        }
        p
    })
}

/// Σ_i f_i Π_{j≠i} (x - x_j)/(x_i - x_j): value at x = `at` of the cubic through four points (x_i, f_i).
pub(crate) fn cubic(x: [f64; 4], f: [f64; 4], at: f64) -> f64 {
    (0..4)
        .map(|i| f[i] * (0..4).filter(|&j| j != i).map(|j| (at - x[j]) / (x[i] - x[j])).product::<f64>())
        .sum()
}

#[cfg(test)]
mod tests {
    use super::lagrange;

    #[test]
    fn polynomials_are_one_at_their_node() {
        let nodes = [-1.0, 0.5, 2.0, 3.0];
        for (i, p) in lagrange(nodes).iter().enumerate() {
            for (j, x) in nodes.iter().enumerate() {
                let value = p.iter().rev().fold(0.0, |sum, c| sum * x + c);
                assert!((value - if i == j { 1.0 } else { 0.0 }).abs() < 1e-14, "{i} {j} {value}");
            }
        }
    }
}
