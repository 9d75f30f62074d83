//! The noncircular face gear pair of Liu 2021.

pub(crate) mod pair;
pub(crate) mod pair2;
pub(crate) mod params;

pub use crate::models::nfg::pair::{NfgPair, NfgShape};
pub use crate::models::nfg::pair2::{NfgPair2, NfgShape2};
pub use crate::models::nfg::params::{
    CentreForcing, Damping, ErrorForcing, HalfWidth, NfgParams, NfgReading, Radius,
};
