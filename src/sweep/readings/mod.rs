//! Evaluation of all rows of a sweep: attractors and bifurcation diagrams.

pub(crate) mod basins;
pub(crate) mod bifurcation;
