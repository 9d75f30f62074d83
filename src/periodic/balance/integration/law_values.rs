//! Values of the contact laws in an evaluation of the algebra: recorded, or replaced by given ones.

use crate::contact::{ByDeflection, Deflection, FixedPieces, Nonlinearity, Piece, PieceChoice, Place};
use crate::scalar::Scalar;
use std::cell::Cell;

/// Evaluation that records the value of every law: by deflection, or on fixed pieces.
#[derive(Clone, Copy)]
pub(crate) struct Recorded<'a, S> {
    pub(crate) seen: &'a [Cell<S>],
    pub(crate) pieces: Option<&'a [Piece]>,
}

impl<S: Scalar> PieceChoice<S> for Recorded<'_, S> {
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
pub(crate) struct Given<'a, S> {
    pub(crate) forces: &'a [S],
    pub(crate) laws: Recorded<'a, S>,
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
