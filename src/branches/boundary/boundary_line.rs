//! The boundary of a bifurcation or an onset in the plane of two parameters.

use crate::branches::branch::{BranchError, BranchNote, reversed};
use crate::branches::branch_end::BranchEnd;
use crate::branches::points::kind::PointKind;
use crate::error::ParameterError;
use crate::export::table::ResultTable;
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
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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

/// The curve p(λ) along which a located point of a branch moves when a second parameter λ changes, from
/// [`Continuation::boundary`](crate::branches::Continuation::boundary).
///
/// ```
/// use gear_dynamics::{State, branches::{ByConstant, ByConstants, Continuation}, trains::SpurPair};
/// // Constant stiffness and an inertia force: teeth separate where A W² = F √((1 - W²)² + (2 ζ W)²).
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[], &[0.05])?.parts()?.build("driver", 0.7)?;
/// let family = ByConstant::new(&pair, "speed")?;
/// let branch = Continuation::new(0.7, 0.85).run(&family, &[State::new(0.0, &[1.1], &[0.0])])?;
/// let plane = ByConstants::new(&pair, ["speed", "mesh damping"])?;
/// let line = Continuation::new(0.1, 0.12).boundary(&plane, branch.of_kind("grazing")[0])?;
/// let [w, c] = line.points().last().ok_or("a point")?.parameters;
/// assert!((0.05 * w * w - 0.1 * ((1.0 - w * w).powi(2) + (c * w).powi(2)).sqrt()).abs() < 1e-10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BoundaryLine {
    pub(crate) parameters: [Channel; 2],
    pub(crate) kind: PointKind,
    pub(crate) points: Vec<BoundaryPoint>,
    pub(crate) notes: Vec<BranchNote>,
    pub(crate) end: BranchEnd,
    /// Why a boundary followed in both directions begins where it does.
    pub(crate) start: Option<BranchEnd>,
    /// dλ/ds at the last point, over the unit of λ: the direction in which a continuation resumes.
    pub(crate) heading: f64,
    /// Bounds of p.
    pub(crate) across: [f64; 2],
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
    /// Why a boundary followed in both directions begins where it does; `None` for one direction, or if the
    /// second one failed at its start.
    pub fn start(&self) -> Option<&BranchEnd> {
        self.start.as_ref()
    }
    /// Values of λ between which the rest of the contact sequence changes: from there on the boundary is no
    /// longer that of orbits with the sequence of its start, for example because another tooth separated first.
    pub fn notes(&self) -> &[BranchNote] {
        &self.notes
    }
    /// The turning points.
    pub fn turns(&self) -> impl Iterator<Item = (Turn, &BoundaryPoint)> {
        self.points.iter().filter_map(|point| point.turn.map(|turn| (turn, point)))
    }
    /// This line and the rest of it from [`resume_boundary`](crate::branches::Continuation::resume_boundary), whose first
    /// point is the last one of this line.
    ///
    /// # Errors
    /// [`BranchError::NotItsRest`] for a rest that begins elsewhere.
    pub fn joined(mut self, rest: Self) -> Result<Self, BranchError> {
        let place = |point: &BoundaryPoint| (point.parameters, point.arclength);
        if self.points.last().map(place) != rest.points.first().map(place) {
            return Err(BranchError::NotItsRest);
        }
        self.points.extend(rest.points.into_iter().skip(1));
        self.notes.extend(rest.notes);
        Ok(BoundaryLine { end: rest.end, heading: rest.heading, ..self })
    }
    pub(crate) fn reversed_before(mut self, forward: BoundaryLine) -> Self {
        self.points.iter_mut().for_each(|point| point.arclength = -point.arclength);
        self.points.reverse();
        self.points.extend(forward.points.into_iter().skip(1));
        let mut notes = reversed(self.notes);
        notes.extend(forward.notes);
        BoundaryLine { notes, end: forward.end, start: Some(self.end), heading: forward.heading, ..self }
    }

    /// One row per point: p, λ, `arclength`, `turn` (0 none, 1 extremum of λ, 2 cusp) and `largest multiplier` |μ|.
    ///
    /// # Errors
    /// [`ParameterError::Twice`] if both parameters have the same name.
    pub fn table(&self) -> Result<ResultTable, ParameterError> {
        let mut columns = self.parameters.to_vec();
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

/// A summary that a person can read: the ranges of both parameters, the turning points, notes, and why the
/// boundary ends.
impl fmt::Display for BoundaryLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} points of a {}", self.points.len(), self.kind)?;
        for (k, parameter) in self.parameters.iter().enumerate() {
            let values = self.points.iter().map(|point| point.parameters[k]);
            let range = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], p| [l.min(p), h.max(p)]);
            writeln!(f, "  {parameter} = {} .. {}", range[0], range[1])?;
        }
        for (turn, point) in self.turns() {
            writeln!(f, "  {:>18.12} {:>18.12}  {turn}", point.parameters[0], point.parameters[1])?;
        }
        for note in &self.notes {
            writeln!(f, "  note: {note}")?;
        }
        if let Some(start) = &self.start {
            writeln!(f, "  start: {start}")?;
        }
        write!(f, "  end: {}", self.end)
    }
}
