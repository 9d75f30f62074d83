//! Singular values of matrices. Plain loops decompose small ones, with the same bits on every processor.

use crate::numeric::norms::dot;
use faer::Mat;
use nalgebra::DMatrix;

/// Number of columns from which blocked code is faster. Its order of summation depends on the processor.
pub(super) const LARGE: usize = 128;

/// Columns are orthogonal where their scalar product is below this share of their lengths `[1]`.
const ORTHOGONAL: f64 = f64::EPSILON;

/// Maximum number of sweeps over all pairs of columns. Some six to ten orthogonalise them.
const SWEEPS: usize = 60;

/// Singular values of a matrix of `columns` in decreasing order, and the directions v that belong to them.
/// `None` if they do not converge.
pub(super) fn singular(columns: Vec<Vec<f64>>) -> Option<Vec<(f64, Vec<f64>)>> {
    let k = columns.len();
    if k < LARGE {
        return Some(by_rotations(columns));
    }
    let svd = Mat::from_fn(columns[0].len(), k, |i, j| columns[j][i]).thin_svd().ok()?;
    let direction = |c: usize| (0..k).map(|i| svd.V()[(i, c)]).collect();
    Some((0..k).map(|c| (svd.S()[c], direction(c))).collect())
}

/// One-sided Jacobi rotations.   Source: Golub and Van Loan, Matrix Computations, Sect. 8.6.3.
fn by_rotations(columns: Vec<Vec<f64>>) -> Vec<(f64, Vec<f64>)> {
    let k = columns.len();
    // The triangular factor has the singular values and directions of the matrix.
    let triangle = matrix_of(&columns).qr().r();
    let mut left: Vec<Vec<f64>> =
        triangle.column_iter().map(|column| column.iter().copied().collect()).collect();
    let unit = |j: usize| (0..k).map(|i| f64::from(u8::from(i == j))).collect();
    let mut right: Vec<Vec<f64>> = (0..k).map(unit).collect();
    for _ in 0..SWEEPS {
        let mut turned = false;
        for j in 1..k {
            for i in 0..j {
                let (a, b, c) = (dot(&left[i], &left[i]), dot(&left[j], &left[j]), dot(&left[i], &left[j]));
                if c.abs() <= ORTHOGONAL * (a * b).sqrt() {
                    continue;
                }
                turned = true;
                let zeta = (b - a) / (2.0 * c);
                let tangent = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
                let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
                for columns in [&mut left, &mut right] {
                    let (low, high) = columns.split_at_mut(j);
                    for (x, y) in low[i].iter_mut().zip(&mut high[0]) {
                        (*x, *y) = (cosine * (*x - tangent * *y), cosine * (tangent * *x + *y));
                    }
                }
            }
        }
        if !turned {
            break;
        }
    }
    let values = left.iter().map(|column| dot(column, column).sqrt());
    let mut found: Vec<(f64, Vec<f64>)> = values.zip(right).collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found
}

/// Makes columns orthonormal.
pub(super) fn orthonormal(columns: &mut [Vec<f64>]) {
    let q = matrix_of(columns).qr().q();
    columns.iter_mut().zip(q.column_iter()).for_each(|(x, q)| x.copy_from_slice(q.as_slice()));
}

fn matrix_of(columns: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(columns.first().map_or(0, Vec::len), columns.len(), |i, j| columns[j][i])
}

#[cfg(test)]
mod tests {
    use crate::model::structure::singular::{orthonormal, singular};
    use crate::numeric::norms::dot;
    use crate::numeric::spread::golden;

    /// A = U S Vᵀ of known factors, with values over 14 orders and one of 0.
    #[test]
    fn values_and_directions_of_known_factors() {
        for (rows, k) in [(1, 1), (3, 3), (12, 5), (40, 20)] {
            let random = |seed: usize, n: usize| {
                let entry = |i: usize, j: usize| golden((seed + 31 * i + j) as f64) - 0.5;
                let mut columns: Vec<Vec<f64>> =
                    (0..k).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect();
                orthonormal(&mut columns);
                columns
            };
            let (u, v) = (random(3, rows), random(17, k));
            let value =
                |c: usize| if c + 1 == k && k > 1 { 0.0 } else { 10f64.powf(-13.0 * c as f64 / k as f64) };
            let values: Vec<f64> = (0..k).map(value).collect();
            let column = |j: usize| -> Vec<f64> {
                (0..rows).map(|i| (0..k).map(|c| u[c][i] * values[c] * v[c][j]).sum()).collect()
            };
            let found = singular((0..k).map(column).collect()).unwrap();
            for (c, ((value, direction), exact)) in found.iter().zip(&values).enumerate() {
                assert!((value - exact).abs() < 1e-14 * k as f64, "{rows} {k} {c}: {value} {exact}");
                assert!((dot(direction, direction) - 1.0).abs() < 1e-13);
                if *exact > 1e-3 || c + 1 == k {
                    assert!((dot(direction, &v[c]).abs() - 1.0).abs() < 1e-9, "{rows} {k} {c}");
                }
            }
        }
    }
}
