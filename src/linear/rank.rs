//! Units in which a Jacobian is balanced, and its rank that is proven by the errors of its entries.

use nalgebra::DMatrix;

/// Rounding of a quotient, a product and a difference, as a share of the product and of the number from which
/// it is taken.
const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// The rank that every matrix has at least whose entries differ from those of `a` by no more than `error`.
///
/// Gauss elimination with the largest pivot of rows and columns in their own units. The error of each entry
/// is carried along, and a pivot counts if it is larger than its error: the coupling of two stiff groups by a
/// soft spring stands in an entry of its own and remains when the groups are eliminated.
pub(crate) fn proven_rank(a: &DMatrix<f64>, error: &DMatrix<f64>) -> usize {
    let n = a.nrows();
    let (rows, columns) = units(a);
    let in_units = |b: &DMatrix<f64>| DMatrix::from_fn(n, n, |i, j| b[(i, j)] * rows[i] * columns[j]);
    let (mut a, mut e) = (in_units(a), in_units(error));
    e.zip_apply(&a, |e, a| *e += ROUNDING * a.abs());
    for p in 0..n {
        let places = (p..n).flat_map(|j| (p..n).map(move |i| (i, j)));
        let certain = places.filter(|&at| a[at].abs() > e[at]);
        let Some((row, column)) = certain.max_by(|x, y| a[*x].abs().total_cmp(&a[*y].abs())) else {
            return p;
        };
        for matrix in [&mut a, &mut e] {
            matrix.swap_rows(p, row);
            matrix.swap_columns(p, column);
        }
        let (pivot, of_pivot) = (a[(p, p)], e[(p, p)]);
        let least = pivot.abs() - of_pivot;
        for i in p + 1..n {
            let (left, of_left) = (a[(i, p)], e[(i, p)]);
            if left == 0.0 && of_left == 0.0 {
                continue;
            }
            for j in p + 1..n {
                let (above, of_above) = (a[(p, j)], e[(p, j)]);
                let by = left / pivot * above;
                let carried =
                    left.abs() * of_above + (above.abs() + of_above) * of_left + by.abs() * of_pivot;
                e[(i, j)] += carried / least + ROUNDING * (a[(i, j)].abs() + by.abs());
                a[(i, j)] -= by;
            }
        }
    }
    n
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
