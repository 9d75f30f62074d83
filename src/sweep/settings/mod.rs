//! What is run: the points of a sweep and its settings.

pub(crate) mod points;
pub(crate) mod sweep;
