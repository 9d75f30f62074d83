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
