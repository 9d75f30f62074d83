//! Roots and maxima of functions of one variable.

pub(crate) mod bracket;
pub(crate) mod brent;
pub(crate) mod extremes;
pub(crate) mod hermite;
pub(crate) mod parabola;
