//! Scalar products, largest components and singular vectors.

use nalgebra::{DMatrix, Dyn, SVD};

/// aᵀ b.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// max |x_i|; NaN if one of them is.
pub(crate) fn largest(x: &[f64]) -> f64 {
    let any_nan = x.iter().any(|x| x.is_nan());
    if any_nan { f64::NAN } else { x.iter().map(|x| x.abs()).fold(0.0, |m, x| if x > m { x } else { m }) }
}

/// max |x_i/s_i|: the largest component as a share of its size. NaN does not count.
pub(crate) fn largest_share(x: &[f64], sizes: &[f64]) -> f64 {
    x.iter().zip(sizes).fold(0.0, |m, (x, s)| m.max((x / s).abs()))
}

/// x ← x - r (rᵀ x), r of length 1: removes the component along r.
pub(crate) fn remove(r: &[f64], x: &mut [f64]) {
    let along = dot(r, x);
    x.iter_mut().zip(r).for_each(|(x, r)| *x -= along * r);
}

/// Maximum number of iterations of a singular value decomposition.
const SWEEPS: usize = 10_000;

/// Values outside this range are scaled before a decomposition: their squares may overflow or vanish.
const SQUARES: std::ops::Range<f64> = 1e-100..1e100;

/// The singular value decomposition in any order of the values. `None` if an entry or a value is not finite,
/// or if it does not converge.
pub(crate) fn decomposition(matrix: DMatrix<f64>, left: bool) -> Option<SVD<f64, Dyn, Dyn>> {
    if !matrix.iter().all(|x| x.is_finite()) {
        return None;
    }
    let svd = SVD::try_new_unordered(matrix, left, true, f64::EPSILON, SWEEPS)?;
    svd.singular_values.iter().all(|value| value.is_finite()).then_some(svd)
}

/// The right singular vectors of a matrix with at least as many rows as columns, one in each row, by
/// decreasing singular values. It returns `None` where [`decomposition`] does.
pub(crate) fn right_vectors(matrix: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let largest = matrix.amax();
    let scaled = if SQUARES.contains(&largest) || largest == 0.0 { matrix } else { matrix / largest };
    let svd = decomposition(scaled, false)?;
    let (values, vectors) = (&svd.singular_values, svd.v_t.as_ref()?);
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&i, &j| values[j].total_cmp(&values[i]));
    Some(DMatrix::from_fn(order.len(), vectors.ncols(), |i, j| vectors[(order[i], j)]))
}

/// Index of the largest entry of the null vector of U, an upper triangular matrix of size n; `None` if U is
/// not singular to rounding.
pub(crate) fn floating(n: usize, u: impl Fn(usize, usize) -> f64) -> Option<usize> {
    // Each pivot is compared with its own column and not with the whole matrix, because equations and
    // unknowns may have very different sizes.
    let vanishes = |i: usize| {
        let size = (0..=i).fold(0.0, |m: f64, k| m.max(u(k, i).abs()));
        u(i, i).is_nan() || u(i, i).abs() <= 16.0 * f64::EPSILON * size
    };
    let column = (0..n).find(|&i| vanishes(i))?;
    let mut null = vec![0.0; column + 1];
    null[column] = 1.0;
    for i in (0..column).rev() {
        let sum: f64 = (i + 1..=column).map(|j| u(i, j) * null[j]).sum();
        null[i] = -sum / u(i, i);
    }
    (0..=column).max_by(|&a, &b| null[a].abs().total_cmp(&null[b].abs()))
}

#[cfg(test)]
mod tests {
    use crate::numeric::norms::right_vectors;
    use nalgebra::DMatrix;

    /// A matrix of rank 1 in several units; what is not finite has no vectors.
    #[test]
    fn right_vectors_of_any_size() {
        for size in [1e-250, 1.0, 1e250] {
            let vectors =
                right_vectors(DMatrix::from_fn(3, 2, |i, j| size * [3.0, 4.0][j] * (i as f64 + 1.0)));
            let vectors = vectors.unwrap();
            assert!(
                (vectors[(0, 0)].abs() - 0.6).abs() < 1e-14 && (vectors[(1, 0)].abs() - 0.8).abs() < 1e-14
            );
        }
        assert!(right_vectors(DMatrix::from_element(2, 2, f64::NAN)).is_none());
        assert!(right_vectors(DMatrix::from_element(2, 2, f64::INFINITY)).is_none());
    }

    #[test]
    fn nan_counts_as_the_largest() {
        for at in 0..3 {
            let mut x = [1.0, -2.0, 0.5];
            assert_eq!(crate::numeric::norms::largest(&x), 2.0);
            x[at] = f64::NAN;
            assert!(crate::numeric::norms::largest(&x).is_nan());
        }
    }

    #[test]
    fn shares_of_sizes() {
        assert_eq!(crate::numeric::norms::largest_share(&[3.0, -1.0, f64::NAN], &[2.0, 0.5, 1.0]), 2.0);
    }
}
