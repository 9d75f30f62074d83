//! Intervals: numbers with proven bounds.

pub(crate) mod functions;
pub(crate) mod number;
