//! The piece of a contact law on which a contact stands.

/// The piece of a backlash law on which a contact stands.
///
/// ```
/// use gear_dynamics::contact::{Contact, Piece};
/// let contact = Contact { deflection: -3.0, lower: -1.0, upper: 1.0, ..Contact::default() };
/// assert_eq!(contact.piece(), Piece::Lower);
/// assert_eq!(Piece::Lower as usize, 0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Piece {
    /// Deflection below the lower edge: that flank carries.
    Lower,
    /// Between the edges: the teeth are apart.
    Gap,
    /// Deflection above the upper edge.
    Upper,
}
