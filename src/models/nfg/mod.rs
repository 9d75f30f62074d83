//! The noncircular face gear pair.

mod pair;
mod pair2;
mod params;

pub use pair::NfgPair;
pub use pair2::NfgPair2;
pub use params::{CentreForcing, Damping, ErrorForcing, HalfWidth, NfgParams, NfgReading, Radius};
