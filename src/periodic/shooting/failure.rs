//! Errors of shooting.

use crate::error::ParameterError;
use crate::linear::LinearError;
use crate::model::State;
use crate::model::structure::drifts::accelerates;
use crate::ode::{Exhausted, IntegrateError};
use thiserror::Error;

/// The last iterate of a shooting run that failed.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, Shooting};
/// let pair = NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() })?;
/// let shooting = Shooting::new().segments(1).max_iterations(1);
/// let error = shooting.solve(&pair, &[pair.on_drive_flank()?]).unwrap_err();
/// let last = error.last().ok_or("an iterate")?;
/// assert_eq!((last.states.len(), last.corrections.len()), (1, 1));
/// assert!(last.corrections[0] > 0.1); // the guess is far from an orbit
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Iterate {
    /// The states at the nodes.
    pub states: Vec<State>,
    /// The corrections so far, as shares of the range of motion `[1]`.
    pub corrections: Vec<f64>,
}

/// Errors of [`Shooting`](crate::Shooting).
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, Shooting, periodic::ShootingError};
/// let pair = NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() })?;
/// let error = Shooting::new().max_iterations(1).solve(&pair, &[pair.on_drive_flank()?]).unwrap_err();
/// assert!(matches!(&error, ShootingError::NotConverged { last, .. } if last.corrections.len() == 1));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ShootingError {
    /// A guess or a setting is not valid.
    #[error("shooting: {0}")]
    Parameter(#[from] ParameterError),
    /// No guess was given, and the model has no static state.
    #[error("shooting: no guess, and no static state to start from: {0}")]
    NoStaticState(LinearError),
    /// The times of the guess do not increase, or a time lies outside the period.
    #[error(
        "state {index} of the guess has t = {time:?}: times must increase and lie in the period [{from:?}, {to:?})"
    )]
    GuessTime {
        /// Index of the state in the list, from 0.
        index: usize,
        /// Time of the state.
        time: f64,
        /// Start of the period.
        from: f64,
        /// End of the period.
        to: f64,
    },
    /// The integration over a segment failed.
    #[error("the integration over segment {segment} failed: {error}")]
    Integrate {
        /// Index of the segment, from 0.
        segment: usize,
        /// Error of the integration.
        error: IntegrateError,
        /// The last iterate.
        last: Iterate,
    },
    /// The [`Budget`](crate::Budget) is spent, or the call was cancelled.
    #[error("shooting stopped after {} corrections: {exhausted}", last.corrections.len())]
    Exhausted {
        /// The limit that was reached.
        exhausted: Exhausted,
        /// The last iterate.
        last: Iterate,
    },
    /// The equations do not determine the orbit: it is at a fold or a branch point, or a coordinate moves
    /// freely in its gap.
    #[error(
        "the shooting equations are singular; component {component} of (coordinates, velocities) is \
         determined least: the orbit is at a fold or a branch point, or nothing restores this component, as teeth \
         without a load in their gap"
    )]
    Singular {
        /// The component that the equations determine least, from 0.
        component: usize,
        /// The last iterate.
        last: Iterate,
    },
    /// The corrections do not become small.
    #[error(
        "shooting did not converge: after {} corrections the last one still changes component {component} of \
         (coordinates, velocities) by {correction:e}, with a range of {range:e}; start from a settled state \
         (Settle), and if the orbit closes only after several periods, set Shooting::period_multiple",
        last.corrections.len()
    )]
    NotConverged {
        /// The component that the last correction changes most as a share of its range, from 0.
        component: usize,
        /// Range of motion of this component.
        range: f64,
        /// Change of this component by the last correction.
        correction: f64,
        /// The last iterate.
        last: Iterate,
    },
    /// A coordinate is connected neither to others nor to the ground, and its mean acceleration is not zero:
    /// its velocity changes in every period, and there is no periodic orbit.
    #[error("{}", accelerates(.coordinate, .gain))]
    Accelerates {
        /// The coordinate that gains most, from 0.
        coordinate: usize,
        /// Its gain of velocity in one period of the orbit.
        gain: f64,
        /// The last iterate.
        last: Iterate,
    },
    /// The orbit is found, but its monodromy matrix has no finite eigenvalues.
    #[error("shooting found an orbit without multipliers: {error}")]
    Multipliers {
        /// What is wrong with the matrix.
        error: ParameterError,
        /// The orbit.
        last: Iterate,
    },
}

impl ShootingError {
    /// The error for an integration that ended in a segment.
    pub(crate) fn of_segment(segment: usize, error: IntegrateError, last: Iterate) -> Self {
        match error {
            IntegrateError::Exhausted { exhausted, .. } => ShootingError::Exhausted { exhausted, last },
            error => ShootingError::Integrate { segment, error, last },
        }
    }

    /// The last iterate; `None` if the guess or a setting was refused.
    pub fn last(&self) -> Option<&Iterate> {
        match self {
            ShootingError::Parameter(_)
            | ShootingError::NoStaticState(_)
            | ShootingError::GuessTime { .. } => None,
            ShootingError::Integrate { last, .. }
            | ShootingError::Exhausted { last, .. }
            | ShootingError::Accelerates { last, .. }
            | ShootingError::Singular { last, .. }
            | ShootingError::NotConverged { last, .. }
            | ShootingError::Multipliers { last, .. } => Some(last),
        }
    }
}
