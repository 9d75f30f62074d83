//! The boundary of a bifurcation or an onset in the plane of two parameters.

use crate::branches::branch::BranchEnd;
use crate::branches::points::kind::PointKind;
use crate::model::equations::Channel;
use crate::periodic::multipliers::Multipliers;
use crate::periodic::shooting::shooting_orbit::ShootingOrbit;
use std::fmt;

/// One point of a [`BoundaryLine`].
///
/// ```
/// use gear_dynamics::branches::Turn;
/// assert_eq!(Turn::Cusp.to_string(), "cusp");
/// ```
#[derive(Clone, Debug)]
pub struct BoundaryPoint {
    /// The parameters p and λ.
    pub parameters: [f64; 2],
    /// What the point is, if the line turns there.
    pub turn: Option<Turn>,
    /// Floquet multipliers.
    pub multipliers: Multipliers,
    /// The orbit.
    pub orbit: ShootingOrbit,
}

/// A turning point of a boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Turn {
    /// λ has an extremum along the boundary.
    Extremum,
    /// Both parameters turn back: two folds meet.
    Cusp,
}

impl fmt::Display for Turn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Turn::Extremum => "extremum",
            Turn::Cusp => "cusp",
        })
    }
}

/// The curve p(λ) along which a located point of a branch moves when a second parameter λ changes, from
/// [`Continuation::boundary`](crate::branches::Continuation::boundary).
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, branches::{ByConstant, ByConstants, Continuation, PointKind}};
/// let pair = NfgPair::new(&NfgParams { speed: 135.0, ..NfgParams::table1() })?;
/// let family = ByConstant::new(&pair, "speed")?;
/// let branch = Continuation::new(135.0, 137.0).run(&family, &[pair.static_start()?])?;
/// assert!(branch.of_kind("grazing").is_empty()); // teeth stay in contact there
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct BoundaryLine {
    pub(crate) parameters: [Channel; 2],
    pub(crate) kind: PointKind,
    pub(crate) points: Vec<BoundaryPoint>,
    pub(crate) end: BranchEnd,
}

impl BoundaryLine {
    /// Names and units of p and λ.
    pub fn parameters(&self) -> &[Channel; 2] {
        &self.parameters
    }
    /// What happens on the boundary.
    pub fn kind(&self) -> &PointKind {
        &self.kind
    }
    /// The points, in order.
    pub fn points(&self) -> &[BoundaryPoint] {
        &self.points
    }
    /// Why the boundary ends.
    pub fn end(&self) -> &BranchEnd {
        &self.end
    }
    /// The turning points.
    pub fn turns(&self) -> impl Iterator<Item = (Turn, &BoundaryPoint)> {
        self.points.iter().filter_map(|point| point.turn.map(|turn| (turn, point)))
    }
    pub(crate) fn reversed_before(mut self, forward: BoundaryLine) -> Self {
        self.points.reverse();
        self.points.extend(forward.points.into_iter().skip(1));
        BoundaryLine { end: forward.end, ..self }
    }
}
