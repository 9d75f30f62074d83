//! Linear analysis of any model about a contact state: modes, static deflection, speeds of resonance.

pub(crate) mod campbell;
pub(crate) mod modes;
pub(crate) mod statics;
pub(crate) mod symmetric;

pub use crate::linear::campbell::{Campbell, Resonance};
pub use crate::linear::modes::{DampedMode, LinearError, Mode, Modes};
pub use crate::linear::statics::{StaticState, static_state};
