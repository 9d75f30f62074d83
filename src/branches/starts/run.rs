//! Lines from a start to their ends.

use crate::branches::branch_end::BranchEnd;
use crate::branches::branch_error::BranchError;
use crate::branches::continuation::Continuation;
use crate::branches::family::Family;
use crate::branches::following::Following;
use crate::branches::line::Line;
use crate::branches::starts::start::{Resume, Start};
use crate::error::ParameterError;

impl Continuation {
    /// Follows a line from a [`Start`] to its end: over one parameter a branch of orbits, over two the
    /// boundary of a located point.
    ///
    /// # Errors
    /// [`BranchError`]: settings out of range, a setting that the start does not read, or no orbit near the
    /// start. What fails later ends the line, see [`Line::end`].
    pub fn run<const N: usize, S: Start<N>>(
        &self,
        family: &Family<'_, N>,
        start: S,
    ) -> Result<Line<S::Point>, BranchError> {
        let forward = self.begin(family, start)?.finish();
        if !self.both_ways || matches!(forward.end, BranchEnd::Closed | BranchEnd::Exhausted(_)) {
            return Ok(forward);
        }
        // What fails in the second direction does not lose the first.
        match forward.points[0].resume(&forward, -self.heading(), self, family) {
            Ok(back) => Ok(back.finish().reversed_before(forward)),
            Err(_) => Ok(forward),
        }
    }

    /// Starts a line that yields its points one by one. It can be stopped at any point; see
    /// [`resume`](Continuation::resume).
    ///
    /// # Errors
    /// As [`run`](Continuation::run).
    pub fn begin<'f, const N: usize, S: Start<N>>(
        &'f self,
        family: &'f Family<'f, N>,
        start: S,
    ) -> Result<Following<'f, S::Point>, BranchError> {
        self.check()?;
        if self.both_ways && !start.goes_both_ways() {
            let by = "a start that goes one way (Switch, Beyond)";
            return Err(ParameterError::Unread { name: "both_ways", by }.into());
        }
        start.begin(self, family)
    }

    /// Continues a line from its last point in the direction in which it was followed. The result begins with
    /// that point.
    ///
    /// # Errors
    /// As [`run`](Continuation::run); also for a line without points.
    pub fn resume<'f, const N: usize, P: Resume<N>>(
        &'f self,
        family: &'f Family<'f, N>,
        line: &Line<P>,
    ) -> Result<Following<'f, P>, BranchError> {
        self.check()?;
        let last = line.points.last().ok_or(BranchError::NoPoints)?;
        self.check_start(last.parameters()[last.parameters().len() - 1])?;
        let mut following = last.resume(line, line.heading, self, family)?;
        following.shift(last.arclength());
        Ok(following)
    }
}
