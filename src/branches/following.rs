//! A continuation in progress, as the user holds it.

use crate::branches::line::{Line, LinePoint};
use crate::branches::points::branch_point::BranchPoint;
use std::fmt;

/// A continuation that yields its points one by one, from
/// [`Continuation::begin`](crate::branches::Continuation::begin). A branch yields each point once the
/// next one is known, which may show bifurcations before it.
///
/// ```
/// use gear_dynamics::{State, branches::{Continuation, Family}, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.6)?;
/// let family = Family::over(&pair, ["speed"])?;
/// let continuation = Continuation::new(0.6, 0.7);
/// let mut following = continuation.begin(&family, &State::new(0.0, &[1.1], &[0.0]))?;
/// following.by_ref().take_while(|point| point.parameter < 0.62).for_each(drop);
/// let first = following.into_line(); // stopped
/// let rest = continuation.resume(&family, &first)?;
/// assert_eq!(rest.last().ok_or("a point")?.parameter, 0.7);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Following<'f, P: LinePoint = BranchPoint> {
    steps: Box<dyn Steps<P> + 'f>,
}

impl<P: LinePoint> fmt::Debug for Following<'_, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Following").finish_non_exhaustive()
    }
}

/// A line that is followed by any method.
pub(crate) trait Steps<P: LinePoint> {
    fn next_point(&mut self) -> Option<P>;
    fn line(&self) -> &Line<P>;
    fn into_line(self: Box<Self>) -> Line<P>;
    /// Adds to the arclength of all further points.
    fn shift(&mut self, arclength: f64);
}

impl<'f, P: LinePoint> Following<'f, P> {
    pub(crate) fn new(steps: impl Steps<P> + 'f) -> Self {
        Following { steps: Box::new(steps) }
    }
    /// The line so far.
    pub fn line(&self) -> &Line<P> {
        self.steps.line()
    }
    /// The line so far, with points that are computed and not yet yielded.
    /// [`Continuation::resume`](crate::branches::Continuation::resume) continues it.
    pub fn into_line(self) -> Line<P> {
        self.steps.into_line()
    }
    /// Follows the line to its end.
    pub fn finish(mut self) -> Line<P> {
        while self.next().is_some() {}
        self.steps.into_line()
    }
    pub(crate) fn shift(&mut self, arclength: f64) {
        self.steps.shift(arclength);
    }
}

impl<P: LinePoint> Iterator for Following<'_, P> {
    type Item = P;

    fn next(&mut self) -> Option<P> {
        self.steps.next_point()
    }
}
