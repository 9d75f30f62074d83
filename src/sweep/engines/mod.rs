//! The engines, which make the runs of a sweep.

pub(crate) mod fixed_step;
pub(crate) mod interface;
pub(crate) mod located;
pub(crate) mod track;
