//! The noncircular face gear pair of Liu 2021.

pub(crate) mod pair;
pub(crate) mod pair2;
pub(crate) mod params;
pub(crate) mod shape;

pub use crate::models::nfg::pair::NfgPair;
pub use crate::models::nfg::pair2::{NfgPair2, NfgShape2};
pub use crate::models::nfg::params::{
    CentreForcing, Damping, ErrorForcing, HalfWidth, NfgParams, NfgReading, Radius,
};
pub use crate::models::nfg::shape::NfgShape;
