//! Roots, maxima and jumps of functions of one variable; linear complementarity problems.

pub(crate) mod bracket;
pub(crate) mod brent;
pub(crate) mod complementarity;
pub(crate) mod extremes;
pub(crate) mod hermite;
pub(crate) mod jump;
pub(crate) mod parabola;
