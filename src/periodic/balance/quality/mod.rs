//! How good an orbit is: proof, coarseness, multipliers.

pub(crate) mod coarseness;
pub(crate) mod multipliers_of_series;
pub(crate) mod proof;
