//! Evaluation of contact laws: by deflection or on fixed pieces.

use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::contact::piece::Piece;
use crate::scalar::Scalar;

/// The way in which an algebra evaluates contact laws: by deflection ([`ByDeflection`]) or on fixed pieces
/// ([`FixedPieces`]).
pub trait PieceChoice<S: Scalar> {
    /// Returns the force of contact `i` per unit stiffness, for the law `nonlinearity`, the deflection `x`,
    /// its `rate` and the edges `lower` and `upper`.
    fn force<N: Nonlinearity>(&self, i: usize, nonlinearity: &N, x: S, rate: S, lower: S, upper: S) -> S;
    /// Returns the same force for a law with several [switching functions](Nonlinearity::switches).
    ///
    /// Contact `i` belongs to the first switching function, the following contacts to the others. Default:
    /// [`force`](PieceChoice::force).
    fn force_of_switches<N: Nonlinearity>(
        &self,
        i: usize,
        nonlinearity: &N,
        x: S,
        rate: S,
        lower: S,
        upper: S,
    ) -> S {
        self.force(i, nonlinearity, x, rate, lower, upper)
    }
    /// Returns 1 if contact `i` touches and 0 if it stands in its gap.
    fn touch(&self, i: usize, x: S, lower: S, upper: S) -> S;
}

/// Evaluation by deflection: the deflection decides on which piece a law stands.
///
/// ```
/// use gear_dynamics::{contact::{ByDeflection, PieceChoice}, Backlash};
/// assert_eq!(ByDeflection.force(0, &Backlash::new(1.0)?, 1.5, 0.0, -1.0, 1.0), 0.5);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ByDeflection;

impl<S: Scalar> PieceChoice<S> for ByDeflection {
    #[inline(always)]
    fn force<N: Nonlinearity>(&self, _: usize, nonlinearity: &N, x: S, rate: S, lower: S, upper: S) -> S {
        nonlinearity.force(x, rate, lower, upper)
    }
    #[inline(always)]
    fn touch(&self, _: usize, x: S, lower: S, upper: S) -> S {
        (x - upper).step() + (lower - x).step()
    }
}

/// Evaluation on fixed pieces: contact `i` stands on piece `i` of the list, which continues smoothly past its
/// edges.
///
/// ```
/// use gear_dynamics::{Backlash, contact::{FixedPieces, Piece, PieceChoice}};
/// let law = FixedPieces(&[Piece::Upper]); // x - b, also in the gap
/// assert_eq!(law.force(0, &Backlash::new(1.0)?, 0.25, 0.0, -1.0, 1.0), -0.75);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct FixedPieces<'a>(pub &'a [Piece]);

impl<S: Scalar> PieceChoice<S> for FixedPieces<'_> {
    #[inline(always)]
    fn force<N: Nonlinearity>(&self, i: usize, nonlinearity: &N, x: S, rate: S, lower: S, upper: S) -> S {
        nonlinearity.force_on(self.0[i], x, rate, lower, upper)
    }
    #[inline(always)]
    fn force_of_switches<N: Nonlinearity>(
        &self,
        i: usize,
        nonlinearity: &N,
        x: S,
        rate: S,
        lower: S,
        upper: S,
    ) -> S {
        nonlinearity.force_on_all(&self.0[i..i + nonlinearity.switches()], x, rate, lower, upper)
    }
    #[inline(always)]
    fn touch(&self, i: usize, _: S, _: S, _: S) -> S {
        S::from(if self.0[i] == Piece::Gap { 0.0 } else { 1.0 })
    }
}
