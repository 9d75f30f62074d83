//! The equations of multiple shooting as a curve.

mod differences;
pub(crate) mod measure;
mod method;
mod nodes;
pub(crate) mod orbit_curve;
