//! Enclosed parts of the motion, for those who look at its course.

use crate::certify::flow::algebra::Algebra;
use crate::certify::flow::stretch::Stretch;
use crate::certify::flow::window::Window;
use crate::contact::Piece;
use crate::interval::number::Interval;

/// Receives the enclosed parts of the motion, one after the other.
pub(crate) type Seen<'s> = dyn FnMut(Part<'_, '_, '_>) + 's;

/// An enclosed part of the motion.
#[derive(Clone, Copy)]
pub(crate) enum Part<'s, 'f, 'm> {
    /// A stretch up to a time after its start.
    Stretch(&'s Stretch<'f, 'm>, Interval),
    Window(&'s Window<'f, 'm>),
}

impl Part<'_, '_, '_> {
    pub(crate) fn start(&self) -> Interval {
        match self {
            Part::Stretch(stretch, _) => stretch.start(),
            Part::Window(window) => window.time,
        }
    }
    /// The time after the start at which the part ends.
    pub(crate) fn until(&self) -> Interval {
        match self {
            Part::Stretch(_, until) => *until,
            Part::Window(window) => window.width,
        }
    }
    /// The piece of a contact, or both in a window.
    pub(crate) fn pieces(&self, contact: usize) -> [Piece; 2] {
        match self {
            Part::Stretch(stretch, _) => [stretch.pieces[contact]; 2],
            Part::Window(window) => window.on.pieces(contact),
        }
    }
    /// Enclosed polynomials of each coordinate and velocity in the time after the start.
    pub(crate) fn series(&self) -> Vec<Vec<Interval>> {
        match self {
            Part::Stretch(stretch, _) => stretch.series(),
            Part::Window(window) => window.during().into_iter().map(|x| vec![x]).collect(),
        }
    }
    /// Enclosed polynomials of some forms of another tape of the same motion, evaluated as its distances from
    /// the lower edges.
    pub(crate) fn series_of(&self, other: &Algebra) -> Vec<Vec<Interval>> {
        match self {
            Part::Stretch(stretch, _) => stretch.series_of(other),
            Part::Window(window) => window.values_of(other).into_iter().map(|x| vec![x]).collect(),
        }
    }
}
