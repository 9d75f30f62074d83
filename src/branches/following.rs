//! A continuation in progress, as the user holds it.

use crate::branches::branch::Branch;
use crate::branches::points::branch_point::BranchPoint;
use crate::periodic::shooting::shooting_orbit::ShootingOrbit;

/// A continuation that yields its points one by one, from
/// [`Continuation::begin`](crate::branches::Continuation::begin).
///
/// ```
/// use gear_dynamics::{State, branches::{ByConstant, Continuation}, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.6)?;
/// let family = ByConstant::new(&pair, "speed")?;
/// let continuation = Continuation::new(0.6, 0.7);
/// let mut following = continuation.begin(&family, &[State::new(0.0, &[1.1], &[0.0])])?;
/// following.by_ref().take_while(|point| point.parameter < 0.62).for_each(drop);
/// let first = following.into_branch(); // stopped
/// let rest = continuation.resume(&family, &first)?;
/// assert_eq!(rest.last().ok_or("a point")?.parameter, 0.7);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Following<'f, O = ShootingOrbit> {
    pub(crate) tracker: Box<dyn Track<O> + 'f>,
}

/// A continuation by any method whose orbits are of type `O`.
pub(crate) trait Track<O> {
    fn next_point(&mut self) -> Option<BranchPoint<O>>;
    fn branch(&self) -> &Branch<O>;
    fn into_branch(self: Box<Self>) -> Branch<O>;
    /// Adds to the arclength of all further points.
    fn shift(&mut self, arclength: f64);
}

impl<O> Following<'_, O> {
    /// The branch so far.
    pub fn branch(&self) -> &Branch<O> {
        self.tracker.branch()
    }
    /// The branch so far. [`Continuation::resume`](crate::branches::Continuation::resume) continues it.
    pub fn into_branch(self) -> Branch<O> {
        self.tracker.into_branch()
    }
    /// Follows the branch to its end.
    pub fn finish(mut self) -> Branch<O> {
        while self.tracker.next_point().is_some() {}
        self.tracker.into_branch()
    }
}

impl<O> Iterator for Following<'_, O> {
    type Item = BranchPoint<O>;

    fn next(&mut self) -> Option<BranchPoint<O>> {
        self.tracker.next_point()
    }
}
