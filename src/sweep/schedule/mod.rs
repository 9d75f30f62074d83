//! The schedule of a sweep: chunks, blocks of runs and their order.

pub(crate) mod block;
pub(crate) mod runner;
pub(crate) mod start;
