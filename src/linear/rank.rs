//! The rank of a Jacobian that is proven by the errors of its entries.

use crate::doubled::Doubled;
use nalgebra::DMatrix;

/// ∂a/∂q as far as it is known.
pub(crate) struct Known {
    /// ∂a/∂q is `high` + `low` with an error of each entry of `error`.
    pub(crate) high: DMatrix<f64>,
    pub(crate) low: DMatrix<f64>,
    pub(crate) error: DMatrix<f64>,
}

/// Error of a Jacobian of twice the digits, as a share of the largest entries of its row and its column. The
/// weights of a model are doubles: if they leave a motion free but for their rounding ε, its stiffness is ε²
/// of that of the springs, 5e-32.
const EXACT: f64 = 1e-28;

/// Rounding of an operation with twice the digits.
const ROUNDING: f64 = 1e-31;

impl Known {
    /// A Jacobian of twice the digits.
    pub(crate) fn exactly(high: DMatrix<f64>, low: DMatrix<f64>) -> Self {
        let (rows, columns) = units(&high);
        let floor = |i: usize, j: usize| EXACT / (rows[i] * columns[j]);
        let error = DMatrix::from_fn(high.nrows(), high.ncols(), floor);
        Known { high, low, error }
    }

    pub(crate) fn entry(&self, i: usize, j: usize) -> Doubled {
        Doubled::from(self.high[(i, j)]) + Doubled::from(self.low[(i, j)])
    }

    /// The rank that every matrix within the errors has at least.
    ///
    /// Gauss elimination with the largest pivot of rows and columns in their own units. The error of each
    /// entry is carried along, and a pivot counts if it is larger than its error: the coupling of two stiff
    /// groups by a soft spring stands in an entry of its own and remains when the groups are eliminated.
    pub(crate) fn proven_rank(&self) -> usize {
        let n = self.high.nrows();
        let (rows, columns) = units(&self.high);
        let unit = |i: usize, j: usize| Doubled::from(rows[i]) * Doubled::from(columns[j]);
        let mut a = DMatrix::from_fn(n, n, |i, j| self.entry(i, j) * unit(i, j));
        let mut e = DMatrix::from_fn(n, n, |i, j| self.error[(i, j)] * rows[i] * columns[j]);
        for p in 0..n {
            let places = (p..n).flat_map(|j| (p..n).map(move |i| (i, j)));
            let certain = places.filter(|&at| a[at].size() > e[at]);
            let Some((row, column)) = certain.max_by(|x, y| a[*x].size().total_cmp(&a[*y].size())) else {
                return p;
            };
            a.swap_rows(p, row);
            a.swap_columns(p, column);
            e.swap_rows(p, row);
            e.swap_columns(p, column);
            let (pivot, of_pivot) = (a[(p, p)], e[(p, p)]);
            let least = pivot.size() - of_pivot;
            for i in p + 1..n {
                let (left, of_left) = (a[(i, p)], e[(i, p)]);
                if left.high == 0.0 && of_left == 0.0 {
                    continue;
                }
                let factor = left / pivot;
                for j in p + 1..n {
                    let (above, of_above) = (a[(p, j)], e[(p, j)]);
                    let by = factor * above;
                    let carried = left.size() * of_above
                        + above.size() * of_left
                        + of_left * of_above
                        + by.size() * of_pivot;
                    e[(i, j)] += carried / least + ROUNDING * (a[(i, j)].size() + by.size());
                    a[(i, j)] = a[(i, j)] - by;
                }
            }
        }
        n
    }
}

/// One over the largest entry of each row, then of each column of the rows in these units.
pub(crate) fn units(a: &DMatrix<f64>) -> (Vec<f64>, Vec<f64>) {
    let n = a.nrows();
    let unit = |largest: f64| if largest > 0.0 { 1.0 / largest } else { 1.0 };
    let rows: Vec<f64> = (0..n).map(|i| unit(a.row(i).amax())).collect();
    let column = |j: usize| (0..n).fold(0.0f64, |most, i| most.max((a[(i, j)] * rows[i]).abs()));
    let columns = (0..n).map(|j| unit(column(j))).collect();
    (rows, columns)
}
