//! The piece of a law on which a force is evaluated.

use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::contact::piece::Piece;
use crate::scalar::Scalar;

/// How contact forces are evaluated: by the law itself, or on a frozen piece of it.
pub trait PieceChoice<S: Scalar> {
    /// The force of contact `i` under `nonlinearity`, per unit stiffness.
    fn force<N: Nonlinearity>(&self, i: usize, nonlinearity: &N, x: S, rate: S, lower: S, upper: S) -> S;
    /// The same for a law of several [switches](Nonlinearity::switches), of which contact `i` is the first.
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
    /// 1 where contact `i` touches and 0 in its gap.
    fn touch(&self, i: usize, x: S, lower: S, upper: S) -> S;
}

/// The contact laws as they are.
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

/// Every contact held on a given piece, smoothly continued past its edge.
///
/// ```
/// use gear_dynamics::{Backlash, contact::{FixedPieces, Piece, PieceChoice}};
/// let law = FixedPieces(&[Piece::Upper]);
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
