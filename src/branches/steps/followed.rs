//! What a stepper asks of the curve that it follows.

use crate::branches::branch_end::BranchEnd;
use crate::branches::curve::equations::CurveError;
use crate::branches::curve::point::CurvePoint;
use crate::branches::line::LinePoint;
use crate::branches::orbits::measure::Measured;
use crate::branches::orbits::orbit_method::Orbits;
use crate::branches::steps::stepper::{Node, Stepper};
use crate::error::ParameterError;
use crate::model::channel::Channel;
use crate::model::equations::Periodic;

/// A curve with the points and the ends of its line: a branch or a boundary.
pub(crate) trait Followed: Orbits + Sized {
    /// The points of the line.
    type Point: LinePoint + Clone;
    /// What a located point is.
    type What;
    /// Number of corrections up to which the next step is longer.
    const FEW: usize;

    /// The channels that are measured.
    fn channels(head: &<Self::Point as LinePoint>::Head) -> &[Channel];
    /// The model of a point.
    fn model(&self, point: &CurvePoint<Self::Solution>) -> Result<Box<dyn Periodic + '_>, ParameterError>;
    /// The columns of a point.
    fn columns(
        &self,
        point: &CurvePoint<Self::Solution>,
        measured: Measured,
        arclength: f64,
        what: Option<Self::What>,
    ) -> Result<Self::Point, CurveError>;
    /// What lies between the last point and the next one.
    fn over(
        stepper: &mut Stepper<'_, Self>,
        reached: &Node<Self::Solution>,
        step: f64,
    ) -> Result<Over<Self::Point>, CurveError>;
    /// The border of parametric instability that the last point and the next one tend to, with motions of
    /// these sizes.
    fn border(
        stepper: &Stepper<'_, Self>,
        next: &CurvePoint<Self::Solution>,
        motions: [f64; 2],
    ) -> Option<f64>;
    /// Why the line ends at a point with these figures. Default: it goes on.
    fn end_at(&self, measured: &Measured) -> Option<BranchEnd> {
        let _ = measured;
        None
    }
    /// An end near the last point that explains why a step failed. Default: none.
    fn end_beside(stepper: &mut Stepper<'_, Self>) -> Option<BranchEnd> {
        let _ = stepper;
        None
    }
}

/// What lies between two points.
pub(crate) enum Over<P> {
    /// The line ends before the next point.
    Ends(BranchEnd),
    /// Located points, and what was not located.
    Passes(Vec<P>, Vec<&'static str>),
}
