//! The equations of harmonic balance as a curve.

pub(crate) mod along_constant;
pub(crate) mod balance_curve;
pub(crate) mod balance_room;
pub(crate) mod balance_slope;
pub(crate) mod method;
pub(crate) mod series_measure;
