//! The points and the settings of a sweep.

pub(crate) mod points;
pub(crate) mod sweep;
