//! What rows say together: attractors, bifurcation diagrams.

pub(crate) mod basins;
pub(crate) mod bifurcation;
