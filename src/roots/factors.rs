//! LU factors of a Jacobian, and the solution of a linear system by them.

use crate::error::{ParameterError, check};
use crate::numeric::norms::floating;
use crate::roots::elimination::Elimination;
use crate::roots::matrix::Matrix;
use faer::linalg::solvers::{PartialPivLu, Solve};
use faer::{MatMut, MatRef};
use nalgebra::{DMatrix, DVectorViewMut, Dyn};

/// LU factors of a [`Matrix`].
pub(crate) enum Factors {
    Small(nalgebra::LU<f64, Dyn, Dyn>),
    Dense(PartialPivLu<f64>),
    Blocks(Elimination),
}

/// Index of an unknown that the equations do not determine.
pub(crate) struct Floating(pub(crate) usize);

/// Maximum size of a dense matrix for the LU factors of nalgebra. For larger ones those of faer are faster.
const SMALL: usize = 40;

impl Factors {
    pub(crate) fn new(a: &Matrix) -> Result<Self, Floating> {
        if let Some(values) = a.single() {
            return Factors::of_dense(values, a.size());
        }
        let mut finite = true;
        a.each(|_, _, value| finite &= value.is_finite());
        match Elimination::new(a) {
            Ok(blocks) if blocks.is_sound(a) => Ok(Factors::Blocks(blocks)),
            Err(unknown) if !finite => Err(Floating(unknown)),
            // A diagonal block is singular or the factors are inaccurate: pivots outside the block are
            // needed.
            _ => Factors::of_dense(DMatrix::from(a).as_slice(), a.size()),
        }
    }

    /// LU factors of a dense matrix, with pivots from the whole column.
    fn of_dense(values: &[f64], n: usize) -> Result<Self, Floating> {
        let factors = Factors::lu(values, n);
        let found = match &factors {
            Factors::Small(lu) => floating(n, |i, j| lu.lu_internal()[(i, j)]),
            Factors::Dense(lu) => floating(n, |i, j| lu.U()[(i, j)]),
            Factors::Blocks(_) => None,
        };
        found.map_or(Ok(factors), |unknown| Err(Floating(unknown)))
    }

    /// LU factors of a dense matrix, singular or not.
    pub(crate) fn lu(values: &[f64], n: usize) -> Self {
        if n <= SMALL {
            Factors::Small(nalgebra::LU::new(DMatrix::from_column_slice(n, n, values)))
        } else {
            Factors::Dense(MatRef::from_column_major_slice(values, n, n).partial_piv_lu())
        }
    }

    /// Sign and logarithm of the absolute value of the determinant; `None` for factors by blocks.
    pub(crate) fn determinant(&self) -> Option<(f64, f64)> {
        let (mut sign, pivots): (f64, Vec<f64>) = match self {
            Factors::Small(lu) => {
                (lu.p().determinant(), lu.lu_internal().diagonal().iter().copied().collect())
            }
            Factors::Dense(lu) => {
                let n = lu.U().nrows();
                (parity(lu.P().arrays().0), (0..n).map(|i| lu.U()[(i, i)]).collect())
            }
            Factors::Blocks(_) => return None,
        };
        let mut logarithm = 0.0;
        for pivot in pivots {
            sign *= if pivot < 0.0 { -1.0 } else { 1.0 };
            logarithm += pivot.abs().ln();
        }
        Some((sign, logarithm))
    }

    /// x ← A⁻¹ x.
    pub(crate) fn solve(&self, x: &mut [f64]) {
        let n = x.len();
        match self {
            Factors::Small(lu) => {
                lu.solve_mut(&mut DVectorViewMut::from_slice(x, n));
            }
            Factors::Dense(lu) => lu.solve_in_place(MatMut::from_column_major_slice_mut(x, n, 1)),
            Factors::Blocks(elimination) => elimination.solve(x),
        }
    }
}

impl Matrix {
    /// x = A⁻¹ b, for root finders of one's own: the same elimination by blocks as in
    /// [`Newton`](crate::roots::Newton).
    ///
    /// ```
    /// use gear_dynamics::roots::Matrix;
    /// let mut a = Matrix::dense(2);
    /// a.column_mut(0).copy_from_slice(&[2.0, 0.0]);
    /// a.column_mut(1).copy_from_slice(&[1.0, 4.0]);
    /// assert_eq!(a.solve(&[4.0, 8.0])?, [1.0, 2.0]);
    /// let singular = Matrix::dense(2).solve(&[1.0, 1.0]).unwrap_err();
    /// assert!(singular.to_string().starts_with("the matrix is singular"));
    /// # Ok::<(), gear_dynamics::ParameterError>(())
    /// ```
    ///
    /// # Errors
    /// [`ParameterError::Length`] for a right-hand side of another length; [`ParameterError::Singular`],
    /// which names the unknown that the matrix does not determine.
    pub fn solve(&self, right: &[f64]) -> Result<Vec<f64>, ParameterError> {
        check::length("right-hand side", right.len(), self.size())?;
        let factors = Factors::new(self).map_err(|Floating(unknown)| ParameterError::Singular { unknown })?;
        let mut x = right.to_vec();
        factors.solve(&mut x);
        Ok(x)
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
    use crate::model::equations::{Model, Periodic};
    use crate::model::state::State;
    use crate::models::ring::ring_params::RingSet;
    use crate::models::ring::ring_shape::{Frame, Ring};
    use crate::ode::integrator::Integrator;
    use crate::ode::methods::dop853::Dop853;
    use crate::periodic::balance::fourier_orbit::FourierOrbit;
    use crate::periodic::balance::series::harmonics::Harmonics;
    use crate::periodic::balance::settings::Balance;
    use crate::roots::factors::Factors;
    use crate::roots::residual::Residual;

    /// In a state of a run every gear remains coupled to its neighbours: no block needs pivots from outside.
    #[test]
    fn rings_are_eliminated_in_blocks() -> Result<(), Box<dyn std::error::Error>> {
        let set = RingSet { error: 1e-5, ..RingSet::set_a(8, 3000.0) };
        let (ring, moving) =
            (Ring::new(&set.params()?)?, Ring::new(&set.params()?)?.with_frame(Frame::Rigid));
        let end = Dop853::new().end(&moving, &State::at_rest(ring.dof()), 20.0 * ring.period())?;
        let balance = Balance::new(Harmonics::up_to(5));
        let guess = FourierOrbit::project(&Dop853::new(), &moving, &end, balance.harmonics())?;
        let mut equations = balance.equations(&ring, &guess)?;
        let (x, mut matrix) = (equations.unknowns(&guess), equations.matrix());
        equations.jacobian(&x, &mut matrix);
        assert!(matches!(Factors::new(&matrix), Ok(Factors::Blocks(_))));
        Ok(())
    }
}
