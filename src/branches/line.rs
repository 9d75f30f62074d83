//! A curve that was followed: its points, notes and ends.

use crate::branches::branch_end::BranchEnd;
use crate::branches::branch_error::BranchError;
use crate::error::ParameterError;
#[cfg(feature = "serde")]
use crate::error::check;
use std::fmt;

/// A point of a [`Line`]: [`BranchPoint`](crate::branches::BranchPoint) or
/// [`BoundaryPoint`](crate::branches::BoundaryPoint).
pub trait LinePoint: Sized {
    /// What is common to all points: parameters, channels, the kind of a boundary.
    type Head;
    /// Values of the parameters. The last one is that along which the line is followed.
    fn parameters(&self) -> &[f64];
    /// Distance along the line from its start `[1]`.
    fn arclength(&self) -> f64;
    /// Sets the distance along the line.
    fn set_arclength(&mut self, arclength: f64);
    /// Checks what is common to all points.
    ///
    /// # Errors
    /// What contradicts itself.
    fn check_head(head: &Self::Head) -> Result<(), ParameterError>;
    /// Checks that the point belongs to a line with this head, whose first point is `first`.
    ///
    /// # Errors
    /// What contradicts the head, the first point or itself.
    fn check(&self, head: &Self::Head, first: &Self) -> Result<(), ParameterError>;
    /// Exchanges what stands before and after the point.
    fn reverse(&mut self) {}
    /// Writes the ranges of the parameters and the located points.
    fn summarise(line: &Line<Self>, f: &mut fmt::Formatter<'_>) -> fmt::Result;
}

/// A curve from a [`Continuation`](crate::branches::Continuation): a [`Branch`](crate::branches::Branch) of
/// orbits over a parameter or a [`BoundaryLine`](crate::branches::BoundaryLine) over two.
///
/// ```
/// use gear_dynamics::{State, branches::{BranchEnd, Continuation, Family}, trains::SpurPair};
/// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.6)?;
/// let family = Family::over(&pair, ["speed"])?;
/// let line = Continuation::new(0.6, 0.65).run(&family, &State::new(0.0, &[1.1], &[0.0]))?;
/// assert_eq!((line.points()[0].parameter, line.end()), (0.6, &BranchEnd::Bound));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Line<P: LinePoint> {
    pub(crate) head: P::Head,
    pub(crate) points: Vec<P>,
    pub(crate) notes: Vec<BranchNote>,
    pub(crate) end: BranchEnd,
    /// The end reached in the second direction.
    #[cfg_attr(feature = "serde", serde(rename = "start"))]
    pub(crate) first_end: Option<BranchEnd>,
    /// Change of the last parameter over the length at the last point, in its unit: the direction in which a
    /// continuation resumes.
    pub(crate) heading: f64,
}

/// A change along a branch or a boundary that is no point of it: it could not be located, or, on a boundary,
/// the rest of the contact sequence changed.
///
/// ```
/// use gear_dynamics::branches::BranchNote;
/// let note = BranchNote { parameters: [1.0, 1.1], what: "a multiplier passed -1".into() };
/// assert_eq!(note.to_string(), "between 1 and 1.1: a multiplier passed -1");
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BranchNote {
    /// Parameters of the two points between which it happened. If the line turns back between them, a bound
    /// of the parameter that it reaches replaces that of the nearer point.
    pub parameters: [f64; 2],
    /// What happened.
    pub what: String,
}

impl fmt::Display for BranchNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [from, to] = self.parameters;
        write!(f, "between {from} and {to}: {}", self.what)
    }
}

impl<P: LinePoint> Line<P> {
    pub(crate) fn new(head: P::Head, heading: f64) -> Self {
        Line { head, points: Vec::new(), notes: Vec::new(), end: BranchEnd::Open, first_end: None, heading }
    }
    /// All points, in order along the line.
    pub fn points(&self) -> &[P] {
        &self.points
    }
    /// Why the line ends at its last point.
    pub fn end(&self) -> &BranchEnd {
        &self.end
    }
    /// Why a line that was followed in both directions ends at its first point; `None` for one direction,
    /// or if the second one failed at its start.
    pub fn first_end(&self) -> Option<&BranchEnd> {
        self.first_end.as_ref()
    }
    /// Changes that were noticed and are no points of the line. On a branch they were not located. On a
    /// boundary the rest of the contact sequence changed: from there on the orbits no longer have the
    /// sequence of the start, for example because another tooth separated first.
    pub fn notes(&self) -> &[BranchNote] {
        &self.notes
    }
    /// This line and the rest of it from [`resume`](crate::branches::Continuation::resume), whose first point
    /// is the last one of this line.
    ///
    /// # Errors
    /// [`BranchError::NotItsRest`] for a rest that begins elsewhere.
    pub fn joined(mut self, rest: Self) -> Result<Self, BranchError> {
        let place = |point: &P| (point.parameters().to_vec(), point.arclength());
        if self.points.last().map(place) != rest.points.first().map(place) {
            return Err(BranchError::NotItsRest);
        }
        self.points.extend(rest.points.into_iter().skip(1));
        self.notes.extend(rest.notes);
        Ok(Line { end: rest.end, heading: rest.heading, ..self })
    }
    /// This line in reverse, followed by another one from the same start.
    pub(crate) fn reversed_before(mut self, forward: Self) -> Self {
        for point in &mut self.points {
            point.set_arclength(-point.arclength());
            point.reverse();
        }
        self.points.reverse();
        self.points.extend(forward.points.into_iter().skip(1));
        self.notes.reverse();
        self.notes.iter_mut().for_each(|note| note.parameters.reverse());
        self.notes.extend(forward.notes);
        Line { end: forward.end, first_end: Some(self.end), heading: forward.heading, ..self }
    }
    /// Checks that the points form a line.
    ///
    /// # Errors
    /// The first contradiction.
    #[cfg(feature = "serde")]
    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        P::check_head(&self.head)?;
        check::quantity("heading of the line", self.heading)?;
        for note in &self.notes {
            check::quantities("parameters of a note", &note.parameters)?;
        }
        let Some(first) = self.points.first() else {
            return Err(ParameterError::Empty { name: "points of the line".into(), min: 1 });
        };
        let mut before = f64::NEG_INFINITY;
        for (i, point) in self.points.iter().enumerate() {
            check::quantities(&format!("parameters of point {i}"), point.parameters())?;
            let value = check::quantity(format!("arclength of point {i}"), point.arclength())?;
            if value < before {
                let must = format!("be at least {before:?}, that of the point before it");
                return Err(ParameterError::Wrong { name: format!("arclength of point {i}"), value, must });
            }
            before = value;
            point.check(&self.head, first)?;
        }
        Ok(())
    }
    /// Least and largest value of parameter `k`.
    pub(crate) fn range(&self, k: usize) -> [f64; 2] {
        let values = self.points.iter().map(|point| point.parameters()[k]);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
    }
}

/// A summary that a person can read: ranges of the parameters, located points, notes, and why the line ends.
impl<P: LinePoint> fmt::Display for Line<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        P::summarise(self, f)?;
        for note in &self.notes {
            writeln!(f, "  note: {note}")?;
        }
        if let Some(end) = &self.first_end {
            writeln!(f, "  first end: {end}")?;
        }
        write!(f, "  end: {}", self.end)
    }
}
