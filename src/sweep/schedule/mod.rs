//! The schedule of a sweep: chunks, workers and the order of runs.

pub(crate) mod runner;
pub(crate) mod start;
pub(crate) mod worker;
