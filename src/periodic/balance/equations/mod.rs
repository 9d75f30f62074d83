//! The equations of a balance and their Jacobian.

pub(crate) mod accelerating;
pub(crate) mod balance_equations;
pub(crate) mod rebinding;
pub(crate) mod resonance;
