//! Models that are ready.
//!
//! [`nfg`] is the pair of noncircular face gears of Liu 2021, [`ring`] the ring of gears of Yao 2020. An
//! [`Oscillator`] has one mass with a gap, a cubic spring and a harmonic force. All other gear trains are
//! stated by their parts: [`trains`](crate::trains).

pub mod nfg;
pub(crate) mod oscillator;
pub mod ring;

pub use crate::models::oscillator::{Oscillator, OscillatorShape};
