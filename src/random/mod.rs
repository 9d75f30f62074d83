//! Random loads: white noise, densities.
//!
//! - **Densities without sampling** of one degree of freedom under white noise: [`PathIntegration`] finds the
//!   stationary or the periodic density of deflection and velocity ([`StateDensity`]) with its error.

pub(crate) mod density;

pub use crate::random::density::density_error::DensityError;
pub use crate::random::density::path_integration::PathIntegration;
pub use crate::random::density::periodic_density::PeriodicDensity;
pub use crate::random::density::state_density::StateDensity;
