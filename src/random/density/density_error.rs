//! Errors of a density.

use crate::error::ParameterError;
use crate::ode::{Exhausted, IntegrateError};
use thiserror::Error;

/// Errors of [`PathIntegration`](crate::random::PathIntegration).
///
/// ```
/// use gear_dynamics::models::Oscillator;
/// use gear_dynamics::random::{DensityError, PathIntegration};
/// let duffing = [("speed", 1.0), ("damping", 0.5), ("linear stiffness", 1.0), ("cubic stiffness", 1.0)];
/// let narrow = PathIntegration::new(1.0, [-1.0, 1.0], [-1.0, 1.0])?; // σ of v is 1
/// let error = narrow.panels(4).stationary(&Oscillator::new(&duffing)?).unwrap_err();
/// assert!(matches!(error, DensityError::Leaves { share, .. } if share > 0.1));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum DensityError {
    /// A setting is not valid.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The model does not have one degree of freedom.
    #[error("the model has {dof} degrees of freedom: path integration requires 1")]
    Dof {
        /// Degrees of freedom of the model.
        dof: usize,
    },
    /// The model has a rigid stop, at which velocities jump.
    #[error("contact {contact} has a rigid stop: path integration requires a force that stays finite")]
    RigidStop {
        /// Index of the contact, from 0.
        contact: usize,
    },
    /// The drives of the model vary, and a stationary density was asked for.
    #[error(
        "the accelerations differ at t = 0 and t = {t:?}: the model has no stationary density; \
         PathIntegration::run finds the periodic one"
    )]
    Varies {
        /// A time at which an acceleration differs from that at 0.
        t: f64,
    },
    /// A motion between two steps could not be followed.
    #[error("a motion of the model could not be followed: {0}")]
    Integrate(#[from] IntegrateError),
    /// The density is not small at the ends of the ranges.
    #[error(
        "about {share:?} of the probability lies outside of the ranges: at most {limit:?} is allowed; enlarge the \
         ranges"
    )]
    Leaves {
        /// Estimated share outside `[1]`.
        share: f64,
        /// Largest share allowed `[1]`.
        limit: f64,
    },
    /// The density did not become stationary or periodic.
    #[error(
        "the density still changes by {change:?} after {repetitions} repetitions, more than {tolerance:?}: the \
         grid is too coarse, or the motion relaxes too slowly"
    )]
    NotConverged {
        /// Repetitions of the map.
        repetitions: usize,
        /// The last change, ∫∫ |p_{k+1} - p_k| dx dv.
        change: f64,
        /// The change allowed.
        tolerance: f64,
    },
    /// The [`Budget`](crate::Budget) is spent, or the call was cancelled.
    #[error("the path integration stopped: {exhausted}")]
    Exhausted {
        /// The limit that was reached.
        exhausted: Exhausted,
    },
}

impl From<Exhausted> for DensityError {
    fn from(exhausted: Exhausted) -> Self {
        DensityError::Exhausted { exhausted }
    }
}
