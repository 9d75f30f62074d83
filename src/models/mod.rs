//! Gear models.

pub mod nfg;
pub(crate) mod oscillator;
pub mod ring;

pub use crate::models::oscillator::{Oscillator, OscillatorShape};
