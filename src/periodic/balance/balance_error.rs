//! Errors of a harmonic balance.

use crate::error::ParameterError;
use crate::linear::LinearError;
use crate::model::structure::drifts::accelerates;
use crate::periodic::balance::fourier_orbit::FourierOrbit;
use crate::periodic::balance::integrals::Integrals;
use thiserror::Error;

/// Errors of [`Balance`](crate::Balance).
///
/// ```
/// use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams, Periodic};
/// use gear_dynamics::periodic::{BalanceError, FourierOrbit};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let in_the_gap = FourierOrbit::new(&Harmonics::up_to(0), pair.period(), &[vec![0.0]])?;
/// let error = Balance::new(Harmonics::up_to(70)).solve(&pair, &in_the_gap).unwrap_err();
/// assert!(matches!(error, BalanceError::StartInGap { contact: 0 }));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BalanceError {
    /// A guess or a setting is not valid.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// No guess was given, and the model has no static state.
    #[error("balance: no guess, and no static state to start from: {0}")]
    NoStaticState(LinearError),
    /// The samples are too few for the orders.
    #[error(
        "{samples} samples are too few for order {highest}: at least {} are needed, and several times as \
         many with contacts",
        (2 * highest + 1).max(16)
    )]
    Samples {
        /// Number M of samples.
        samples: usize,
        /// Highest order.
        highest: usize,
    },
    /// A way of integration is not available for the model.
    #[error(
        "integration by {integrals:?} is not available for this model: Closed and Kinks need \
         fixed pieces (Model::accel_on_pieces) and no drive edges; Closed also needs accelerations that are \
         linear on the pieces, contacts that add up and drives with at most some 6000 harmonics; \
         Integrals::Exact chooses an available way"
    )]
    NotAvailable {
        /// The way that was set.
        integrals: Integrals,
    },
    /// The model does not evaluate its contact laws on fixed pieces
    /// ([`accel_on_pieces`](crate::Model::accel_on_pieces)).
    #[error(
        "the model does not evaluate its contact laws on fixed pieces: implement Model::accel_on_pieces and \
         declare it in Model::offers (Offers::pieces), or \
         start from a series of a settled run"
    )]
    NoPieces,
    /// Truncated forces need the values of the contact laws ([`Offers::laws`](crate::model::Offers::laws)),
    /// which the model does not give or the integration by panels does not read.
    #[error(
        "truncated forces need the values of the contact laws (Offers::laws, which every Shape has), and other \
         integrals than {integrals:?} where these go by panels"
    )]
    NoLaws {
        /// The way of integration that was set.
        integrals: Integrals,
    },
    /// The model has a rigid stop. A Fourier series cannot represent velocities that jump;
    /// [`Shooting`](crate::Shooting) can.
    #[error(
        "contact {contact} has a rigid stop, at which velocities jump: a Fourier series cannot represent the \
         jump; use Shooting"
    )]
    RigidStop {
        /// Index of the contact, from 0.
        contact: usize,
    },
    /// A contact stays in its gap along the guess, and nothing determines the mean.
    #[error(
        "contact {contact} stays in its gap along the guess, where nothing restores the mean: start on a \
         flank, for example from Balance::linearised"
    )]
    StartInGap {
        /// Index of the contact, from 0.
        contact: usize,
    },
    /// The model has no Jacobian, and differences cannot decide whether a motion is rigid.
    #[error(
        "the stiffness of a motion is {share:.1e} of the largest one: differences cannot decide whether the \
         motion is rigid; implement Model::jacobian"
    )]
    BarelySupported {
        /// Stiffness of the motion as a share of the largest `[1]`.
        share: f64,
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
        last: Box<FourierOrbit>,
    },
    /// The equations do not determine a coordinate: at order 0 neither a stiffness nor a drag acts on its
    /// mean, at another order a resonance without damping lies there, or the orbit is at a fold.
    #[error(
        "the balance does not determine order {order} of coordinate {coordinate} after {} iterations: {}",
        last.iterations(),
        if *order == 0 {
            "neither a stiffness nor a drag acts on its mean"
        } else {
            "a resonance without damping lies at this order, or the orbit is at a fold"
        }
    )]
    Singular {
        /// Index of the coordinate, from 0.
        coordinate: usize,
        /// The order that is determined least, in multiples of the orbit's frequency.
        order: usize,
        /// The last iterate.
        last: Box<FourierOrbit>,
    },
    /// A coordinate is connected neither to others nor to the ground, and its mean acceleration is not zero:
    /// its velocity changes in every period, and there is no periodic orbit.
    #[error("{}", accelerates(.coordinate, .gain))]
    Accelerates {
        /// The coordinate, from 0.
        coordinate: usize,
        /// Its gain of velocity in one period of the orbit.
        gain: f64,
        /// The series of all coordinates without this gain.
        last: Box<FourierOrbit>,
    },
    /// The root finder did not converge.
    #[error(
        "the balance did not converge in {} iterations: the largest residual is {:?}; try a guess projected \
         from a settled motion, over several periods if the motion repeats only after several",
        last.iterations(), last.residual()
    )]
    NotConverged {
        /// The last iterate; it is not an orbit.
        last: Box<FourierOrbit>,
        /// Largest residual of every iterate, the guess first.
        residuals: Vec<f64>,
    },
    /// A residual is not finite.
    #[error("the residual of the balance is not finite after {} iterations", last.iterations())]
    NotFinite {
        /// The last finite iterate, or the guess.
        last: Box<FourierOrbit>,
    },
    /// The accuracy was not reached.
    #[error(
        "the accuracy {wanted:?} was not reached with orders up to {highest}: the estimated error is \
         {reached:?}{}",
        cause.as_ref().map_or(String::new(), |c| format!("; more orders fail: {c}"))
    )]
    Accuracy {
        /// Accuracy that was set, as a share of the peak-to-peak value `[1]`.
        wanted: f64,
        /// Estimated error of the last orbit whose errors were estimated; infinite if there is none.
        reached: f64,
        /// Highest order allowed, or highest order reached if there is a `cause`.
        highest: usize,
        /// The best orbit: it converged but is less accurate than required.
        last: Box<FourierOrbit>,
        /// Error of the estimate with more orders, if it failed.
        cause: Option<Box<BalanceError>>,
    },
    /// The [`Budget`](crate::Budget) is spent, or the call was cancelled.
    #[error("the balance stopped after {} iterations: {exhausted}", last.iterations())]
    Exhausted {
        /// The limit that was reached.
        exhausted: crate::ode::budget::Exhausted,
        /// The last iterate, or the guess.
        last: Box<FourierOrbit>,
    },
}

impl BalanceError {
    /// The last iterate, or the best orbit; `None` if the iteration did not begin.
    pub fn last(&self) -> Option<&FourierOrbit> {
        match self {
            BalanceError::Slope { last, .. }
            | BalanceError::Singular { last, .. }
            | BalanceError::Accelerates { last, .. }
            | BalanceError::NotConverged { last, .. }
            | BalanceError::NotFinite { last, .. }
            | BalanceError::Exhausted { last, .. }
            | BalanceError::Accuracy { last, .. } => Some(last),
            _ => None,
        }
    }
}
