//! Lyapunov exponents.

pub(crate) mod directions;
pub(crate) mod exponents;
pub(crate) mod growth;
pub(crate) mod progress;
pub(crate) mod run;
