//! What is found out about any model: derivatives, couplings, rigid motions, sizes of its coordinates.

pub(crate) mod couplings;
pub(crate) mod drifts;
pub(crate) mod gaps;
mod level_rows;
pub(crate) mod no_model;
pub(crate) mod resting;
pub(crate) mod rigid;
mod singular;
pub(crate) mod sizing;
pub(crate) mod slopes;
