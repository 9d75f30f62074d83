//! The equations of multiple shooting as a curve.

mod differences;
mod method;
mod nodes;
pub(crate) mod orbit_curve;
