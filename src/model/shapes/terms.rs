//! The terms of a machine, by numbers that carry them.

use crate::contact::{ByDeflection, FixedPieces, Piece, PieceChoice};
use crate::model::shapes::compiled::Compiled;
use crate::model::shapes::shape::{Drives, Shape, Size};
use crate::model::terms::{Terms, TermsScratch};
use crate::rounded::Rounded;

impl<G: Shape> Terms for Compiled<G> {
    fn terms(
        &self,
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        sizes: &[f64],
        scratch: &mut TermsScratch,
        out: &mut [f64],
    ) {
        match pieces {
            None => terms_of(self.shape(), &ByDeflection, u, [q, v], sizes, scratch, out),
            Some(pieces) => terms_of(self.shape(), &FixedPieces(pieces), u, [q, v], sizes, scratch, out),
        }
        let acceleration = u[self.size().waves + 1];
        out.iter_mut().zip(self.shape().inertia()).for_each(|(out, by)| *out += (acceleration * by).abs());
    }
}

fn terms_of<G: Shape, L: PieceChoice<Rounded>>(
    shape: &G,
    law: &L,
    u: &[f64],
    [q, v]: [&[f64]; 2],
    sizes: &[f64],
    scratch: &mut TermsScratch,
    out: &mut [f64],
) {
    let Size { dof: n, waves, .. } = shape.size();
    let TermsScratch { u: of_u, y, a } = scratch;
    of_u.clear();
    of_u.extend(u.iter().map(|&u| Rounded::from(u)));
    y.clear();
    let sized = q.iter().chain(v).zip(sizes);
    y.extend(sized.map(|(&value, &size)| Rounded { value, terms: size.max(value.abs()) }));
    a.clear();
    a.resize(n, Rounded::from(0.0));
    shape.accel(law, Drives::new(waves, of_u), &y[..n], &y[n..], a);
    out.iter_mut().zip(&*a).for_each(|(out, a)| *out = a.terms);
}
