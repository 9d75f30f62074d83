//! What can go wrong with a balance, and what has to be known of one that went well.

use crate::error::ParameterError;
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::orbit::FourierOrbit;
use crate::roots::root::RootError;
use thiserror::Error;

/// Why no orbit is returned.
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
    /// A value that cannot be used.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A guess of another model.
    #[error("the orbit has {found} coordinates: the model has {expected}")]
    Coordinates {
        /// Of the model.
        expected: usize,
        /// Of the orbit.
        found: usize,
    },
    /// Samples that cannot tell the orders apart.
    #[error("{samples} samples cannot hold order {highest}: at least {} are needed, and several times as many with contacts", (2 * highest + 1).max(16))]
    Samples {
        /// M.
        samples: usize,
        /// The highest order.
        highest: usize,
    },
    /// A way to integrate that this model does not offer.
    #[error(
        "{integrals:?} integrals are not to be had: closed ones need accelerations linear on held pieces and drives of few harmonics, \
             corrected samples need held pieces and no jumps of the drives, truncated forces need Sampled, linearised starts need held pieces; pieces are held by \
             Model::accel_on_pieces; Exact chooses what fits"
    )]
    NotOffered {
        /// What was asked for.
        integrals: Integrals,
    },
    /// A rigid stop: velocities that jump are no series. [`Shooting`](crate::Shooting) takes them.
    #[error(
        "contact {contact} has a rigid stop, at which velocities jump: a balance cannot hold it; use Shooting"
    )]
    RigidStop {
        /// Which contact.
        contact: usize,
    },
    /// A start with the teeth apart.
    #[error(
        "contact {contact} stays in its gap at the start: there nothing restores the mean, and every mean is as good as any other; \
             start on a flank, as Balance::linearised does"
    )]
    StartInGap {
        /// Which contact.
        contact: usize,
    },
    /// A model without a Jacobian, some motion of which is as good as free.
    #[error(
        "some motion is held by {share:.1e} of the largest stiffness: differences cannot tell whether it is free; offer Model::jacobian, which can"
    )]
    BarelyHeld {
        /// The stiffness found.
        share: f64,
    },
    /// A model whose slopes are no numbers.
    #[error(
        "the slope of acceleration {acceleration} in coordinate {coordinate}, or in its velocity, is not finite somewhere along the iterate \
         {} of the balance", last.iterations()
    )]
    Slope {
        /// Which acceleration.
        acceleration: usize,
        /// In which coordinate.
        coordinate: usize,
        /// The iterate.
        last: Box<FourierOrbit>,
        /// Largest residual of every iterate.
        history: Vec<f64>,
    },
    /// A coordinate that nothing holds.
    #[error("the balance leaves coordinate {coordinate} free after {} iterations: no stiffness reaches it", last.iterations())]
    Floating {
        /// Which coordinate.
        coordinate: usize,
        /// The iterate.
        last: Box<FourierOrbit>,
        /// Largest residual of every iterate.
        history: Vec<f64>,
    },
    /// No convergence.
    #[error(
        "the balance did not converge in {} iterations: the largest residual is {}; a guess projected from a settled motion may lead further, \
         over several periods if that repeats so",
        last.iterations(), last.residual()
    )]
    NotConverged {
        /// The last iterate, which is no orbit.
        last: Box<FourierOrbit>,
        /// Largest residual of every iterate, the guess first.
        history: Vec<f64>,
    },
    /// A model that gives no numbers.
    #[error("the balance met a value that is not finite after {} iterations", last.iterations())]
    NotFinite {
        /// The last good iterate, or the guess.
        last: Box<FourierOrbit>,
        /// Largest residual of every iterate.
        history: Vec<f64>,
    },
    /// An accuracy that was not reached.
    #[error("the accuracy {wanted} was not reached with orders up to {highest}: {reached} was{}", cause.as_ref().map_or(String::new(), |c| format!("; beyond, {c}")))]
    Accuracy {
        /// As a share of the peak-to-peak.
        wanted: f64,
        /// The estimate at the end.
        reached: f64,
        /// The highest order tried.
        highest: usize,
        /// The best orbit, which converged but is not as good as wanted.
        best: Box<FourierOrbit>,
        /// Why it could not be proved on more orders, if it was that.
        cause: Option<Box<BalanceError>>,
    },
    /// The budget of the call is spent, or it was cancelled.
    #[error("the balance stopped after {} iterations: {exhausted}", last.iterations())]
    Budget {
        /// Which limit.
        exhausted: crate::ode::budget::Exhausted,
        /// The last iterate, or the guess.
        last: Box<FourierOrbit>,
        /// Largest residual of every iterate.
        history: Vec<f64>,
    },
    /// Settings of the root finder.
    #[error(transparent)]
    Root(RootError),
}
