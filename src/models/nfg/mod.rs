//! The noncircular face gear pair of Liu 2021.

pub(crate) mod constants;
pub(crate) mod face_gear;
pub(crate) mod nfg_params;
pub(crate) mod nfg_shape;
pub(crate) mod pair;
pub(crate) mod pair2;

pub use crate::models::nfg::nfg_params::{
    CentreForcing, Damping, ErrorForcing, HalfBacklash, NfgParams, NfgReading, Radius,
};
pub use crate::models::nfg::nfg_shape::NfgShape;
pub use crate::models::nfg::pair::NfgPair;
pub use crate::models::nfg::pair2::{NfgPair2, NfgShape2};
