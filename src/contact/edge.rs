//! The two edges of a gap.

use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::scalar::Scalar;

/// An edge of a gap. As a number it is 0 for the lower and 1 for the upper edge: the order of every array of
/// two that belongs to the edges of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Edge {
    Lower,
    Upper,
}

impl Edge {
    pub(crate) const BOTH: [Edge; 2] = [Edge::Lower, Edge::Upper];

    /// The edges at which a piece ends: one of a flank, both of the gap.
    #[inline(always)]
    pub(crate) const fn around(piece: Piece) -> &'static [Edge] {
        match piece {
            Piece::Lower => &[Edge::Lower],
            Piece::Gap => &Edge::BOTH,
            Piece::Upper => &[Edge::Upper],
        }
    }
    /// The edge of a flank; `None` for the gap.
    #[inline]
    pub(crate) fn of(piece: Piece) -> Option<Edge> {
        match piece {
            Piece::Lower => Some(Edge::Lower),
            Piece::Gap => None,
            Piece::Upper => Some(Edge::Upper),
        }
    }
    /// The edge between a flank and the gap. Between both flanks, where the gap has no width, it is the lower
    /// one.
    #[inline]
    pub(crate) fn between(a: Piece, b: Piece) -> Edge {
        if a == Piece::Lower || b == Piece::Lower { Edge::Lower } else { Edge::Upper }
    }

    /// The flank that begins at this edge.
    #[inline]
    pub(crate) const fn flank(self) -> Piece {
        match self {
            Edge::Lower => Piece::Lower,
            Edge::Upper => Piece::Upper,
        }
    }
    /// The piece on the other side of this edge, for a `piece` that ends here.
    #[inline]
    pub(crate) const fn beyond(self, piece: Piece) -> Piece {
        match piece {
            Piece::Gap => self.flank(),
            Piece::Lower | Piece::Upper => Piece::Gap,
        }
    }

    /// Sign of the [`distance`](Edge::distance) on the flank of this edge.
    #[inline]
    pub(crate) const fn outward(self) -> f64 {
        match self {
            Edge::Lower => -1.0,
            Edge::Upper => 1.0,
        }
    }
    /// Sign of the [`distance`](Edge::distance) on a piece that ends at this edge.
    #[inline]
    pub(crate) const fn sign_on(self, piece: Piece) -> f64 {
        match piece {
            Piece::Gap => -self.outward(),
            Piece::Lower | Piece::Upper => self.outward(),
        }
    }

    /// The deflection at this edge.
    #[inline]
    pub(crate) fn position(self, c: &Contact) -> f64 {
        match self {
            Edge::Lower => c.lower,
            Edge::Upper => c.upper,
        }
    }
    /// Rate of this edge.
    #[inline]
    pub(crate) fn position_rate(self, c: &Contact) -> f64 {
        match self {
            Edge::Lower => c.lower_rate,
            Edge::Upper => c.upper_rate,
        }
    }
    /// Deflection minus this edge.
    #[inline]
    pub(crate) fn distance(self, c: &Contact) -> f64 {
        c.deflection - self.position(c)
    }
    /// Rate of the [`distance`](Edge::distance).
    #[inline]
    pub(crate) fn rate(self, c: &Contact) -> f64 {
        c.rate - self.position_rate(c)
    }
    /// Depth past this edge, on its flank positive: the [`distance`](Edge::distance) with the sign
    /// [`outward`](Edge::outward).
    #[inline(always)]
    pub(crate) fn depth<S: Scalar>(self, c: &Contact<S>) -> S {
        match self {
            Edge::Lower => c.lower - c.deflection,
            Edge::Upper => c.deflection - c.upper,
        }
    }
    /// Rate of the [`depth`](Edge::depth).
    #[inline(always)]
    pub(crate) fn depth_rate<S: Scalar>(self, c: &Contact<S>) -> S {
        match self {
            Edge::Lower => c.lower_rate - c.rate,
            Edge::Upper => c.rate - c.upper_rate,
        }
    }

    /// Whether this edge of a contact is a rigid stop. Contacts past the end of `stops` have none.
    #[inline]
    pub(crate) fn is_stop(self, stops: &[[bool; 2]], contact: usize) -> bool {
        stops.get(contact).is_some_and(|rigid| rigid[self as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::Edge;
    use crate::contact::{Contact, Piece};

    /// Seen from either side, an edge lies between the same two pieces, and the distance has the sign of the
    /// side.
    #[test]
    fn both_sides_of_an_edge() {
        for edge in Edge::BOTH {
            for piece in [Piece::Gap, edge.flank()] {
                let other = edge.beyond(piece);
                assert_eq!((edge.beyond(other), Edge::between(piece, other)), (piece, edge));
                assert!(Edge::around(piece).contains(&edge));
                let place = edge.outward() * if piece == Piece::Gap { 0.5 } else { 1.5 };
                let c = Contact { deflection: place, lower: -1.0, upper: 1.0, ..Contact::default() };
                assert_eq!((c.piece(), edge.distance(&c).signum()), (piece, edge.sign_on(piece)));
                assert_eq!(edge.depth(&c), edge.outward() * edge.distance(&c));
            }
            assert_eq!(Edge::of(edge.flank()), Some(edge));
        }
        assert_eq!((Edge::around(Piece::Upper), Edge::of(Piece::Gap)), (&[Edge::Upper][..], None));
    }
}
