//! Least solutions of linear equations that may be singular.

use crate::numeric::norms::decomposition;
use faer::Mat;
use nalgebra::{DMatrix, DVector};

/// Number of equations from which a factorisation with pivots replaces a singular value decomposition, which
/// takes longer.
const PIVOTS_FROM: usize = 128;

/// Largest singular value that counts as 0, of equations with rows and columns of size 1; with pivots the
/// largest entry on the diagonal of R, as a share of the first one.
const ZERO: f64 = 1e-13;

/// The shortest x with A x = b, for at least as many unknowns as equations. Equations that depend on each
/// other may contradict each other. Below 128 equations x then has the least residual |A x - b|. From 128
/// equations on, a QR factorisation with pivots selects the independent equations. x solves these. `None`:
/// the singular value decomposition does not converge.
pub(crate) fn least_solution(matrix: DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let n = matrix.nrows();
    if n < PIVOTS_FROM {
        return decomposition(matrix, true)?.solve(right, ZERO).ok();
    }
    // Aᵀ = Q R with the columns in another order: Rᵀ z = b and x = Q z.
    let factors = Mat::from_fn(matrix.ncols(), n, |i, j| matrix[(j, i)]).col_piv_qr();
    let (r, order) = (factors.thin_R(), factors.P().arrays().0);
    let mut z = Mat::<f64>::zeros(n, 1);
    for j in (0..n).take_while(|&j| r[(j, j)].abs() > ZERO * r[(0, 0)].abs()) {
        let known: f64 = (0..j).map(|i| r[(i, j)] * z[(i, 0)]).sum();
        z[(j, 0)] = (right[order[j]] - known) / r[(j, j)];
    }
    let x = factors.compute_thin_Q() * z;
    Some(DVector::from_fn(matrix.ncols(), |i, _| x[(i, 0)]))
}

#[cfg(test)]
mod tests {
    use crate::numeric::equations::least::{PIVOTS_FROM, least_solution};
    use nalgebra::{DMatrix, DVector};

    /// Both ways: equations of a chain that is held at one end, with one unknown too many; the same with an
    /// equation that depends on the others.
    #[test]
    fn least_solutions_agree() {
        for n in [PIVOTS_FROM, PIVOTS_FROM - 1] {
            let entry = |i: usize, j: usize| match j.abs_diff(i) {
                0 => 2.5,
                1 => -1.0,
                _ if j == n => 0.1 * i as f64 / n as f64,
                _ => 0.0,
            };
            let mut matrix = DMatrix::from_fn(n, n + 1, entry);
            for dependent in [false, true] {
                if dependent {
                    let copy = matrix.row(3).clone_owned();
                    matrix.set_row(7, &copy);
                }
                let right = &matrix * DVector::from_fn(n + 1, |i, _| (i as f64).sin());
                let x = least_solution(matrix.clone(), &right).unwrap();
                assert!((&matrix * &x - &right).amax() < 1e-12);
                // The least solution is orthogonal to the kernel, which is one direction unless rows are
                // equal.
                if !dependent {
                    let square = matrix.columns(0, n).clone_owned();
                    let mut k = square.lu().solve(&-matrix.columns(n, 1)).unwrap().data.as_vec().clone();
                    k.push(1.0);
                    let k = DVector::from_vec(k);
                    assert!(k.dot(&x).abs() < 1e-12 * k.norm() * x.norm());
                }
            }
        }
    }
}
