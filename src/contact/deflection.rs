//! What a contact law reads.

use crate::contact::piece::Piece;
use crate::scalar::Scalar;

/// The deflection x of a contact, its rate x' and the edges of its gap: what a contact law reads.
///
/// ```
/// use gear_dynamics::contact::{Deflection, Nonlinearity};
/// use gear_dynamics::Backlash;
/// let at = Deflection { x: 1.5, rate: 0.0, lower: -1.0, upper: 1.0 };
/// assert_eq!(Backlash::new(1.0)?.force(at), 0.5);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deflection<S = f64> {
    /// Deflection x, in the unit of the edges.
    pub x: S,
    /// Rate x' of the deflection.
    pub rate: S,
    /// Lower edge of the gap.
    pub lower: S,
    /// Upper edge of the gap.
    pub upper: S,
}

impl<S: Scalar> Deflection<S> {
    /// max(x - upper, 0) - max(lower - x, 0), computed as x minus the nearest point of the gap.
    #[inline(always)]
    pub(crate) fn outside(self) -> S {
        self.x - self.x.max(self.lower).min(self.upper)
    }

    /// [`outside`](Deflection::outside) on one piece, continued past its edges.
    #[inline(always)]
    pub(crate) fn outside_on(self, piece: Piece) -> S {
        match piece {
            Piece::Lower => self.x - self.lower,
            Piece::Gap => S::from(0.0),
            Piece::Upper => self.x - self.upper,
        }
    }

    /// 1 past an edge and 0 in the gap.
    #[inline(always)]
    pub(crate) fn touches(self) -> S {
        (self.x - self.upper).step() + (self.lower - self.x).step()
    }
}
