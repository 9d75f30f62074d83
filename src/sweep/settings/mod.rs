//! The points of a sweep: axes, grids, lists, random parameters.

pub(crate) mod points;
pub(crate) mod sobol;
