//! Linear analysis of any model about a contact state.
//!
//! [`static_state`] finds where the model rests under its mean load, the usual start of a run. [`Modes`]
//! gives natural frequencies, shapes and damping; [`Campbell`] the speeds at which an order of excitation
//! meets a natural frequency ([`Resonance`]).

pub(crate) mod balanced;
pub(crate) mod campbell;
pub(crate) mod damped;
pub(crate) mod instants;
pub(crate) mod modes;
pub(crate) mod rank;
pub(crate) mod resolution;
pub(crate) mod spectrum;
pub(crate) mod statics;
pub(crate) mod symmetric;

pub use crate::linear::campbell::{Campbell, Resonance};
pub use crate::linear::modes::{DampedMode, LinearError, Mode, Modes};
pub use crate::linear::statics::{StaticState, static_state};
