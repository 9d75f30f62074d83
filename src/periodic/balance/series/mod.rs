//! Series and samples: orders, transforms, couplings, Jacobian.

pub(crate) mod assembly;
pub(crate) mod grid;
pub(crate) mod harmonics;
pub(crate) mod slope_series;
pub(crate) mod spectra;
pub(crate) mod transform;
