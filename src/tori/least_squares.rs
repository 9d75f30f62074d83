//! Linear least squares by normal equations.

use nalgebra::DMatrix;

/// A pivot below this share of the largest one is not determined `[1]`.
const DETERMINED: f64 = 1e-6;

/// Coefficients C, one column for each value, with minimal Σ_k |row_k C - values_k|². `write` writes row k
/// and its values. `None`: the rows do not determine the coefficients.
///
/// The rows are sines and cosines at angles that are evenly spread, so that the normal equations are well
/// conditioned.
pub(crate) fn fit(
    count: usize,
    [unknowns, values]: [usize; 2],
    mut write: impl FnMut(usize, &mut [f64], &mut [f64]),
) -> Option<DMatrix<f64>> {
    if count < unknowns {
        return None;
    }
    let (mut gram, mut right) = (DMatrix::zeros(unknowns, unknowns), DMatrix::zeros(unknowns, values));
    let (mut row, mut here) = (vec![0.0; unknowns], vec![0.0; values]);
    for k in 0..count {
        write(k, &mut row, &mut here);
        // The Cholesky factors read the lower triangle.
        for (j, column) in gram.as_mut_slice().chunks_exact_mut(unknowns).enumerate() {
            column[j..].iter_mut().zip(&row[j..]).for_each(|(g, x): (&mut f64, _)| *g += x * row[j]);
        }
        for (column, y) in right.as_mut_slice().chunks_exact_mut(unknowns).zip(&here) {
            column.iter_mut().zip(&row).for_each(|(b, x): (&mut f64, _)| *b += x * y);
        }
    }
    let factors = gram.cholesky()?;
    let pivots = factors.l_dirty().diagonal().map(|l| l * l);
    (pivots.min() > DETERMINED * pivots.max()).then(|| factors.solve(&right))
}
