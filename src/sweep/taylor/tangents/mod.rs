//! The flow with its derivative in lanes: Lyapunov exponents and orbits.

pub(crate) mod by_shape;
pub(crate) mod exponents;
pub(crate) mod orbits;
pub(crate) mod tangent_task;
pub(crate) mod waiting;
