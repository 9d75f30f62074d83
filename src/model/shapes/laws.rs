//! Values of the contact laws of a machine: recorded, or replaced by given ones.

use crate::contact::{ByDeflection, Deflection, FixedPieces, Nonlinearity, Piece, PieceChoice, Place};
use crate::dual::Dual;
use crate::model::laws::Laws;
use crate::model::shapes::compiled::Compiled;
use crate::model::shapes::shape::{Drives, Shape};
use crate::scalar::Scalar;
use std::cell::Cell;

impl<G: Shape> Laws for Compiled<G> {
    fn accel_by_laws(
        &self,
        given: Option<&[f64]>,
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        a: &mut [f64],
        laws: &mut [f64],
    ) {
        let laws = SeenLaws { seen: Cell::from_mut(laws).as_slice_of_cells(), pieces };
        let of_shape = Drives::new(self.size().waves, u);
        match given {
            None => self.shape().accel(&laws, of_shape, q, v, a),
            Some(forces) => self.shape().accel(&Given { forces, laws }, of_shape, q, v, a),
        }
        self.add_inertia(u, a);
    }
    fn slopes_by_laws(
        &self,
        forces: &[Dual<4>],
        pieces: Option<&[Piece]>,
        u: &[Dual<4>],
        q: &[Dual<4>],
        v: &[Dual<4>],
        a: &mut [Dual<4>],
        laws: &mut [Dual<4>],
    ) {
        let laws = SeenLaws { seen: Cell::from_mut(laws).as_slice_of_cells(), pieces };
        self.shape().accel(&Given { forces, laws }, Drives::new(self.size().waves, u), q, v, a);
    }
}

/// Evaluation that records the value of every law: by deflection, or on fixed pieces.
#[derive(Clone, Copy)]
struct SeenLaws<'a, S> {
    seen: &'a [Cell<S>],
    pieces: Option<&'a [Piece]>,
}

impl<S: Scalar> PieceChoice<S> for SeenLaws<'_, S> {
    fn force<N: Nonlinearity>(&self, place: impl Into<Place>, law: &N, at: Deflection<S>) -> S {
        let place = place.into();
        let force = match self.pieces {
            None => law.force(at),
            Some(pieces) => FixedPieces(pieces).force(place, law, at),
        };
        self.seen[place.contact].set(force);
        force
    }
    fn touch(&self, i: usize, at: Deflection<S>) -> S {
        match self.pieces {
            None => ByDeflection.touch(i, at),
            Some(pieces) => FixedPieces(pieces).touch(i, at),
        }
    }
}

/// Evaluation that returns given values, and records those of the laws.
struct Given<'a, S> {
    forces: &'a [S],
    laws: SeenLaws<'a, S>,
}

impl<S: Scalar> PieceChoice<S> for Given<'_, S> {
    fn force<N: Nonlinearity>(&self, place: impl Into<Place>, law: &N, at: Deflection<S>) -> S {
        let place = place.into();
        self.laws.force(place, law, at);
        self.forces[place.contact]
    }
    fn touch(&self, i: usize, at: Deflection<S>) -> S {
        self.laws.touch(i, at)
    }
}
