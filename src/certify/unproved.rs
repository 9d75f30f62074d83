//! Reasons why a periodic motion could not be proved.

use crate::error::ParameterError;
use crate::ode::{Exhausted, IntegrateError};
use crate::periodic::ShootingError;
use thiserror::Error;

/// Why [`certify`](crate::periodic::ShootingOrbit::certify) proves nothing. None of these says that there is
/// no orbit.
///
/// ```
/// use gear_dynamics::{certify::Unproved, model::from_fn, Shooting, State};
/// let swing = from_fn(1, |t, q, v, a| a[0] = (2.0 * t).cos() - 0.1 * v[0] - q[0])?;
/// let swing = swing.with_period(std::f64::consts::PI)?;
/// let orbit = Shooting::new().solve(&swing, &State::at_rest(1))?;
/// assert!(matches!(orbit.certify(&swing), Err(Unproved::NoEnclosure { .. }))); // a closure on plain numbers
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Unproved {
    /// A setting, or the name of a constant, is not valid.
    #[error("certificate: {0}")]
    Parameter(#[from] ParameterError),
    /// The integration along the orbit failed, from which the proof takes the sequence of contacts.
    #[error("certificate: {0}")]
    Integrate(IntegrateError),
    /// The orbit was not found from its neighbour.
    #[error("certificate: {0}")]
    Shooting(#[from] Box<ShootingError>),
    /// The budget of the orbit is spent, or the call was cancelled.
    #[error("certificate: {exhausted}")]
    Exhausted {
        /// The limit that was reached.
        exhausted: Exhausted,
    },
    /// The model has several rigid motions, or one that changes a recorded sum by more than its rounding.
    #[error("certificate: the rigid motions of the model cannot be left out: use relative coordinates")]
    RigidMotion,
    /// A part of the model has no enclosure.
    #[error(
        "certificate: a proof needs bounds over ranges of the state, and there are none for {what}: state the \
         model as a `Machine` with smooth pieces, or rely on `ShootingOrbit::accuracy`"
    )]
    NoEnclosure {
        /// The part.
        what: String,
    },
    /// The motion within the boxes has no enclosure over a step.
    #[error(
        "certificate: the bounds of the motion grow without limit over the step of {length:?} from t = {t:?}: the \
         force is too steep there, or the orbit too unstable"
    )]
    Wrapping {
        /// Start of the step.
        t: f64,
        /// Its length.
        length: f64,
    },
    /// Another contact than that of the sequence may leave its piece.
    #[error(
        "certificate: contact {contact} may leave its piece near t = {t:?}, outside of the sequence of contacts"
    )]
    Leaves {
        /// Index of the contact, from 0.
        contact: usize,
        /// Time.
        t: f64,
    },
    /// A contact crosses its edge too slowly for the width of the boxes.
    #[error("certificate: contact {contact} may graze its edge near t = {t:?}")]
    NearGrazing {
        /// Index of the contact, from 0.
        contact: usize,
        /// Time.
        t: f64,
    },
    /// A crossing and a drive edge, an impact or a crossing of the same contact follow each other too
    /// closely to be ordered.
    #[error("certificate: crossings or drive edges at t = {t:?} and {after:?} are too close to be ordered")]
    Together {
        /// The first time.
        t: f64,
        /// The second time.
        after: f64,
    },
    /// A contact crosses its edge together with others, and the equations are not the same on both of its
    /// pieces there.
    #[error(
        "certificate: contact {contact} crosses together with others at t = {t:?}, with forces that jump"
    )]
    Jumps {
        /// Index of the contact, from 0.
        contact: usize,
        /// Time.
        t: f64,
    },
    /// The Newton operator does not map the boxes into themselves.
    #[error(
        "certificate: one turn maps the box at t = {t:?} to {needed:?} of its width, and a share below 1 is needed: the \
         orbit is near a bifurcation, or not accurate enough (Shooting::flow_tolerance)"
    )]
    NotContracting {
        /// Time of the worst box.
        t: f64,
        /// Width of its image over its own width.
        needed: f64,
    },
    /// A certificate that was checked again does not hold for this model.
    #[error("certificate: {what} differ from those that are proved")]
    Differs {
        /// What differs.
        what: String,
    },
}

impl From<Exhausted> for Unproved {
    fn from(exhausted: Exhausted) -> Self {
        Unproved::Exhausted { exhausted }
    }
}

impl From<IntegrateError> for Unproved {
    fn from(error: IntegrateError) -> Self {
        match error {
            IntegrateError::Exhausted { exhausted, .. } => Unproved::Exhausted { exhausted },
            other => Unproved::Integrate(other),
        }
    }
}
