//! The columns and the orbit of one point of a branch.

use crate::analysis::{RattleState, Summary};
use crate::branches::points::kind::{PointKind, SpecialPoint};
use crate::periodic::{Multipliers, ShootingOrbit, Stability};

/// One point of a [`Branch`](crate::branches::Branch). `O`: the orbit,
/// [`ShootingOrbit`] or [`FourierOrbit`](crate::periodic::FourierOrbit).
///
/// ```
/// use gear_dynamics::{RattleState, State, branches::{Continuation, Family}, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.6)?;
/// let family = Family::over(&pair, ["speed"])?;
/// let branch = Continuation::new(0.6, 0.65).run(&family, &State::new(0.0, &[1.1], &[0.0]))?;
/// let point = branch.points().last().ok_or("a point")?;
/// assert_eq!((point.parameter, point.rattle[0]), (0.65, RattleState::None));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct BranchPoint<O = ShootingOrbit> {
    /// Value of the parameter.
    pub parameter: f64,
    /// Distance along the branch from its start `[1]`.
    pub arclength: f64,
    /// Mean, RMS and extremes of the measured channels over one period of the orbit.
    pub summaries: Vec<Summary>,
    /// Rattle state of each contact.
    pub rattle: Vec<RattleState>,
    /// For each contact the number of crossings of its lower and of its upper edge in one period of the
    /// orbit: its contact sequence.
    pub crossings: Vec<[u32; 2]>,
    /// What the point is, if it was located.
    pub located: Option<SpecialPoint>,
    /// Floquet multipliers with their error.
    pub multipliers: Multipliers,
    /// The orbit, from which [`Shooting::solve_from`](crate::Shooting::solve_from) and other continuations
    /// start.
    pub orbit: O,
}

impl<O> BranchPoint<O> {
    /// The kind of a located point.
    pub fn kind(&self) -> Option<PointKind> {
        self.located.as_ref().map(SpecialPoint::kind)
    }
    /// Stability of the orbit. At a located bifurcation it is undecided.
    pub fn stability(&self) -> Stability {
        self.multipliers.stability()
    }
    /// Peak-to-peak value of the first measured channel; NaN if none is measured.
    pub fn peak_to_peak(&self) -> f64 {
        self.summaries.first().map_or(f64::NAN, Summary::peak_to_peak)
    }
}
