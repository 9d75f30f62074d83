//! Enclosed parts of the motion, for those who look at its course.

use crate::certify::flow::algebra::Algebra;
use crate::contact::Piece;
use crate::interval::number::Interval;

/// Receives the enclosed parts of the motion, one after the other.
pub(crate) type Seen<'s> = dyn FnMut(&dyn Part) + 's;

/// An enclosed part of the motion.
pub(crate) trait Part {
    fn start(&self) -> Interval;
    /// The time after the start at which the part ends.
    fn until(&self) -> Interval;
    /// The piece of a contact, or both if it may be on either.
    fn pieces(&self, contact: usize) -> [Piece; 2];
    /// Enclosed polynomials of each coordinate and velocity in the time after the start.
    fn series(&self) -> Vec<Vec<Interval>>;
    /// Enclosed polynomials of some forms of another tape of the same motion, evaluated as its distances from
    /// the lower edges.
    fn series_of(&self, other: &Algebra) -> Vec<Vec<Interval>>;
}
