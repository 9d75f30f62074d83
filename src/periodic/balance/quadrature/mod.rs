//! Gauss panels, and how finely a model must be sampled.

pub(crate) mod at_rest;
pub(crate) mod panels;
pub(crate) mod pulses;
pub(crate) mod resolution;
