//! Derivatives of orbits, of what is measured on them, and of located points with respect to all constants.

pub(crate) mod along;
mod crossings;
pub(crate) mod derivatives;
pub(crate) mod figure;
pub(crate) mod observed;
pub(crate) mod point_slopes;
pub(crate) mod quantity;
pub(crate) mod sensitivity_of_orbit;
pub(crate) mod totals;
