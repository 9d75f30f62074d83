//! The ways to integrate forces along an orbit.

pub(crate) mod at_rest;
pub(crate) mod closed;
pub(crate) mod gauss;
pub(crate) mod kinks;
pub(crate) mod panels;
pub(crate) mod pulses;
pub(crate) mod resolution;
pub(crate) mod truncated;
