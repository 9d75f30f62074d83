//! Taylor coefficients of a recorded algebra, order by order.

pub(crate) mod aligned;
pub(crate) mod coefficients;
pub(crate) mod degrees;
pub(crate) mod dependence;
pub(crate) mod functions;
pub(crate) mod plan;
pub(crate) mod products;
pub(crate) mod rows;
pub(crate) mod steepness;
pub(crate) mod sums;
