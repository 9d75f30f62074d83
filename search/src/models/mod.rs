//! Random models.

pub mod bodies;
pub mod chain;
pub mod curve;
pub mod driven;
pub mod flanks;
pub mod pair;
pub mod symmetric;
pub mod tones;
pub mod two_stage;
