//! The equations of harmonic balance as a curve.

pub(crate) mod along_constant;
pub(crate) mod balance_curve;
pub(crate) mod balance_slope;
pub(crate) mod equations_over;
pub(crate) mod method;
pub(crate) mod series_measure;
