//! The steps of a density: its motion backwards in time, the random kick, their order.

pub(crate) mod arrivals;
pub(crate) mod kick;
pub(crate) mod reversed;
pub(crate) mod schedule;
