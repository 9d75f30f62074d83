//! Mesh stiffness from the geometry of the teeth.

pub(crate) mod iso6336;
pub(crate) mod piecewise;
pub(crate) mod potential;
pub(crate) mod quadrature;
pub(crate) mod tooth;
