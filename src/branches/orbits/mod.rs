//! Periodic orbits as points of a curve, and what is measured along them.

pub(crate) mod contact_trace;
pub(crate) mod differences;
pub(crate) mod measure;
pub(crate) mod orbit_curve;
pub(crate) mod orbit_method;
