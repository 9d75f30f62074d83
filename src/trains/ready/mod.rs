//! Gear trains that are ready to use.

pub(crate) mod chains;
pub(crate) mod nfg;
pub(crate) mod planetary;
pub(crate) mod ring;
pub(crate) mod spur_pair;
