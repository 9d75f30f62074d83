//! Multiple shooting.

pub(crate) mod closing;
pub(crate) mod cyclic;
pub(crate) mod failure;
pub(crate) mod guess;
pub(crate) mod iteration;
pub(crate) mod multiple;
pub(crate) mod neighbour;
pub(crate) mod recorded;
pub(crate) mod segments;
pub(crate) mod shooting_orbit;
