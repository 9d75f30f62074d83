//! Errors of a continuation.

use crate::branches::branch_end::BranchEnd;
use crate::branches::curve::equations::CurveError;
use crate::branches::points::kind::PointKind;
use crate::error::ParameterError;
use crate::model::State;
use crate::periodic::{BalanceError, ShootingError};
use thiserror::Error;

/// Errors at the start of a continuation. Later failures end the branch; see
/// [`BranchEnd`](crate::branches::BranchEnd).
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, ParameterError, branches::{BranchError, Continuation, Family}};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let family = Family::over(&pair, ["speed"])?;
/// let error = Continuation::new(100.0, 100.0).run(&family, &[pair.on_drive_flank()?]).unwrap_err();
/// assert!(matches!(error, BranchError::Parameter(ParameterError::Bounds { value: 100.0, .. })));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BranchError {
    /// A setting is not valid.
    #[error("{0}")]
    Parameter(#[from] ParameterError),
    /// The start is no orbit.
    #[error("no orbit at the start of the branch: {0}")]
    Start(#[from] ShootingError),
    /// The start is no orbit of the balance.
    #[error("no orbit at the start of the branch: {0}")]
    Balance(#[from] BalanceError),
    /// The first point has no tangent, or is no point of a branch.
    #[error("no branch at its start: {0}")]
    Curve(#[from] CurveError),
    /// A branch or a boundary without points cannot be resumed.
    #[error("there is no point from which to resume")]
    NoPoints,
    /// The first point of the rest is not the last one of the first part.
    #[error("the rest does not begin at the last point of the first part")]
    NotItsRest,
    /// The kind of a point does not allow what is asked.
    #[error("the point is {}: {wanted} is needed", kind.as_ref().map_or("a regular point".into(), PointKind::to_string))]
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
        end: Box<BranchEnd>,
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

impl BranchError {
    /// The states of the last iterate of the first orbit, at increasing times within one period: a guess for
    /// [`Shooting`](crate::Shooting). Those of a balance are 2h + 1 states at equal times, with the highest
    /// order h. `None` if no iteration began.
    ///
    /// ```
    /// use gear_dynamics::{NfgPair, NfgParams, Shooting, branches::{Continuation, Family}};
    /// let pair = NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() })?;
    /// let family = Family::over(&pair, ["speed"])?;
    /// let range = Continuation::new(180.0, 190.0).shooting(Shooting::new().segments(4).max_iterations(1));
    /// let error = range.run(&family, &[pair.on_drive_flank()?]).unwrap_err();
    /// assert_eq!(error.last().map(|states| states.len()), Some(4));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn last(&self) -> Option<Vec<State>> {
        match self {
            BranchError::Start(error) => error.last().map(|last| last.states.clone()),
            BranchError::NoReturn { error, .. } => error.as_ref()?.last().map(|last| last.states.clone()),
            BranchError::Balance(error) => {
                let last = error.last()?;
                last.states(2 * last.harmonics().highest() + 1).ok()
            }
            _ => None,
        }
    }
}
