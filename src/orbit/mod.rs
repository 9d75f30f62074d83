//! Periodic orbits by shooting, their stability, and the growth of small differences.

mod size;
mod tangent;
mod variation;

pub use variation::{Transition, Variation};
