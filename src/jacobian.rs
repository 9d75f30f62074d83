//! Jacobians by dual numbers.

use crate::dual::Dual;
use crate::model::{AsIs, Generic, Jacobian, Law, OnPieces};
use crate::piece::Piece;

/// The Jacobian of a generic model by dual numbers, exact to rounding: the one line of [`Model::jacobian`](crate::Model::jacobian).
pub fn dual_jacobian<M: Generic>(model: &M, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) -> bool {
    match pieces {
        None => slopes(model, &AsIs, u, q, v, out),
        Some(pieces) => slopes(model, &OnPieces(pieces), u, q, v, out),
    }
    true
}

/// Numbers that fit on the stack, for small models and for larger ones: their Jacobians allocate nothing.
const SMALL: usize = 32;
const LARGER: usize = 512;

/// Columns that one evaluation gives.
const COLUMNS: usize = 4;

fn slopes<M: Generic, L: Law<Dual<COLUMNS>>>(model: &M, law: &L, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) {
    let needed = u.len() + 3 * model.dof();
    let zero = Dual::from(0.0);
    if needed <= SMALL {
        slopes_in(&mut [zero; SMALL][..needed], model, law, u, q, v, out)
    } else if needed <= LARGER {
        slopes_in(&mut [zero; LARGER][..needed], model, law, u, q, v, out)
    } else {
        slopes_in(&mut vec![zero; needed], model, law, u, q, v, out)
    }
}

#[inline(always)]
fn slopes_in<M: Generic, L: Law<Dual<COLUMNS>>>(
    numbers: &mut [Dual<COLUMNS>],
    model: &M,
    law: &L,
    u: &[f64],
    q: &[f64],
    v: &[f64],
    out: &mut Jacobian,
) {
    let n = model.dof();
    for (number, &x) in numbers.iter_mut().zip(u.iter().chain(q).chain(v)) {
        *number = x.into();
    }
    let (u, rest) = numbers.split_at_mut(u.len());
    let (y, a) = rest.split_at_mut(2 * n);
    for first in (0..2 * n).step_by(COLUMNS) {
        let columns = first..(first + COLUMNS).min(2 * n);
        columns.clone().for_each(|j| y[j] = Dual::along(y[j].value, j - first));
        model.accel_on(law, u, &y[..n], &y[n..], a);
        for j in columns {
            y[j] = y[j].value.into();
            let (half, column) = if j < n { (&mut out.q, j) } else { (&mut out.v, j - n) };
            for (i, a) in a.iter().enumerate() {
                half[(i, column)] = a.slope[j - first];
            }
        }
    }
}
