//! Excitations: series, curves, samples.

pub(crate) mod constant;
pub(crate) mod fourier;
pub(crate) mod rectangle;
pub(crate) mod table;
