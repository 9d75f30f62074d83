//! Engines: the ways in which the runs of a sweep are made.

pub(crate) mod batch;
pub(crate) mod lane_rk4;
pub(crate) mod located;
pub(crate) mod periods;
pub(crate) mod sweep_engine;
pub(crate) mod table_rk4;
pub(crate) mod track;
