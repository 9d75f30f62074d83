//! A branch of periodic orbits.

use crate::branches::branch_end::BranchEnd;
use crate::branches::curve::equations::CurveError;
use crate::branches::points::branch_point::BranchPoint;
use crate::branches::points::kind::PointKind;
use crate::error::ParameterError;
use crate::export::table::ResultTable;
use crate::model::equations::Channel;
use crate::periodic::balance::balance_error::BalanceError;
use crate::periodic::multipliers::Stability;
use crate::periodic::shooting::failure::ShootingError;
use crate::periodic::shooting::shooting_orbit::ShootingOrbit;
use std::fmt;
use thiserror::Error;

/// A curve of periodic orbits over a parameter: its points in order, the located ones among them.
///
/// ```
/// use gear_dynamics::{State, branches::{BranchEnd, ByConstant, Continuation}, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.6)?;
/// let family = ByConstant::new(&pair, "speed")?;
/// let branch = Continuation::new(0.6, 0.65).run(&family, &[State::new(0.0, &[1.1], &[0.0])])?;
/// assert_eq!(branch.end(), &BranchEnd::Bound);
/// assert_eq!(branch.located().count(), 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Branch<O = ShootingOrbit> {
    pub(crate) parameter: Channel,
    pub(crate) channels: Vec<Channel>,
    pub(crate) points: Vec<BranchPoint<O>>,
    pub(crate) notes: Vec<BranchNote>,
    pub(crate) end: BranchEnd,
    /// Why a branch followed in both directions begins where it does.
    pub(crate) start: Option<BranchEnd>,
    /// dp/ds at the last point, over the unit of the parameter: the direction in which a continuation resumes.
    pub(crate) heading: f64,
}

/// A change along a branch or a boundary that is no point of it: it could not be located, or, on a boundary, the rest of
/// the contact sequence changed.
///
/// ```
/// use gear_dynamics::branches::BranchNote;
/// let note = BranchNote { parameters: [1.0, 1.1], what: "a multiplier passed -1".into() };
/// assert_eq!(note.to_string(), "between 1 and 1.1: a multiplier passed -1");
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BranchNote {
    /// Parameters of the two points between which it happened.
    pub parameters: [f64; 2],
    /// What happened.
    pub what: String,
}

/// Notes along the curve in the opposite direction.
pub(crate) fn reversed(mut notes: Vec<BranchNote>) -> Vec<BranchNote> {
    notes.reverse();
    notes.iter_mut().for_each(|note| note.parameters.reverse());
    notes
}

impl fmt::Display for BranchNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [from, to] = self.parameters;
        write!(f, "between {from} and {to}: {}", self.what)
    }
}

/// Errors at the start of a continuation. Later failures end the branch; see [`BranchEnd`].
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, branches::{BranchError, ByConstant, Continuation}};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let family = ByConstant::new(&pair, "speed")?;
/// let error = Continuation::new(100.0, 100.0).run(&family, &[pair.static_start()?]).unwrap_err();
/// assert!(matches!(error, BranchError::EmptyRange { value: 100.0 }));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BranchError {
    /// A setting is not valid.
    #[error("{0}")]
    Parameter(#[from] ParameterError),
    /// The range of the parameter has length zero.
    #[error("the continuation starts and ends at the same parameter {value:?}: the ends must differ")]
    EmptyRange {
        /// Start and end.
        value: f64,
    },
    /// The bounds are reversed or do not contain the start.
    #[error(
        "the bounds of the parameter are {low:?} .. {high:?}: the lower one must be smaller, and {start:?} must lie between them"
    )]
    Bounds {
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
        /// Start of the continuation.
        start: f64,
    },
    /// The start is no orbit.
    #[error("no orbit at the start of the branch: {0}")]
    Start(#[from] ShootingError),
    /// The start is no orbit of the balance.
    #[error("no orbit at the start of the branch: {0}")]
    Balance(#[from] BalanceError),
    /// The first point has no tangent, or is no point of a branch.
    #[error("no branch at its start: {0}")]
    Curve(#[from] CurveError),
    /// Derivatives with respect to constants of a model that has no named constants.
    #[error("the model has no named constants: build it from a Shape and its constants (Machine)")]
    NoConstants,
    /// A branch or a boundary without points cannot be resumed.
    #[error("there is no point from which to resume")]
    NoPoints,
    /// The first point of the rest is not the last one of the first part.
    #[error("the rest does not begin at the last point of the first part")]
    NotItsRest,
    /// The kind of a point does not allow what is asked.
    #[error("the point is {}: {wanted} is needed", kind.as_ref().map_or("a regular point", PointKind::name))]
    Kind {
        /// The kind; `None` for a point that was not located.
        kind: Option<PointKind>,
        /// What kinds of points allow it.
        wanted: &'static str,
    },
    /// The branch or line does not end at a located border of parametric instability.
    #[error("the branch does not run to infinity at a located border: {end}")]
    NoBorder {
        /// Why it ends.
        end: String,
    },
    /// No orbit comes back from infinity.
    #[error(
        "no large orbit of the opposite sign near the border {border:?}{}",
        error.as_ref().map_or(String::new(), |error| format!(": {error}"))
    )]
    NoReturn {
        /// The border.
        border: f64,
        /// Why the last search failed; `None` if it led to the other orbit.
        error: Option<Box<ShootingError>>,
    },
    /// The orbit of a grazing strikes the same rigid stop at another time.
    #[error(
        "the orbit strikes the rigid stop of contact {contact} at another time: its grazing is not followed"
    )]
    Struck {
        /// Index of the contact, from 0.
        contact: usize,
    },
    /// The orbit of a grazing has no extremum at the edge of this contact.
    #[error("contact {contact} has no extremum at this edge: the orbit does not graze it")]
    NoExtremum {
        /// Index of the contact, from 0.
        contact: usize,
    },
}

impl<O> Branch<O> {
    /// This branch and the rest of it from [`resume`](crate::branches::Continuation::resume), whose first point is the
    /// last one of this branch.
    ///
    /// # Errors
    /// [`BranchError::NotItsRest`] for a rest that begins elsewhere.
    pub fn joined(mut self, rest: Self) -> Result<Self, BranchError> {
        let place = |point: &BranchPoint<O>| [point.parameter, point.arclength];
        if self.points.last().map(place) != rest.points.first().map(place) {
            return Err(BranchError::NotItsRest);
        }
        self.points.extend(rest.points.into_iter().skip(1));
        self.notes.extend(rest.notes);
        Ok(Branch { end: rest.end, heading: rest.heading, ..self })
    }
    pub(crate) fn new(parameter: Channel, channels: Vec<Channel>) -> Self {
        let (points, notes) = (Vec::new(), Vec::new());
        Branch { parameter, channels, points, notes, end: BranchEnd::Open, start: None, heading: 0.0 }
    }
    /// This branch in reverse, followed by another one from the same start.
    pub(crate) fn reversed_before(mut self, forward: Self) -> Self {
        for point in &mut self.points {
            point.arclength = -point.arclength;
            if let Some(PointKind::Grazing { rattle, .. }) = &mut point.kind {
                rattle.reverse();
            }
        }
        self.points.reverse();
        self.points.extend(forward.points.into_iter().skip(1));
        let mut notes = reversed(self.notes);
        notes.extend(forward.notes);
        Branch { notes, end: forward.end, start: Some(self.end), heading: forward.heading, ..self }
    }
    /// Name and unit of the parameter.
    pub fn parameter(&self) -> &Channel {
        &self.parameter
    }
    /// Names and units of the measured channels.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }
    /// All points, in order along the branch.
    pub fn points(&self) -> &[BranchPoint<O>] {
        &self.points
    }
    /// The located points with their kinds.
    pub fn located(&self) -> impl Iterator<Item = (&PointKind, &BranchPoint<O>)> {
        self.points.iter().filter_map(|point| point.kind.as_ref().map(|kind| (kind, point)))
    }
    /// The located points of one kind by its [name](PointKind::name): `branch.of_kind("fold")`.
    pub fn of_kind(&self, name: &str) -> Vec<&BranchPoint<O>> {
        self.located().filter(|(kind, _)| kind.name() == name).map(|(_, point)| point).collect()
    }
    /// Why the branch ends.
    pub fn end(&self) -> &BranchEnd {
        &self.end
    }
    /// Why a branch followed in both directions begins where it does; `None` for one direction, or if the second
    /// one failed at its start.
    pub fn start(&self) -> Option<&BranchEnd> {
        self.start.as_ref()
    }
    /// Changes that were noticed and are no points of the branch: they were not located.
    pub fn notes(&self) -> &[BranchNote] {
        &self.notes
    }
    /// On each pass of the branch over `parameter`, the nearer of the two neighbouring points. Nothing is
    /// interpolated.
    pub fn near(&self, parameter: f64) -> Vec<&BranchPoint<O>> {
        let passes = self.points.windows(2).filter_map(|two| {
            let [a, b] = [two[0].parameter - parameter, two[1].parameter - parameter];
            (a * b <= 0.0).then(|| if a.abs() <= b.abs() { &two[0] } else { &two[1] })
        });
        let mut near: Vec<&BranchPoint<O>> = passes.collect();
        near.dedup_by(|a, b| std::ptr::eq(*a, *b));
        near
    }

    /// One row per point: the parameter, `arclength`, then
    ///
    /// - for each channel `mean`, `rms` and `peak-to-peak`;
    /// - `multiplier i real` and `multiplier i imaginary`, by decreasing absolute value, and `largest multiplier` |μ|;
    /// - `stability`: 1 stable, -1 unstable, 0 undecided;
    /// - for each contact its rattle state, `rattle i`, and its sequence: the crossings of its edges in one
    ///   period, `crossings lower i` and `crossings upper i`;
    /// - `kind`: 0 for a regular point, otherwise the [code](PointKind::code) of the located one.
    ///
    /// # Errors
    /// [`ParameterError::Twice`] for a channel measured twice.
    pub fn table(&self) -> Result<ResultTable, ParameterError> {
        let mut columns = vec![self.parameter.clone(), Channel::new("arclength", "1")];
        let number = |name: String| Channel::new(name, "1");
        for Channel { name, unit } in &self.channels {
            let figures = ["mean", "rms", "peak-to-peak"];
            columns.extend(figures.map(|figure| Channel::new(format!("{name} {figure}"), unit.as_str())));
        }
        let first = self.points.first();
        let multipliers = first.map_or(0, |point| point.multipliers.values().len());
        for i in 1..=multipliers {
            columns.extend(["real", "imaginary"].map(|part| number(format!("multiplier {i} {part}"))));
        }
        columns.extend(["largest multiplier", "stability"].map(|name| number(name.into())));
        for i in 1..=first.map_or(0, |point| point.rattle.len()) {
            columns
                .extend(["rattle", "crossings lower", "crossings upper"].map(|n| number(format!("{n} {i}"))));
        }
        columns.push(number("kind".into()));
        let mut table = ResultTable::new(columns)?;
        for point in &self.points {
            let mut row = vec![point.parameter, point.arclength];
            row.extend(point.summaries.iter().flat_map(|s| [s.mean, s.rms, s.peak_to_peak()]));
            row.extend(point.multipliers.values().iter().flat_map(|m| [m.re, m.im]));
            row.push(point.multipliers.largest());
            row.push(match point.stability() {
                Stability::Stable => 1.0,
                Stability::Unstable => -1.0,
                Stability::Undecided => 0.0,
            });
            for (rattle, [lower, upper]) in point.rattle.iter().zip(&point.crossings) {
                row.extend([f64::from(rattle.rsv()), f64::from(*lower), f64::from(*upper)]);
            }
            row.push(point.kind.as_ref().map_or(0.0, |kind| f64::from(kind.code())));
            table.push(&row)?;
        }
        Ok(table)
    }
}

/// A summary that a person can read: the range, the located points, notes, and why the branch ends.
impl<O> fmt::Display for Branch<O> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let range = self.points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], point| {
            [low.min(point.parameter), high.max(point.parameter)]
        });
        writeln!(f, "{} points, {} = {} .. {}", self.points.len(), self.parameter(), range[0], range[1])?;
        for (kind, point) in self.located() {
            writeln!(f, "  {:>18.12}  peak-to-peak {:.6e}  {kind}", point.parameter, point.peak_to_peak())?;
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
