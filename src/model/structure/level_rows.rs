//! Rows of Jacobians, each divided by its largest entry.

use crate::contact::Piece;
use crate::model::equations::Model;
use crate::model::structure::slopes::offered;
use nalgebra::DMatrix;

/// Divides each row by its largest entry: small inertias make rows large, and a soft spring of a large
/// inertia resists as a stiff one.
pub(super) fn level(rows: &mut DMatrix<f64>) {
    let mut largest = vec![0.0f64; rows.nrows()];
    for column in rows.column_iter() {
        largest.iter_mut().zip(column).for_each(|(largest, x)| *largest = largest.max(x.abs()));
    }
    for mut column in rows.column_iter_mut() {
        let filled = column.iter_mut().zip(&largest).filter(|(x, _)| **x != 0.0);
        filled.for_each(|(x, largest)| *x /= largest);
    }
}

/// Row, column and value of the entries of some rows.
pub(super) type Sparse = Vec<(usize, usize, f64)>;

/// The entries of rows that are not 0.
pub(super) fn sparse(rows: &DMatrix<f64>) -> Sparse {
    let columns = rows.column_iter().enumerate();
    let entries = columns.flat_map(|(j, column)| {
        let entries = column.iter().enumerate().map(move |(i, x)| (i, j, *x)).collect::<Vec<_>>();
        entries.into_iter().filter(|(.., x)| *x != 0.0)
    });
    entries.collect()
}

/// The rows of ∂a/∂q (`velocities` false) and of ∂a/∂v (true) on given pieces, each divided by its largest
/// entry. `None`: the model does not know which of its entries are 0.
pub(super) fn sparse_rows(
    model: &dyn Model,
    pieces: &[Piece],
    velocities: &[bool],
    [u, q, v]: [&[f64]; 3],
) -> Option<Vec<Sparse>> {
    let n = q.len();
    let (mut rows, mut largest) = ([Vec::new(), Vec::new()], [vec![0.0f64; n], vec![0.0f64; n]]);
    let mut add = |i: usize, j: usize, x: f64| {
        let half = usize::from(j >= n);
        if x.is_finite() {
            largest[half][i] = largest[half][i].max(x.abs());
            rows[half].push((i, j - half * n, x));
        }
    };
    let known = model.offers().expansion?.entries(offered(model, Some(pieces)), u, q, v, &mut add);
    for (rows, largest) in rows.iter_mut().zip(&largest) {
        rows.retain(|(.., x)| *x != 0.0);
        rows.iter_mut().for_each(|(i, _, x)| *x /= largest[*i]);
    }
    known.then(|| velocities.iter().map(|&half| std::mem::take(&mut rows[usize::from(half)])).collect())
}
