//! What a contact law reads.

use crate::contact::piece::Piece;
use crate::scalar::Scalar;

/// The deflection d of a contact, its rate d' and the edges of its gap: what a contact law reads.
///
/// ```
/// use gear_dynamics::contact::{Deflection, Nonlinearity};
/// use gear_dynamics::Backlash;
/// let at = Deflection { d: 1.5, rate: 0.0, lower: -1.0, upper: 1.0 };
/// assert_eq!(Backlash::new(1.0)?.force(at), 0.5);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deflection<S = f64> {
    /// Deflection d, in the unit of the edges.
    pub d: S,
    /// Rate d' of the deflection.
    pub rate: S,
    /// Lower edge of the gap.
    pub lower: S,
    /// Upper edge of the gap.
    pub upper: S,
}

impl<S: Scalar> Deflection<S> {
    /// max(d - upper, 0) - max(lower - d, 0), computed as d minus the nearest point of the gap.
    #[inline(always)]
    pub(crate) fn outside(self) -> S {
        self.d - self.d.max(self.lower).min(self.upper)
    }

    /// [`outside`](Deflection::outside) on one piece, continued past its edges.
    #[inline(always)]
    pub(crate) fn outside_on(self, piece: Piece) -> S {
        match piece {
            Piece::Lower => self.d - self.lower,
            Piece::Gap => S::from(0.0),
            Piece::Upper => self.d - self.upper,
        }
    }

    /// 1 past an edge and 0 in the gap.
    #[inline(always)]
    pub(crate) fn touches(self) -> S {
        (self.d - self.upper).step() + (self.lower - self.d).step()
    }
}
