//! Engines: the ways in which the runs of a sweep are made.

pub(crate) mod fixed_step;
pub(crate) mod interface;
pub(crate) mod located;
pub(crate) mod track;
