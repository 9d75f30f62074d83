//! Starts of a continuation.

use crate::branches::branch_error::BranchError;
use crate::branches::continuation::Continuation;
use crate::branches::family::Family;
use crate::branches::following::Following;
use crate::branches::line::{Line, LinePoint};

/// What a [`Continuation`] follows in a [`Family`] of N parameters.
///
/// | parameters | start | what is followed |
/// |---|---|---|
/// | one | `&`[`State`](crate::State), or several states at increasing times within one period; `None`: the static state | the orbit of the shooting near it |
/// | | `&`[`ShootingOrbit`](crate::periodic::ShootingOrbit) | this orbit |
/// | | `&`[`FourierOrbit`](crate::periodic::FourierOrbit) | the orbit of the balance near it |
/// | | [`Switch`](crate::branches::Switch) | the branch that crosses at a located point |
/// | | [`Beyond`](crate::branches::Beyond) | the branch that comes back from infinity |
/// | two | `&`[`BranchPoint`](crate::branches::BranchPoint) | the boundary of the located point over two parameters |
///
/// ```
/// use gear_dynamics::{Shooting, State, branches::{Continuation, Family}, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.6)?;
/// let family = Family::over(&pair, ["speed"])?;
/// let guess = State::new(0.0, &[1.1], &[0.0]);
/// let orbit = Shooting::new().solve(&pair, &guess)?;
/// let range = Continuation::new(0.6, 0.65);
/// let (a, b) = (range.run(&family, &guess)?, range.run(&family, &orbit)?);
/// assert_eq!(a.points()[0].orbit.states().len(), b.points()[0].orbit.states().len());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no start of a continuation over {N} parameters",
    note = "over one parameter: None, a &State, &[State], &ShootingOrbit, &FourierOrbit, Switch or Beyond",
    note = "over two parameters: a &BranchPoint that was located"
)]
pub trait Start<const N: usize = 1> {
    /// The points of the line: [`BranchPoint`](crate::branches::BranchPoint) or
    /// [`BoundaryPoint`](crate::branches::BoundaryPoint).
    type Point: Resume<N>;

    /// Starts a line in the direction of the continuation. [`Continuation::begin`] checks the settings first.
    ///
    /// # Errors
    /// [`BranchError`]: there is no such line.
    fn begin<'f>(
        self,
        settings: &'f Continuation,
        family: &'f Family<'f, N>,
    ) -> Result<Following<'f, Self::Point>, BranchError>;

    /// Whether the line can be followed [both ways](Continuation::both_ways) from here. Default: yes.
    fn goes_both_ways(&self) -> bool {
        true
    }
}

/// A point from which a line is followed again.
pub trait Resume<const N: usize = 1>: LinePoint {
    /// Follows the line from this point of it. `heading`: sign of the first change of the parameter.
    ///
    /// # Errors
    /// [`BranchError`]: the point is none of the models.
    fn resume<'f>(
        &self,
        line: &Line<Self>,
        heading: f64,
        settings: &'f Continuation,
        family: &'f Family<'f, N>,
    ) -> Result<Following<'f, Self>, BranchError>;
}
