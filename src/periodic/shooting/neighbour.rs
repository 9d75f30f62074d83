//! Motions near an orbit, from which shooting starts.

use crate::error::ParameterError;
use crate::model::State;
use crate::periodic::balance::fourier_orbit::FourierOrbit;
use crate::periodic::shooting::shooting_orbit::ShootingOrbit;

/// A motion near an orbit, from which [`Shooting::solve_from`](crate::Shooting::solve_from) starts.
///
/// ```
/// use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams, Shooting, contact::Piece};
/// let at = |speed| NfgPair::new(&NfgParams { speed, ..NfgParams::table1() });
/// let series = Balance::new(Harmonics::up_to(40)).linearised(&at(90.0)?, Piece::Lower)?;
/// let orbit = Shooting::new().solve_from(&at(90.0)?, &series)?; // the equation itself
/// let next = Shooting::new().solve_from(&at(91.0)?, &orbit)?; // the neighbouring model
/// assert!(orbit.first_correction() < 0.1 && next.first_correction() < 0.01); // shares of the motion
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Neighbour {
    /// Number of periods of the drives in one period of the motion.
    fn period_multiple(&self) -> usize;
    /// Period of the motion.
    fn period(&self) -> f64;
    /// States at increasing times within one period.
    ///
    /// # Errors
    /// The motion has no states within the limits of memory.
    fn nodes(&self) -> Result<Vec<State>, ParameterError>;
}

impl Neighbour for ShootingOrbit {
    fn period_multiple(&self) -> usize {
        self.period_multiple()
    }
    fn period(&self) -> f64 {
        self.period()
    }
    fn nodes(&self) -> Result<Vec<State>, ParameterError> {
        Ok(self.states().to_vec())
    }
}

/// Number of orders per node.
const ORDERS: usize = 16;

/// Maximum number of nodes of a series.
const MAX_NODES: usize = 16;

impl Neighbour for FourierOrbit {
    fn period_multiple(&self) -> usize {
        self.harmonics().period_multiple()
    }
    fn period(&self) -> f64 {
        self.period()
    }
    fn nodes(&self) -> Result<Vec<State>, ParameterError> {
        self.states((self.harmonics().highest() / ORDERS).clamp(1, MAX_NODES))
    }
}
