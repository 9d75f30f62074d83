//! What the motion of a lane is for.

use crate::ode::IntegrateError;
use crate::sweep::taylor::lane::{Lane, Motion};
use crate::sweep::taylor::meters::ChannelMeters;
use crate::sweep::taylor::pace::Pace;
use crate::sweep::taylor::view::LaneView;

/// What the motion of a lane is for: a row of a sweep, exponents or an orbit.
pub(crate) trait Task<'m> {
    /// Why a run ends without a result.
    type Error: From<IntegrateError>;
    /// Absolute tolerance of each coordinate and velocity.
    fn tolerances(&self) -> &[f64];
    /// Whether channels are measured in the next step.
    fn measures(&self) -> bool;
    /// Uses a step that has ended, and prepares the next one with [`Lane::pass`]. Returns whether the run is
    /// over.
    ///
    /// # Errors
    /// Those of the task.
    fn end<const W: usize>(&mut self, lane: &mut Lane<'m>, ended: Ended<'_, W>) -> Result<bool, Self::Error>;
}

/// A step that has ended, besides its lane.
pub(crate) struct Ended<'n, const W: usize> {
    pub(crate) view: LaneView<'n, W>,
    /// Whether it ended on a drive edge.
    pub(crate) at_edge: bool,
    pub(crate) meters: &'n mut ChannelMeters<W>,
    pub(crate) pace: &'n mut Pace<W>,
}

/// A run to make.
pub(crate) struct LaneJob<'m, T> {
    pub(crate) index: usize,
    pub(crate) motion: Motion<'m>,
    pub(crate) task: T,
}

/// Where the runs of lanes come from, and their results go to.
pub(crate) trait Queue<'m, T: Task<'m>> {
    /// The next run that shares lanes.
    fn next(&mut self) -> Option<LaneJob<'m, T>>;
    /// Takes a run that has ended or failed. Returns the next one.
    fn over(&mut self, index: usize, task: T, outcome: Result<(), T::Error>) -> Option<LaneJob<'m, T>>;
    fn is_cancelled(&self) -> bool;
}
