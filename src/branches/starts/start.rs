//! Starts of a continuation.

use crate::branches::branch_error::BranchError;
use crate::branches::continuation::Continuation;
use crate::branches::following::Following;
use crate::branches::line::{Line, LinePoint};

/// What a [`Continuation`] follows in models of type `F`.
///
/// | models | start | what is followed |
/// |---|---|---|
/// | [`Family`](crate::branches::Family) | [`State`](crate::State); `&[State]` at increasing times within one period; `&[]`, the static state | the orbit of the shooting near it |
/// | | `&`[`ShootingOrbit`](crate::periodic::ShootingOrbit) | this orbit |
/// | | `&`[`FourierOrbit`](crate::periodic::FourierOrbit) | the orbit of the balance near it |
/// | | [`Switch`](crate::branches::Switch) | the branch that crosses at a located point |
/// | | [`Beyond`](crate::branches::Beyond) | the branch that comes back from infinity |
/// | [`Plane`](crate::branches::Plane) | `&`[`BranchPoint`](crate::branches::BranchPoint) | the boundary of the located point over two parameters |
///
/// ```
/// use gear_dynamics::{Shooting, State, branches::{ByConstant, Continuation}, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.6)?;
/// let family = ByConstant::new(&pair, "speed")?;
/// let guess = State::new(0.0, &[1.1], &[0.0]);
/// let orbit = Shooting::new().solve(&pair, &[guess.clone()])?;
/// let range = Continuation::new(0.6, 0.65);
/// let (a, b) = (range.run(&family, guess)?, range.run(&family, &orbit)?);
/// assert_eq!(a.points()[0].orbit.states().len(), b.points()[0].orbit.states().len());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no start of a continuation in `{F}`",
    note = "in a family: a State, &[State], &ShootingOrbit, &FourierOrbit, Switch or Beyond",
    note = "in a plane: a &BranchPoint that was located"
)]
pub trait Start<F> {
    /// The points of the line: [`BranchPoint`](crate::branches::BranchPoint) or
    /// [`BoundaryPoint`](crate::branches::BoundaryPoint).
    type Point: Resume<F>;

    /// Starts a line in the direction of the continuation. [`Continuation::begin`] checks the settings first.
    ///
    /// # Errors
    /// [`BranchError`]: there is no such line.
    fn begin<'f>(
        self,
        settings: &'f Continuation,
        family: &'f F,
    ) -> Result<Following<'f, Self::Point>, BranchError>;

    /// Whether [`Continuation::both_ways`] applies. Default: yes.
    fn goes_both_ways(&self) -> bool {
        true
    }
}

/// A point from which a line is followed again.
pub trait Resume<F>: LinePoint {
    /// Follows the line from this point of it. `heading`: sign of the first change of the parameter.
    ///
    /// # Errors
    /// [`BranchError`]: the point is none of the models.
    fn resume<'f>(
        &self,
        line: &Line<Self>,
        heading: f64,
        settings: &'f Continuation,
        family: &'f F,
    ) -> Result<Following<'f, Self>, BranchError>;
}
