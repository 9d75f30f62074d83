//! Excitations: series, curves, samples, closures and their combinations.

pub(crate) mod centre;
pub(crate) mod combine;
pub(crate) mod constant;
pub(crate) mod fourier;
pub(crate) mod rectangle;
pub(crate) mod table;
