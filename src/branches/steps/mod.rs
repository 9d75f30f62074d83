//! Steps along a curve, and the search within a step of a branch.

mod beside;
pub(crate) mod between;
pub(crate) mod grazings;
pub(crate) mod node;
pub(crate) mod of_orbits;
pub(crate) mod place;
pub(crate) mod stepper;
pub(crate) mod stops;
pub(crate) mod within;
