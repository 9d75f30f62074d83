//! Gauss panels, and how finely a model must be sampled.

pub(crate) mod at_rest;
pub(crate) mod gauss;
pub(crate) mod pulses;
pub(crate) mod resolution;
