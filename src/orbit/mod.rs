//! Periodic orbits by shooting, their stability, and the growth of small differences.

mod continued;
mod cycle;
mod cyclic;
mod directions;
mod exponents;
mod failure;
mod floquet;
mod growth;
mod guess;
mod lyapunov;
mod rebound;
mod rigid;
mod saltation;
mod segments;
mod shooting;
mod size;
mod tangent;
mod variation;

pub use cycle::ShootingOrbit;
pub use exponents::{Exponents, LyapunovError};
pub use failure::{Iterate, ShootingError};
pub use floquet::{Multipliers, Stability};
pub use lyapunov::Lyapunov;
pub(crate) use rigid::{rigid_modes, rigid_motions};
pub use shooting::Shooting;
pub(crate) use size::remove;
pub use variation::{Transition, Variation};
