//! Inertias of a model from the symmetry of its stiffness.

use nalgebra::DMatrix;

/// Relative difference up to which two numbers count as equal.
const EQUAL: f64 = 1e-9;

/// Diagonal inertias m with m_i A_ij = m_j A_ji for A = M⁻¹ K, of each connected set of coordinates relative
/// to its first one. `None` if there are none: the stiffness is not symmetric or the inertia not diagonal.
pub(crate) fn inertias(a: &DMatrix<f64>) -> Option<Vec<f64>> {
    let n = a.nrows();
    let mut m = vec![f64::NAN; n];
    // Each row has its own size: a row of a small inertia is large.
    let largest: Vec<f64> = a.row_iter().map(|row| row.amax()).collect();
    let couples =
        |i: usize, j: usize| a[(i, j)].abs() > 1e-14 * largest[i] || a[(j, i)].abs() > 1e-14 * largest[j];
    for start in 0..n {
        if !m[start].is_nan() {
            continue;
        }
        m[start] = 1.0;
        let mut open = vec![start];
        while let Some(i) = open.pop() {
            for j in (0..n).filter(|&j| j != i && couples(i, j)) {
                let (ij, ji) = (a[(i, j)], a[(j, i)]);
                let ratio = ij / ji;
                if !(ratio > 0.0 && ratio.is_finite()) {
                    // Rounding in both rows is no coupling.
                    let rounding = |row: usize, x: f64| x.abs() <= 1e-13 * a.row(row).amax();
                    if rounding(i, ij) && rounding(j, ji) {
                        continue;
                    }
                    return None;
                }
                let required = m[i] * ratio;
                if m[j].is_nan() {
                    m[j] = required;
                    open.push(j);
                } else if (required / m[j] - 1.0).abs() > EQUAL {
                    // Weak couplings have few correct digits.
                    let strength = (ij * ji).abs().sqrt() / (a[(i, i)] * a[(j, j)]).abs().sqrt();
                    if (required / m[j] - 1.0).abs() * strength > EQUAL {
                        return None;
                    }
                }
            }
        }
    }
    Some(m)
}
