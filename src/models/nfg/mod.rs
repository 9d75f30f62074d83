//! The noncircular face gear pair.

mod pair;
mod pair2;
mod params;

pub use pair::{NfgPair, NfgShape};
pub use pair2::{NfgPair2, NfgShape2};
pub use params::{CentreForcing, Damping, ErrorForcing, HalfWidth, NfgParams, NfgReading, Radius};
