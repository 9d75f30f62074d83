//! Excitations: a constant, curves, samples, rectangles, closures, combinations of waves.

pub(crate) mod centre;
pub(crate) mod combine;
pub(crate) mod constant;
pub(crate) mod function;
pub(crate) mod rectangle;
pub(crate) mod table;
