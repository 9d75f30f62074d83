//! Gauss quadrature on panels, and the number of samples and panels that a model requires.

pub(crate) mod at_rest;
pub(crate) mod panel_points;
pub(crate) mod pulses;
pub(crate) mod resolution;
