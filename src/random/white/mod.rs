//! White noise in lanes.

pub(crate) mod crossings;
pub(crate) mod error;
pub(crate) mod estimate;
pub(crate) mod long_run;
pub(crate) mod noise;
pub(crate) mod noisy_lanes;
pub(crate) mod normal;
pub(crate) mod solver;
pub(crate) mod statistics;
