//! Accuracy and stability of an orbit: coarseness, multipliers.

pub(crate) mod coarseness;
pub(crate) mod collocation;
pub(crate) mod multipliers_of_series;
pub(crate) mod notes;
pub(crate) mod series_flow;
