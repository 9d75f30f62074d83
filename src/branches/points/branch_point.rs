//! The columns and the orbit of one point of a branch.

use crate::analysis::contacts::rattle::RattleState;
use crate::analysis::statistics::Summary;
use crate::branches::points::kind::PointKind;
use crate::periodic::multipliers::{Multipliers, Stability};
use crate::periodic::shooting::shooting_orbit::ShootingOrbit;

/// One point of a [`Branch`](crate::branches::Branch). `O`: the orbit,
/// [`ShootingOrbit`] or [`FourierOrbit`](crate::periodic::FourierOrbit).
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, RattleState, branches::{ByConstant, Continuation}};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let family = ByConstant::new(&pair, "speed")?;
/// let branch = Continuation::new(100.0, 101.0).run(&family, &[pair.static_start()?])?;
/// let point = branch.points().last().ok_or("a point")?;
/// assert_eq!((point.parameter, point.rattle[0]), (101.0, RattleState::None));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
    pub kind: Option<PointKind>,
    /// Floquet multipliers with their error.
    pub multipliers: Multipliers,
    /// The orbit, from which [`Shooting::again`](crate::Shooting::again) and other continuations start.
    pub orbit: O,
}

impl<O> BranchPoint<O> {
    /// Stability of the orbit. At a located bifurcation it is undecided.
    pub fn stability(&self) -> Stability {
        self.multipliers.stability()
    }
    /// Peak-to-peak value of the first measured channel; NaN if none is measured.
    pub fn peak_to_peak(&self) -> f64 {
        self.summaries.first().map_or(f64::NAN, Summary::peak_to_peak)
    }
}
