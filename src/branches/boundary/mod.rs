//! Curves of bifurcations and onsets in the plane of two parameters.

pub(crate) mod boundary_curve;
pub(crate) mod boundary_line;
pub(crate) mod grazed_stops;
pub(crate) mod half_orbit;
pub(crate) mod slice;
pub(crate) mod steps;
