//! The periodic density of a model with periodic drives.

use crate::random::density::state_density::StateDensity;

/// The periodic density p(x, v, t) of a model with periodic drives, at the ends of the steps of a period.
///
/// ```
/// use gear_dynamics::models::Oscillator;
/// use gear_dynamics::random::PathIntegration;
/// let forced = [("speed", 2.0), ("damping", 1.0), ("linear stiffness", 1.0), ("force", 1.0)];
/// let density = PathIntegration::new(1.0, [-5.0, 5.0], [-5.0, 5.0])?
///     .panels(4)
///     .time_step(0.4)
///     .run(&Oscillator::new(&forced)?)?;
/// // The mean is the response without noise, Re exp(2it)/(1 - 4 + 2i): -3/13 at t = 0.
/// let start = density.at(0);
/// assert!((start.mean(|x, _| x) + 3.0 / 13.0).abs() < 0.02);
/// assert!(density.mean().mean(|x, _| x).abs() < 0.02);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodicDensity {
    pub(crate) times: Vec<f64>,
    pub(crate) instants: Vec<StateDensity>,
    pub(crate) mean: StateDensity,
}

impl PeriodicDensity {
    /// The instants of a period, from 0.
    pub fn times(&self) -> &[f64] {
        &self.times
    }
    /// The density at instant `i` of [`times`](PeriodicDensity::times).
    ///
    /// # Panics
    /// If there is no instant `i`.
    pub fn at(&self, i: usize) -> &StateDensity {
        &self.instants[i]
    }
    /// The mean density over the period: its shares are shares of time, its crossing rates mean rates.
    pub fn mean(&self) -> &StateDensity {
        &self.mean
    }
}
