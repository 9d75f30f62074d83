//! What a leg is: the motion from one node to the next, and what it makes of a box.

use crate::certify::square::Square;
use crate::contact::Piece;
use crate::interval::number::Interval;

/// A crossing on a leg.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct LegCrossing {
    pub(crate) contact: usize,
    /// The piece that the contact enters; at a rigid stop the flank of the stop.
    pub(crate) to: Piece,
    pub(crate) rebounds: bool,
    /// Approximate time.
    pub(crate) near: f64,
}

/// The motion from one node to the next: the times of both, the pieces of the contacts, the crossings.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Leg {
    pub(crate) start: Interval,
    pub(crate) end: Interval,
    /// Pieces of all contacts at the start.
    pub(crate) pieces: Vec<Piece>,
    /// No crossing, one, or several that are not ordered.
    pub(crate) crossings: Vec<LegCrossing>,
}

impl Leg {
    /// A time between the nodes, wherever in their intervals these are.
    pub(crate) fn inside(&self) -> f64 {
        0.5 * (self.start.high() + self.end.low())
    }
    /// Pieces of all contacts at the end.
    pub(crate) fn pieces_after(&self) -> Vec<Piece> {
        let mut pieces = self.pieces.clone();
        self.crossings
            .iter()
            .filter(|crossing| !crossing.rebounds)
            .for_each(|crossing| pieces[crossing.contact] = crossing.to);
        pieces
    }
}

/// What a leg makes of a box.
pub(crate) struct Image {
    /// The image of the middle of the box.
    pub(crate) middle: Vec<Interval>,
    /// The derivative over the box.
    pub(crate) slope: Square,
    /// The time of the crossings, over the box.
    pub(crate) crossing: Option<Interval>,
}
