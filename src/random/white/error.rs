//! Errors of runs under white noise.

use crate::error::ParameterError;
use crate::linear::LinearError;
use crate::ode::Exhausted;
use crate::sweep::lanes::drive_table::TableError;
use crate::sweep::sweep_error::SweepError;
use thiserror::Error;

/// Errors of runs under white noise.
///
/// ```
/// let error = gear_dynamics::random::NoiseError::Diverged { member: 3, t: 2.5 };
/// assert_eq!(error.to_string(), "the motion of member 3 becomes infinite or NaN before t = 2.5");
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NoiseError {
    /// A setting, a source of noise or a start that is not allowed for the model.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The drive table of the model is not possible.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A channel that lanes do not measure.
    #[error(transparent)]
    Channel(#[from] SweepError),
    /// No start was given, and the model has no static state.
    #[error("no static state to start from: {0}")]
    NoStaticState(#[from] LinearError),
    /// A rigid stop: an impact needs a located edge, and fixed steps do not locate edges.
    #[error(
        "contact {contact} has a rigid stop: white noise in lanes has fixed steps, which do not locate impacts"
    )]
    StopNotLocated {
        /// Index of the contact.
        contact: usize,
    },
    /// The lower edge of a gap lies above its upper edge, or is not a number. The backlash is then negative
    /// or not defined.
    #[error(
        "the gap of contact {contact} is negative or not a number: its lower edge is {lower:?}, its upper edge {upper:?}"
    )]
    NegativeGap {
        /// Index of the contact, from 0.
        contact: usize,
        /// Lower edge of the gap.
        lower: f64,
        /// Upper edge of the gap.
        upper: f64,
    },
    /// A coordinate or a velocity becomes infinite or NaN, or so large that its mean square has no finite
    /// error: the step is too long, or the motion has no stationary state.
    #[error("the motion of member {member} becomes infinite or NaN before t = {t:?}")]
    Diverged {
        /// Number of the member.
        member: u64,
        /// Time at which it was seen.
        t: f64,
    },
    /// Cancelled before there were enough results for an estimate with an error.
    #[error("stopped after {done} of {all} members or repeats: {exhausted}")]
    Exhausted {
        /// The reason, [`Exhausted::Cancelled`].
        exhausted: Exhausted,
        /// Members or repeats that were complete.
        done: u64,
        /// All members or repeats.
        all: u64,
    },
    /// No particle of a stage of a splitting passed this score: more particles are needed, or the score does
    /// not lead to the event.
    #[error(
        "no particle of stage {stage} passed the score {score:?}: more particles are needed, or another score"
    )]
    Extinct {
        /// Number of the stage, from 0.
        stage: usize,
        /// The score that was reached last.
        score: f64,
    },
}

impl NoiseError {
    /// Cancelled after `done` of `all` members or repeats.
    pub(crate) fn cancelled(done: usize, all: usize) -> Self {
        NoiseError::Exhausted { exhausted: Exhausted::Cancelled, done: done as u64, all: all as u64 }
    }
}
