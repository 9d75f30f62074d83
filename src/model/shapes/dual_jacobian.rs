//! Jacobians by dual numbers.

use crate::contact::{ByDeflection, FixedPieces, Piece, PieceChoice};
use crate::dual::Dual;
use crate::model::jacobian::Jacobian;
use crate::model::shapes::shape::{Drives, Shape, Size};

/// Writes the Jacobian of a shape by dual numbers, exact to rounding: by deflection or on given pieces.
pub(crate) fn dual_jacobian<G: Shape>(
    shape: &G,
    pieces: Option<&[Piece]>,
    u: &[f64],
    q: &[f64],
    v: &[f64],
    out: &mut Jacobian,
) {
    match pieces {
        None => slopes(shape, &ByDeflection, u, q, v, out),
        Some(pieces) => slopes(shape, &FixedPieces(pieces), u, q, v, out),
    }
}

/// Writes Σ_k ∂a/∂u_k w_k by dual numbers, exact to rounding: by deflection or on given pieces.
pub(crate) fn slope_along<G: Shape>(
    shape: &G,
    along: &[f64],
    pieces: Option<&[Piece]>,
    u: &[f64],
    q: &[f64],
    v: &[f64],
    out: &mut [f64],
) {
    with_numbers(u.len() + 3 * shape.size().dof, |numbers: &mut [Dual]| match pieces {
        None => slope_along_in(numbers, shape, &ByDeflection, along, u, q, v, out),
        Some(pieces) => slope_along_in(numbers, shape, &FixedPieces(pieces), along, u, q, v, out),
    });
}

#[allow(clippy::too_many_arguments, reason = "the arguments of an acceleration, a direction and scratch")]
fn slope_along_in<G: Shape, L: PieceChoice<Dual>>(
    numbers: &mut [Dual],
    shape: &G,
    law: &L,
    along: &[f64],
    u: &[f64],
    q: &[f64],
    v: &[f64],
    out: &mut [f64],
) {
    let Size { dof: n, waves, .. } = shape.size();
    for (number, &x) in numbers.iter_mut().zip(u.iter().chain(q).chain(v)) {
        *number = x.into();
    }
    numbers.iter_mut().zip(along).for_each(|(number, slope)| number.slope = [*slope]);
    let (u, rest) = numbers.split_at_mut(u.len());
    let (y, a) = rest.split_at_mut(2 * n);
    shape.accel(law, Drives::new(waves, u), &y[..n], &y[n..], a);
    out.iter_mut().zip(a).for_each(|(out, a)| *out = a.slope[0]);
}

/// Calls `write` with `needed` numbers. Up to 512 stand on the stack, in an array that is not much longer: it
/// is set to zero in each call.
#[inline(always)]
fn with_numbers<const N: usize>(needed: usize, mut write: impl FnMut(&mut [Dual<N>])) {
    let zero = Dual::from(0.0);
    match needed {
        0..=32 => write(&mut [zero; 32][..needed]),
        33..=64 => write(&mut [zero; 64][..needed]),
        65..=128 => write(&mut [zero; 128][..needed]),
        129..=256 => write(&mut [zero; 256][..needed]),
        257..=512 => write(&mut [zero; 512][..needed]),
        _ => write(&mut vec![zero; needed]),
    }
}

/// Number of columns of the Jacobian from one evaluation of the algebra.
const COLUMNS: usize = 4;

fn slopes<G: Shape, L: PieceChoice<Dual<COLUMNS>>>(
    shape: &G,
    law: &L,
    u: &[f64],
    q: &[f64],
    v: &[f64],
    out: &mut Jacobian,
) {
    with_numbers(u.len() + 3 * shape.size().dof, |numbers| slopes_in(numbers, shape, law, u, q, v, out));
}

fn slopes_in<G: Shape, L: PieceChoice<Dual<COLUMNS>>>(
    numbers: &mut [Dual<COLUMNS>],
    shape: &G,
    law: &L,
    u: &[f64],
    q: &[f64],
    v: &[f64],
    out: &mut Jacobian,
) {
    let (n, waves) = (shape.size().dof, shape.size().waves);
    for (number, &x) in numbers.iter_mut().zip(u.iter().chain(q).chain(v)) {
        *number = x.into();
    }
    let (u, rest) = numbers.split_at_mut(u.len());
    let (y, a) = rest.split_at_mut(2 * n);
    for first in (0..2 * n).step_by(COLUMNS) {
        let columns = first..(first + COLUMNS).min(2 * n);
        columns.clone().for_each(|j| y[j] = Dual::along(y[j].value, j - first));
        shape.accel(law, Drives::new(waves, u), &y[..n], &y[n..], a);
        for j in columns {
            y[j] = y[j].value.into();
            let (half, column) = if j < n { (&mut out.q, j) } else { (&mut out.v, j - n) };
            for (i, a) in a.iter().enumerate() {
                half[(i, column)] = a.slope[j - first];
            }
        }
    }
}
