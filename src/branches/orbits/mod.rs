//! Periodic orbits as points of a curve, and what is measured along them.

pub(crate) mod along_constant;
pub(crate) mod balance_curve;
pub(crate) mod balance_family;
pub(crate) mod balance_room;
pub(crate) mod balance_slope;
pub(crate) mod contact_trace;
pub(crate) mod differences;
pub(crate) mod measure;
pub(crate) mod nodes;
pub(crate) mod orbit_curve;
pub(crate) mod orbit_method;
pub(crate) mod series_measure;
