//! What follows from certificates: figures of an orbit, and orbits over a range of a constant.

pub(crate) mod course;
pub(crate) mod figures;
pub(crate) mod range;
