//! Curves of periodic orbits: by shooting, by balance, and what is measured along them.

pub(crate) mod by_balance;
pub(crate) mod by_shooting;
pub(crate) mod contact_trace;
pub(crate) mod measured;
pub(crate) mod orbit_method;
pub(crate) mod sorted_extremes;
pub(crate) mod symmetries;
pub(crate) mod widths;
pub(crate) mod without_stops;
