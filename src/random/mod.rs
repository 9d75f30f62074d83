//! Random loads: white noise, rare events, densities.
//!
//! - **Long runs under white noise** in lanes: [`LongRun`] of a model with [`WhiteNoise`] gives shares of
//!   time, impacts and moments, each an [`Estimate`] with its interval.
//! - **First passages and rare events**: [`FirstPassage`] and [`Splitting`].
//! - **Densities without sampling** of one degree of freedom: [`PathIntegration`] finds the stationary or the
//!   periodic density of deflection and velocity ([`StateDensity`]) with its error.
//! - **Moments of a linearised model**: [`LinearMoments`] solves for mean and covariance.

pub(crate) mod density;
pub(crate) mod linear_moments;
pub(crate) mod rare;
pub(crate) mod white;

pub use crate::random::density::density_error::DensityError;
pub use crate::random::density::path_integration::PathIntegration;
pub use crate::random::density::periodic_density::PeriodicDensity;
pub use crate::random::density::state_density::StateDensity;
pub use crate::random::linear_moments::LinearMoments;
pub use crate::random::rare::passage::{FirstPassage, PassageTimes};
pub use crate::random::rare::score::{Event, StepEnd};
pub use crate::random::rare::splitting::{RareEvent, Splitting};
pub use crate::random::white::error::NoiseError;
pub use crate::random::white::estimate::Estimate;
pub use crate::random::white::long_run::LongRun;
pub use crate::random::white::noise::WhiteNoise;
pub use crate::random::white::solver::NoisySteps;
pub use crate::random::white::statistics::{ContactEstimates, NoiseStatistics};
