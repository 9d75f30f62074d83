//! The exits of a contact from its piece, and its distance from each of them.

use crate::contact::edge::Edge;
use crate::contact::{Contact, Piece};
use crate::numeric::search::extremes::larger;
use crate::numeric::search::hermite::Distance;
use crate::ode::step::Crossing;

/// Slack: the distance past an edge up to which a contact still counts as on its piece, as a share of the gap
/// `[1]`. It changes the force by less than the stiffness times the slack, far below the tolerance of any
/// step.
pub(crate) const SLACK: f64 = 1e-10;

/// An exit: contact `contact` leaves its piece at the edge `edge`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Exit {
    pub(crate) contact: usize,
    pub(crate) edge: Edge,
}

/// A share θ of the step in [0, 1].
#[derive(Clone, Copy)]
pub(crate) struct Share(pub(crate) f64);

/// A time after the start of the step.
#[derive(Clone, Copy)]
pub(crate) struct Elapsed(pub(crate) f64);

/// The first exit of a contact from its piece in a step. `At`: [`Share`] or [`Elapsed`].
#[derive(Clone, Copy)]
pub(crate) enum Found<At> {
    /// No contact leaves its piece.
    Nothing,
    /// The contact leaves its piece inside the step or at its end.
    At(At, Exit),
    /// The contact leaves its piece at the start of the step.
    AtOnce(Exit),
}

impl Exit {
    /// The exit at a crossing.
    #[inline]
    pub(crate) fn of(crossing: &Crossing) -> Exit {
        Exit { contact: crossing.contact, edge: Edge::between(crossing.from, crossing.to) }
    }
    /// The crossing at this exit from the piece `from`.
    #[inline]
    pub(crate) fn crossing(self, from: Piece, rebounds: bool) -> Crossing {
        Crossing { contact: self.contact, from, to: self.edge.beyond(from), rebounds }
    }

    /// Distance from the edge of this exit for a contact on the piece `from`, positive on that piece. With
    /// the length `h` of a step, its rate is per unit of θ; with `h` = 1, per unit of time.
    #[inline(always)]
    pub(crate) fn distance(self, from: Piece, c: &Contact, h: f64) -> Distance {
        let [distance] = distances(self.edge, from, [c], h);
        distance
    }
}

/// The distances of one contact at several instants from an edge of its piece; see [`Exit::distance`].
#[inline(always)]
pub(crate) fn distances<const K: usize>(
    edge: Edge,
    piece: Piece,
    contacts: [&Contact; K],
    h: f64,
) -> [Distance; K] {
    let sign = edge.sign_on(piece);
    let scale = h * sign;
    let from = |deflection: f64, rate: f64| Distance { value: sign * deflection, rate: scale * rate };
    // One branch for all instants instead of a selection for each.
    match edge {
        Edge::Lower => contacts.map(|c| from(c.deflection - c.lower, c.rate - c.lower_rate)),
        Edge::Upper => contacts.map(|c| from(c.deflection - c.upper, c.rate - c.upper_rate)),
    }
}

/// The longest way of a contact from an edge in one step times this number replaces a gap that is wider
/// `[1]`: a motion near one edge of a wide gap does not know of the other edge.
pub(crate) const WIDE: f64 = 1e4;

/// Whether the gap of a contact with this [`scale`] is wide beside its way from an edge in one step.
#[inline(always)]
pub(crate) fn is_wide(scale: f64, way: f64) -> bool {
    WIDE * way < scale
}

/// A gap of this width and more counts as infinite. The compiler turns a comparison with infinity into ten
/// instructions.
const ENDLESS: f64 = 1e300;

/// Length to which the slack is relative: the width of the gap or, if that is zero or infinite, |deflection|.
/// The lower limit of |deflection| keeps the slack, a share of it, above the smallest normal number.
#[inline(always)]
pub(crate) fn scale(c: &Contact) -> f64 {
    let (gap, size) = (c.upper - c.lower, larger(c.deflection.abs(), f64::MIN_POSITIVE / SLACK));
    if gap > 0.0 && gap < ENDLESS { gap } else { size }
}

/// At the start of a run a gap this many times wider than the deflection and than the edge near it is wide
/// `[1]`.
const FAR_EDGE: f64 = 10.0;

/// The way of a contact from an edge before its first step: 0, or a small share of its deflection and of the
/// edge near it in a gap that is wide beside both. A start on a flank of it is not in the gap.
pub(crate) fn first_way(c: &Contact) -> f64 {
    let [lower, upper] = Edge::BOTH.map(|edge| edge.depth(c).abs());
    let edge = if lower < upper { c.lower } else { c.upper };
    let size = larger(c.deflection.abs(), edge.abs());
    if FAR_EDGE * size < scale(c) { size / WIDE } else { 0.0 }
}
