//! The derivative of the equations, bordered by a direction.

use crate::roots::factors::Factors;
use nalgebra::{DMatrix, DVector};

/// Factors of the matrix [J; tᵀ], with n rows of ∂G/∂(x, p) and the direction t as the last row.
pub(crate) struct Bordered {
    factors: Factors,
    /// Sign of the determinant.
    pub(crate) sign: f64,
    /// ln |determinant|.
    pub(crate) logarithm: f64,
}

impl Bordered {
    /// Factors of `matrix`; `None` if an entry is not finite or a pivot is 0.
    pub(crate) fn new(matrix: DMatrix<f64>) -> Option<Self> {
        if matrix.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let factors = Factors::lu(matrix.as_slice(), matrix.nrows());
        let (sign, logarithm) = factors.determinant()?;
        logarithm.is_finite().then_some(Bordered { factors, sign, logarithm })
    }

    /// Solves for one right-hand side.
    pub(crate) fn solve(&self, mut right: DVector<f64>) -> DVector<f64> {
        self.factors.solve(right.as_mut_slice());
        right
    }
}

#[cfg(test)]
mod tests {
    use crate::branches::curve::bordered::Bordered;
    use nalgebra::{DMatrix, DVector};

    /// Both factorisations agree with the determinant of nalgebra, and solve.
    #[test]
    fn determinants_and_solutions() -> Result<(), &'static str> {
        for n in [1, 2, 5, 40, 41, 57] {
            let part =
                |i: usize, j: usize| ((1 + 7 * i * i + 13 * j * j + 5 * i * j) as f64 * 0.618).fract() - 0.5;
            let entry = |i: usize, j: usize| part(i, j) + if i == j { 2.0 } else { 0.0 };
            let matrix = DMatrix::from_fn(n, n, entry);
            let bordered = Bordered::new(matrix.clone()).ok_or("regular")?;
            let determinant = matrix.determinant();
            assert_eq!(bordered.sign, determinant.signum(), "{n}");
            assert!((bordered.logarithm - determinant.abs().ln()).abs() < 1e-9);
            let x = DVector::from_fn(n, |i, _| 1.0 + i as f64);
            assert!((bordered.solve(&matrix * &x) - x).amax() < 1e-8);
        }
        assert!(Bordered::new(DMatrix::zeros(2, 2)).is_none());
        Ok(())
    }
}
