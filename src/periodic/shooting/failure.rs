//! Why no orbit is returned.

use crate::error::ParameterError;
use crate::model::equations::State;
use crate::ode::error::IntegrateError;
use thiserror::Error;

/// How far shooting came.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, Shooting};
/// let pair = NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() })?;
/// let error = Shooting::new().segments(1).max_iterations(1).run(&pair, &[pair.static_start()?]).unwrap_err();
/// let last = error.last().ok_or("an iterate")?;
/// assert_eq!((last.states.len(), last.corrections.len()), (1, 1));
/// assert!(last.corrections[0] > 0.1); // far from an orbit
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Iterate {
    /// The states at the nodes.
    pub states: Vec<State>,
    /// The corrections so far, as shares of the range of motion.
    pub corrections: Vec<f64>,
}

/// Why [`Shooting`](crate::Shooting) returns no orbit.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, Shooting, periodic::ShootingError};
/// let pair = NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() })?;
/// let error = Shooting::new().max_iterations(1).run(&pair, &[pair.static_start()?]).unwrap_err();
/// assert!(matches!(&error, ShootingError::NotConverged { last, .. } if last.corrections.len() == 1));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ShootingError {
    /// A guess or a setting that cannot be used.
    #[error("shooting: {0}")]
    Parameter(#[from] ParameterError),
    /// States of the guess out of order, or past the period.
    #[error(
        "state {index} of the guess stands at t = {time}: times must increase and stay within the period from {from} to {to}"
    )]
    GuessTime {
        /// Its place in the list.
        index: usize,
        /// Its time.
        time: f64,
        /// Where the period begins.
        from: f64,
        /// Where it ends.
        to: f64,
    },
    /// A run over a segment failed.
    #[error("segment {segment}: {error}")]
    Flow {
        /// Which one, from 0.
        segment: usize,
        /// Why.
        error: IntegrateError,
        /// How far it came.
        last: Iterate,
    },
    /// Nothing fixes the orbit: it sits on a fold or a branching, or a coordinate floats in its gap.
    #[error(
        "the shooting equations are singular, most of all in component {component} of (coordinates, velocities): the orbit is at a fold \
         or a branching, or this component floats"
    )]
    Singular {
        /// The component that the equations fix least, from 0.
        component: usize,
        /// How far it came.
        last: Iterate,
    },
    /// Corrections do not become small.
    #[error(
        "no orbit was met: after {} corrections the last moves component {component} of (coordinates, velocities), whose range is {range:e}, \
         by {correction:e}; an orbit that closes after several periods asks for Shooting::multiple",
        last.corrections.len()
    )]
    NotConverged {
        /// The component that the last correction moves most as a share of its range, from 0.
        component: usize,
        /// Its range of motion.
        range: f64,
        /// By how much it is moved.
        correction: f64,
        /// How far it came.
        last: Iterate,
    },
}

impl ShootingError {
    /// The last iterate, if iterations had begun.
    pub fn last(&self) -> Option<&Iterate> {
        match self {
            ShootingError::Parameter(_) | ShootingError::GuessTime { .. } => None,
            ShootingError::Flow { last, .. }
            | ShootingError::Singular { last, .. }
            | ShootingError::NotConverged { last, .. } => Some(last),
        }
    }
}
