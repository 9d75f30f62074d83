//! ∂a/∂q of a shape with twice the digits.

use crate::contact::{ByDeflection, FixedPieces, Piece, PieceChoice};
use crate::doubled::{Doubled, DoubledDual};
use crate::model::shapes::shape::{Drives, Shape, Size};
use nalgebra::DMatrix;

/// Writes ∂a/∂q as a sum of two matrices, the second one with what the first one has lost by rounding: by
/// deflection or on given pieces.
pub(crate) fn exact_jacobian<G: Shape>(
    shape: &G,
    pieces: Option<&[Piece]>,
    u: &[f64],
    [q, v]: [&[f64]; 2],
    out: [&mut DMatrix<f64>; 2],
) {
    match pieces {
        None => slopes(shape, &ByDeflection, u, [q, v], out),
        Some(pieces) => slopes(shape, &FixedPieces(pieces), u, [q, v], out),
    }
}

fn slopes<G: Shape, L: PieceChoice<DoubledDual>>(
    shape: &G,
    law: &L,
    u: &[f64],
    [q, v]: [&[f64]; 2],
    [high, low]: [&mut DMatrix<f64>; 2],
) {
    let Size { dof: n, waves, .. } = shape.size();
    let numbers = |x: &[f64]| -> Vec<DoubledDual> { x.iter().map(|&x| x.into()).collect() };
    let (u, mut q, v, mut a) = (numbers(u), numbers(q), numbers(v), numbers(&vec![0.0; n]));
    for j in 0..n {
        q[j].slope = Doubled::from(1.0);
        shape.accel(law, Drives::new(waves, &u), &q, &v, &mut a);
        q[j].slope = Doubled::ZERO;
        for (i, a) in a.iter().enumerate() {
            (high[(i, j)], low[(i, j)]) = (a.slope.high, a.slope.low);
        }
    }
}
