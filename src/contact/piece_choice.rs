//! Evaluation of contact laws: by deflection or on fixed pieces.

use crate::contact::deflection::Deflection;
use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::contact::piece::Piece;
use crate::scalar::Scalar;

/// The way in which an algebra evaluates contact laws: by deflection ([`ByDeflection`]) or on fixed pieces
/// ([`FixedPieces`]).
pub trait PieceChoice<S: Scalar> {
    /// Returns the force per unit stiffness of `law` at `at`. `place`: the contacts of the law in the model;
    /// for a law without inner kinks the index of its contact.
    fn force<N: Nonlinearity>(&self, place: impl Into<Place>, law: &N, at: Deflection<S>) -> S;
    /// Returns 1 if contact `i` touches and 0 if it stands in its gap.
    fn touch(&self, i: usize, at: Deflection<S>) -> S;
}

/// The contacts of a law in a model: the one at which the teeth touch, and those of its [inner
/// kinks](Nonlinearity::kinks), which follow one another.
///
/// ```
/// use gear_dynamics::contact::Place;
/// assert_eq!(Place::from(2), Place { contact: 2, kinks: 3 });
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Index of the contact at which the teeth touch.
    pub contact: usize,
    /// Index of the contact of the first inner kink.
    pub kinks: usize,
}

impl From<usize> for Place {
    /// A contact directly before its inner kinks, if it has any.
    #[inline(always)]
    fn from(contact: usize) -> Self {
        Place { contact, kinks: contact + 1 }
    }
}

/// Evaluation by deflection: the deflection decides on which piece a law stands.
///
/// ```
/// use gear_dynamics::{contact::{ByDeflection, Deflection, PieceChoice}, Backlash};
/// let at = Deflection { d: 1.5, rate: 0.0, lower: -1.0, upper: 1.0 };
/// assert_eq!(ByDeflection.force(0, &Backlash::new(1.0)?, at), 0.5);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ByDeflection;

impl<S: Scalar> PieceChoice<S> for ByDeflection {
    #[inline(always)]
    fn force<N: Nonlinearity>(&self, _: impl Into<Place>, law: &N, at: Deflection<S>) -> S {
        law.force(at)
    }
    #[inline(always)]
    fn touch(&self, _: usize, at: Deflection<S>) -> S {
        at.touches()
    }
}

/// Evaluation on fixed pieces: contact `i` stands on piece `i` of the list, which continues smoothly past its
/// edges.
///
/// ```
/// use gear_dynamics::{Backlash, contact::{Deflection, FixedPieces, Piece, PieceChoice}};
/// let at = Deflection { d: 0.25, rate: 0.0, lower: -1.0, upper: 1.0 };
/// let law = FixedPieces(&[Piece::Upper]); // x - b, also in the gap
/// assert_eq!(law.force(0, &Backlash::new(1.0)?, at), -0.75);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct FixedPieces<'a>(pub &'a [Piece]);

impl<S: Scalar> PieceChoice<S> for FixedPieces<'_> {
    #[inline(always)]
    fn force<N: Nonlinearity>(&self, place: impl Into<Place>, law: &N, at: Deflection<S>) -> S {
        let Place { contact, kinks } = place.into();
        let kinks = match law.kinks() {
            0 => &[],
            count => &self.0[kinks..][..count],
        };
        law.force_on(self.0[contact], kinks, at)
    }
    #[inline(always)]
    fn touch(&self, i: usize, _: Deflection<S>) -> S {
        S::from(if self.0[i] == Piece::Gap { 0.0 } else { 1.0 })
    }
}
