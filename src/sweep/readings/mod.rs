//! Evaluation of all rows of a sweep: attractors, bifurcation diagrams.

pub(crate) mod basins;
pub(crate) mod bifurcation;
