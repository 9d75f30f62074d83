//! Equations of a motion whose rigid part is held.

use crate::numeric::equations::entries::Entries;
use crate::numeric::equations::factors::Factors;
use crate::numeric::norms::dot;
use nalgebra::{DMatrix, DVector, Dyn, LU};

/// The equations A x + R α = b and Rᵀ x = 0 for a sparse A with a shift of its diagonal and a few columns of
/// R.
pub(crate) struct Bordered {
    factors: Factors,
    /// The columns of R, and of A⁻¹ R.
    columns: Vec<[Vec<f64>; 2]>,
    /// Factors of Rᵀ A⁻¹ R; `None`: R has no columns.
    of_border: Option<LU<f64, Dyn, Dyn>>,
}

impl Bordered {
    /// The equations with A + diag(shift) in place of A. `None`: a pivot is 0, or the columns of R depend on
    /// each other.
    pub(crate) fn of(a: &Entries, shift: &[f64], r: &DMatrix<f64>) -> Option<Self> {
        let factors = Factors::of(a, shift)?;
        let column = |j: usize| {
            let column: Vec<f64> = r.column(j).iter().copied().collect();
            let mut solved = column.clone();
            factors.solve(&mut solved);
            [column, solved]
        };
        let columns: Vec<_> = (0..r.ncols()).map(column).collect();
        let k = columns.len();
        let border = || DMatrix::from_fn(k, k, |i, j| dot(&columns[i][0], &columns[j][1])).lu();
        let of_border = (k > 0).then(border);
        let singular = of_border.as_ref().is_some_and(|border| !border.is_invertible());
        (!singular).then_some(Bordered { factors, columns, of_border })
    }

    /// x and α for a right side b. `None`: they are not finite.
    pub(crate) fn solve(&self, mut b: Vec<f64>) -> Option<(Vec<f64>, DVector<f64>)> {
        self.factors.solve(&mut b);
        let mut alpha =
            DVector::from_iterator(self.columns.len(), self.columns.iter().map(|[r, _]| dot(r, &b)));
        if let Some(border) = &self.of_border {
            alpha = border.solve(&alpha)?;
        }
        for ([_, solved], alpha) in self.columns.iter().zip(&alpha) {
            b.iter_mut().zip(solved).for_each(|(x, s)| *x -= alpha * s);
        }
        b.iter().chain(&alpha).all(|x| x.is_finite()).then_some((b, alpha))
    }
}
