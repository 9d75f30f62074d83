//! Gear models.

pub mod nfg;
pub mod ring;
