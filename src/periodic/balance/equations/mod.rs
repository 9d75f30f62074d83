//! The equations of a balance and their Jacobian.

pub(crate) mod metered;
pub(crate) mod residual;
