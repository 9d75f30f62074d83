//! Design by derivatives: least figures of an orbit, and fits of constants to a measured response.

pub(crate) mod fit;
pub(crate) mod least;
pub(crate) mod objective;
pub(crate) mod orbit_finder;
pub(crate) mod search;
