//! Pieces of a contact law.

/// A smooth piece of a contact law: lower flank, gap or upper flank. A contact stands on one piece at a time.
///
/// ```
/// use gear_dynamics::contact::{Contact, Piece};
/// let contact = Contact { deflection: -3.0, lower: -1.0, upper: 1.0, ..Contact::default() };
/// assert_eq!(contact.piece(), Piece::Lower);
/// assert_eq!(Piece::Lower as usize, 0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Piece {
    /// Lower flank: the deflection is below the lower edge.
    Lower,
    /// Gap: the deflection is between the edges, and the teeth do not touch.
    Gap,
    /// Upper flank: the deflection is above the upper edge.
    Upper,
}

impl Piece {
    /// Sign on this piece of a distance that is positive in the gap.
    #[inline(always)]
    pub(crate) const fn gap_sign(self) -> f64 {
        match self {
            Piece::Gap => 1.0,
            Piece::Lower | Piece::Upper => -1.0,
        }
    }
}

/// Σ piece_k 3^k over `count` contacts from `contact` on: the number of a combination of pieces.
pub(crate) fn alternative(pieces: &[Piece], contact: usize, count: usize) -> usize {
    pieces[contact..][..count].iter().rev().fold(0, |number, piece| 3 * number + *piece as usize)
}

/// Writes the combination of pieces with this number.
pub(crate) fn set_alternative(mut number: usize, pieces: &mut [Piece]) {
    for piece in pieces {
        *piece = [Piece::Lower, Piece::Gap, Piece::Upper][number % 3];
        number /= 3;
    }
}
