//! Errors of a balance of a torus.

use crate::error::ParameterError;
use crate::ode::Exhausted;
use crate::tori::balance::torus::Torus;
use crate::tori::quasi_periodic::QuasiPeriodicError;
use thiserror::Error;

/// Errors of [`TorusBalance`](crate::tori::TorusBalance).
///
/// ```
/// use gear_dynamics::{Model, excitation::Side};
/// use gear_dynamics::tori::{QuasiPeriodic, TorusBalance, TorusError, WaveVectors};
/// struct Resonant; // base frequencies 2 and 3
/// impl Model for Resonant {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) { a[0] = u[0] - 0.1 * v[0] - q[0]; }
///     fn drive(&self, t: f64, side: Side, u: &mut [f64]) { self.drive_at(&[2.0 * t, 3.0 * t], side, u); }
/// }
/// impl QuasiPeriodic for Resonant {
///     fn frequencies(&self) -> Vec<f64> { vec![2.0, 3.0] }
///     fn drive_at(&self, angles: &[f64], _: Side, u: &mut [f64]) {
///         u[0] = angles[0].cos() + angles[1].cos();
///     }
/// }
/// let balance = TorusBalance::new(WaveVectors::in_box(&[3, 3])?);
/// let error = balance.solve(&Resonant, &balance.at_rest(&Resonant, &[0.0])?).unwrap_err();
/// assert!(matches!(error, TorusError::Commensurate { vector, rate: 0.0, .. } if vector == [3, -2]));
/// # Ok::<(), TorusError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TorusError {
    /// A guess or a setting is not valid.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The drives of the model are not functions of its angles.
    #[error(transparent)]
    Drives(#[from] QuasiPeriodicError),
    /// The states do not determine the coefficients: they are too few, or they do not spread over the torus.
    #[error(
        "{states} states do not determine {unknowns} coefficients: take more states, at times that have no \
         common step with the periods, over several of the slowest periods"
    )]
    Unspread {
        /// Number of states.
        states: usize,
        /// Number of coefficients of a coordinate.
        unknowns: usize,
    },
    /// The base frequencies are commensurate within the kept orders.
    #[error(
        "the base frequencies are commensurate: |k·ω| is {rate:?} at the wave vector {vector:?}, and at least \
         {limit:?} is required; a periodic motion is found by Balance, a nearly resonant one with fewer orders \
         or a smaller separation"
    )]
    Commensurate {
        /// The wave vector k.
        vector: Vec<i32>,
        /// |k·ω|, in rad per time unit of the model.
        rate: f64,
        /// Smallest accepted |k·ω|.
        limit: f64,
    },
    /// The model has a rigid stop. A Fourier series cannot represent velocities that jump.
    #[error(
        "contact {contact} has a rigid stop, at which velocities jump: a Fourier series cannot represent the \
         jump; use CircleShooting"
    )]
    RigidStop {
        /// Index of the contact, from 0.
        contact: usize,
    },
    /// The model does not evaluate its contact laws on fixed pieces
    /// ([`accel_on_pieces`](crate::Model::accel_on_pieces)).
    #[error(
        "the model does not evaluate its contact laws on fixed pieces: implement Model::accel_on_pieces and \
         declare it in Model::offers (Offers::pieces), or \
         start from a torus fitted to a run"
    )]
    NoPieces,
    /// The equations do not determine a coefficient.
    #[error(
        "the balance does not determine coordinate {coordinate} at the wave vector {vector:?} after {} \
         iterations: at k = 0 no stiffness acts on it, otherwise the torus is at a fold or at a resonance",
        last.iterations()
    )]
    Singular {
        /// Index of the coordinate, from 0.
        coordinate: usize,
        /// The wave vector.
        vector: Vec<i32>,
        /// The last iterate.
        last: Box<Torus>,
    },
    /// A slope of the model is not finite.
    #[error(
        "the slope of acceleration {acceleration} with respect to coordinate {coordinate}, or to its \
         velocity, is not finite along iterate {} of the balance",
        last.iterations()
    )]
    Slope {
        /// Index of the acceleration, from 0.
        acceleration: usize,
        /// Index of the coordinate, from 0.
        coordinate: usize,
        /// The last iterate.
        last: Box<Torus>,
    },
    /// The root finder did not converge.
    #[error(
        "the balance did not converge in {} iterations: the largest residual is {:?}",
        last.iterations(), last.residual()
    )]
    NotConverged {
        /// The last iterate; it is not a torus of the model. [`Torus::residuals`] lists the residuals.
        last: Box<Torus>,
    },
    /// A residual is not finite.
    #[error("the residual of the balance is not finite after {} iterations", last.iterations())]
    NotFinite {
        /// The last finite iterate, or the guess.
        last: Box<Torus>,
    },
    /// The [`Budget`](crate::Budget) is spent, or the call was cancelled.
    #[error("the balance stopped after {} iterations: {exhausted}", last.iterations())]
    Exhausted {
        /// The limit that was reached.
        exhausted: Exhausted,
        /// The last iterate, or the guess.
        last: Box<Torus>,
    },
}

impl TorusError {
    /// The last iterate, if the solve began.
    pub fn last(&self) -> Option<&Torus> {
        match self {
            TorusError::Singular { last, .. }
            | TorusError::Slope { last, .. }
            | TorusError::NotConverged { last }
            | TorusError::NotFinite { last }
            | TorusError::Exhausted { last, .. } => Some(last),
            _ => None,
        }
    }
}
