//! The boundary of a bifurcation or an onset in the plane of two parameters.

use crate::branches::line::{Line, LinePoint};
use crate::branches::points::kind::SpecialPoint;
use crate::error::{ParameterError, check};
use crate::export::ResultTable;
use crate::model::Channel;
use crate::periodic::{Multipliers, ShootingOrbit};
use std::fmt;

/// One point of a [`BoundaryLine`].
///
/// ```
/// use gear_dynamics::branches::Turn;
/// assert_eq!(Turn::Cusp.to_string(), "cusp");
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct BoundaryPoint {
    /// The parameters p and λ.
    pub parameters: [f64; 2],
    /// Distance along the boundary from its start `[1]`.
    pub arclength: f64,
    /// What the point is, if the line turns there.
    pub turn: Option<Turn>,
    /// Floquet multipliers; along the grazing of a rigid stop those of the model without it.
    pub multipliers: Multipliers,
    /// The orbit.
    pub orbit: ShootingOrbit,
}

/// A turning point of a boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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

/// The curve p(λ) along which a located point of a branch moves when a second parameter λ changes: what a
/// [`Continuation`](crate::branches::Continuation) follows in a [`Family`](crate::branches::Family) of two
/// parameters.
///
/// ```
/// use gear_dynamics::branches::{Continuation, Family, PointKind};
/// use gear_dynamics::{State, trains::SpurPair};
/// // Constant stiffness and an inertia force: teeth separate where A W² = F √((1 - W²)² + (2 ζ W)²).
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[], &[0.05])?.parts()?.build("driver", 0.7)?;
/// let family = Family::over(&pair, ["speed"])?;
/// let branch = Continuation::new(0.7, 0.85).run(&family, &State::new(0.0, &[1.1], &[0.0]))?;
/// let plane = Family::over(&pair, ["speed", "mesh damping"])?;
/// let line = Continuation::new(0.1, 0.12).run(&plane, branch.of_kind(PointKind::Grazing)[0])?;
/// let [w, c] = line.points().last().ok_or("a point")?.parameters;
/// assert!((0.05 * w * w - 0.1 * ((1.0 - w * w).powi(2) + (c * w).powi(2)).sqrt()).abs() < 1e-10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type BoundaryLine = Line<BoundaryPoint>;

/// What is common to the points of a boundary.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BoundaryHead {
    pub(crate) parameters: [Channel; 2],
    /// What happens on the boundary.
    pub(crate) what: SpecialPoint,
    /// Bounds of p.
    pub(crate) across: [f64; 2],
}

impl LinePoint for BoundaryPoint {
    type Head = BoundaryHead;

    fn parameters(&self) -> &[f64] {
        &self.parameters
    }
    fn arclength(&self) -> f64 {
        self.arclength
    }
    fn set_arclength(&mut self, arclength: f64) {
        self.arclength = arclength;
    }
    fn check_head(head: &BoundaryHead) -> Result<(), ParameterError> {
        let [low, high] = head.across;
        check::between("first parameter of the boundary", low, [low, high])?;
        head.what.check(usize::MAX)
    }
    fn check(&self, _: &BoundaryHead, first: &Self) -> Result<(), ParameterError> {
        let [own, of_first] = [self, first].map(|point| point.multipliers.values().len());
        check::length("multipliers of a point", own, of_first)?;
        self.orbit.multipliers().check_same(&self.multipliers)
    }
    fn summarise(line: &BoundaryLine, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} points of a {}", line.points.len(), line.head.what)?;
        for (k, parameter) in line.parameters().iter().enumerate() {
            let [low, high] = line.range(k);
            writeln!(f, "  {parameter} = {low} .. {high}")?;
        }
        for point in line.turns() {
            let ([p, other], turn) =
                (point.parameters, point.turn.map_or(String::new(), |turn| turn.to_string()));
            writeln!(f, "  {p:>18.12} {other:>18.12}  {turn}")?;
        }
        Ok(())
    }
}

impl BoundaryLine {
    /// Names and units of p and λ.
    pub fn parameters(&self) -> &[Channel; 2] {
        &self.head.parameters
    }
    /// What happens on the boundary.
    pub fn what(&self) -> &SpecialPoint {
        &self.head.what
    }
    /// The turning points.
    pub fn turns(&self) -> impl Iterator<Item = &BoundaryPoint> {
        self.points.iter().filter(|point| point.turn.is_some())
    }

    /// One row per point: p, λ, `arclength`, `turn` (0 none, 1 extremum of λ, 2 cusp) and `largest
    /// multiplier` |μ|.
    ///
    /// # Errors
    /// [`ParameterError::Twice`] if both parameters have the same name.
    pub fn table(&self) -> Result<ResultTable, ParameterError> {
        let mut columns = self.head.parameters.to_vec();
        columns.extend(["arclength", "turn", "largest multiplier"].map(|name| Channel::new(name, "1")));
        let mut table = ResultTable::new(columns)?;
        for point in &self.points {
            let ([p, other], turn) = (
                point.parameters,
                match point.turn {
                    None => 0.0,
                    Some(Turn::Extremum) => 1.0,
                    Some(Turn::Cusp) => 2.0,
                },
            );
            table.push(&[p, other, point.arclength, turn, point.multipliers.largest()])?;
        }
        Ok(table)
    }
}
