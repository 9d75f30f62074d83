//! The ways in which a contact leaves its piece, and how far it is from each.

use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::ode::edges::hermite::Distance;

/// How far a deflection may lie past its edge before it counts: this share of the gap. Less changes the force by less than
/// the stiffness times it, far below the tolerance of any step.
pub(crate) const SLACK: f64 = 1e-10;

/// One way for a contact to leave its piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Exit {
    pub(crate) contact: usize,
    pub(crate) to: Piece,
}

impl Exit {
    /// The ways out of a piece.
    #[inline]
    pub(crate) fn of(contact: usize, piece: Piece) -> [Option<Exit>; 2] {
        let exit = |to| Some(Exit { contact, to });
        match piece {
            Piece::Lower | Piece::Upper => [exit(Piece::Gap), None],
            Piece::Gap => [exit(Piece::Lower), exit(Piece::Upper)],
        }
    }

    /// Its distance, when standing on `from`.
    #[inline(always)]
    pub(crate) fn distance(self, from: Piece, c: &Contact, h: f64) -> Distance {
        // Outwards from a flank and inwards from the gap: the side of the edge, and the sign that makes the distance positive inside.
        let lower = if from == Piece::Gap { self.to == Piece::Lower } else { from == Piece::Lower };
        let (edge, edge_rate) = if lower { (c.lower, c.lower_rate) } else { (c.upper, c.upper_rate) };
        let sign = if lower == (from == Piece::Gap) { 1.0 } else { -1.0 };
        Distance { value: sign * (c.deflection - edge), rate: h * sign * (c.rate - edge_rate) }
    }
}

/// The length that slack is measured by: the gap, or the deflection where there is none.
#[inline]
pub(crate) fn scale(c: &Contact) -> f64 {
    let gap = c.upper - c.lower;
    if gap > 0.0 && gap.is_finite() { gap } else { c.deflection.abs().max(f64::MIN_POSITIVE / SLACK) }
}
