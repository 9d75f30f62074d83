//! Units that balance a square matrix.

use nalgebra::DMatrix;

/// Units d of the coordinates, powers of 2, that balance the matrix A. With D = diag(d), row i and column i
/// of D⁻¹ A D have sums of absolute values of about the same size.   Source: Parlett and Reinsch, Numerische
/// Mathematik 13 (1969). They leave out the diagonal. Here the diagonal is part of both sums, so that a
/// coordinate keeps its unit if it drives others and no other drives it.
pub(crate) fn balancing(a: &DMatrix<f64>) -> Vec<f64> {
    /// Most rounds: each one brings the sums closer, a few are enough.
    const ROUNDS: usize = 100;
    let n = a.nrows();
    let mut d = vec![1.0; n];
    for _ in 0..ROUNDS {
        let mut changed = false;
        for i in 0..n {
            let row: f64 = (0..n).map(|j| a[(i, j)].abs() * (d[j] / d[i])).sum();
            let column: f64 = (0..n).map(|j| a[(j, i)].abs() * (d[i] / d[j])).sum();
            // The sums become equal with the unit sqrt(row/column) d.
            let factor = (0.5 * (row / column).log2()).round().exp2();
            if factor.is_finite() && factor > 0.0 && factor != 1.0 {
                (d[i], changed) = (d[i] * factor, true);
            }
        }
        if !changed {
            break;
        }
    }
    d
}
