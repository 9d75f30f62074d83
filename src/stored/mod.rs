//! Serialisation by `serde` of types whose parts must fit together: a stored form, checked when it is read.

pub(crate) mod fourier_orbit;
pub(crate) mod number;
pub(crate) mod points;
pub(crate) mod rows;
pub(crate) mod shooting_orbit;
