//! Values of the contact laws in an evaluation of the algebra: recorded, or replaced by given ones.

use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::contact::piece::Piece;
use crate::contact::piece_choice::{ByDeflection, FixedPieces, PieceChoice};
use crate::scalar::Scalar;
use std::cell::Cell;

/// Evaluation that records the value of every law: by deflection, or on fixed pieces.
#[derive(Clone, Copy)]
pub(crate) struct Recorded<'a, S> {
    pub(crate) seen: &'a [Cell<S>],
    pub(crate) pieces: Option<&'a [Piece]>,
}

impl<S: Scalar> PieceChoice<S> for Recorded<'_, S> {
    fn force<N: Nonlinearity>(&self, i: usize, nonlinearity: &N, x: S, rate: S, lower: S, upper: S) -> S {
        let force = match self.pieces {
            None => nonlinearity.force(x, rate, lower, upper),
            Some(pieces) => FixedPieces(pieces).force(i, nonlinearity, x, rate, lower, upper),
        };
        self.seen[i].set(force);
        force
    }
    fn force_of_switches<N: Nonlinearity>(
        &self,
        i: usize,
        nonlinearity: &N,
        x: S,
        rate: S,
        lower: S,
        upper: S,
    ) -> S {
        let force = match self.pieces {
            None => nonlinearity.force(x, rate, lower, upper),
            Some(pieces) => FixedPieces(pieces).force_of_switches(i, nonlinearity, x, rate, lower, upper),
        };
        self.seen[i].set(force);
        force
    }
    fn touch(&self, i: usize, x: S, lower: S, upper: S) -> S {
        match self.pieces {
            None => ByDeflection.touch(i, x, lower, upper),
            Some(pieces) => FixedPieces(pieces).touch(i, x, lower, upper),
        }
    }
}

/// Evaluation that returns given values, and records those of the laws.
pub(crate) struct Given<'a, S> {
    pub(crate) forces: &'a [S],
    pub(crate) laws: Recorded<'a, S>,
}

impl<S: Scalar> PieceChoice<S> for Given<'_, S> {
    fn force<N: Nonlinearity>(&self, i: usize, nonlinearity: &N, x: S, rate: S, lower: S, upper: S) -> S {
        self.laws.force(i, nonlinearity, x, rate, lower, upper);
        self.forces[i]
    }
    fn force_of_switches<N: Nonlinearity>(
        &self,
        i: usize,
        nonlinearity: &N,
        x: S,
        rate: S,
        lower: S,
        upper: S,
    ) -> S {
        self.laws.force_of_switches(i, nonlinearity, x, rate, lower, upper);
        self.forces[i]
    }
    fn touch(&self, i: usize, x: S, lower: S, upper: S) -> S {
        self.laws.touch(i, x, lower, upper)
    }
}
