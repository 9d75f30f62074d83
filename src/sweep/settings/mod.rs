//! What is swept: axes, grids, random parameters.

pub(crate) mod points;
pub(crate) mod sobol;
