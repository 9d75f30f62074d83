//! The derivative of the equations, bordered by a direction.

use faer::MatMut;
use faer::linalg::solvers::{PartialPivLu, Solve};
use nalgebra::{DMatrix, DVector, Dyn};

/// Factors of the matrix [J; tᵀ], with n rows of ∂G/∂(x, p) and the direction t as the last row.
pub(crate) struct Bordered {
    factors: Factors,
    size: usize,
    /// Sign of the determinant; 0 if it vanishes.
    pub(crate) sign: f64,
    /// ln |determinant|.
    pub(crate) logarithm: f64,
}

enum Factors {
    Small(nalgebra::LU<f64, Dyn, Dyn>),
    Large(PartialPivLu<f64>),
}

/// Maximum size for the LU factors of nalgebra. For larger matrices those of faer are faster.
const SMALL: usize = 40;

impl Bordered {
    /// Factors of `matrix`; `None` if an entry is not finite or a pivot is 0.
    pub(crate) fn new(matrix: DMatrix<f64>) -> Option<Self> {
        if matrix.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let n = matrix.nrows();
        let (factors, mut sign, pivots): (_, f64, Vec<f64>) = if n <= SMALL {
            let lu = matrix.lu();
            let pivots = lu.lu_internal().diagonal().iter().copied().collect();
            let sign = lu.p().determinant();
            (Factors::Small(lu), sign, pivots)
        } else {
            let lu = faer::MatRef::from_column_major_slice(matrix.as_slice(), n, n).partial_piv_lu();
            let pivots = (0..n).map(|i| lu.U()[(i, i)]).collect();
            let sign = parity(lu.P().arrays().0);
            (Factors::Large(lu), sign, pivots)
        };
        let mut logarithm = 0.0;
        for pivot in pivots {
            sign *= if pivot < 0.0 { -1.0 } else { 1.0 };
            logarithm += pivot.abs().ln();
        }
        logarithm.is_finite().then_some(Bordered { factors, size: n, sign, logarithm })
    }

    /// Solves for one right-hand side.
    pub(crate) fn solve(&self, mut right: DVector<f64>) -> DVector<f64> {
        match &self.factors {
            Factors::Small(lu) => {
                lu.solve_mut(&mut right);
            }
            Factors::Large(lu) => {
                lu.solve_in_place(MatMut::from_column_major_slice_mut(right.as_mut_slice(), self.size, 1));
            }
        }
        right
    }
}

/// The sign of a permutation.
fn parity(forward: &[usize]) -> f64 {
    let (mut seen, mut sign) = (vec![false; forward.len()], 1.0);
    for start in 0..forward.len() {
        let (mut at, mut length) = (start, 0);
        while !std::mem::replace(&mut seen[at], true) {
            (at, length) = (forward[at], length + 1);
        }
        if length > 0 && length % 2 == 0 {
            sign = -sign;
        }
    }
    sign
}

#[cfg(test)]
mod tests {
    use crate::branches::curve::bordered::Bordered;
    use nalgebra::{DMatrix, DVector};

    /// Both factorisations agree with the determinant of nalgebra, and solve.
    #[test]
    fn determinants_and_solutions() -> Result<(), &'static str> {
        for n in [1, 2, 5, 40, 41, 57] {
            let entry =
                |i: usize, j: usize| ((1 + 7 * i * i + 13 * j + 3 * i * j + n) as f64 * 0.618).fract() - 0.5;
            let matrix = DMatrix::from_fn(n, n, entry);
            let bordered = Bordered::new(matrix.clone()).ok_or("regular")?;
            let determinant = matrix.determinant();
            assert_eq!(bordered.sign, determinant.signum());
            assert!((bordered.logarithm - determinant.abs().ln()).abs() < 1e-9);
            let x = DVector::from_fn(n, |i, _| 1.0 + i as f64);
            assert!((bordered.solve(&matrix * &x) - x).amax() < 1e-8);
        }
        assert!(Bordered::new(DMatrix::zeros(2, 2)).is_none());
        Ok(())
    }
}
