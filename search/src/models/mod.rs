//! Random models.

pub mod chain;
pub mod pair;
pub mod symmetric;
pub mod two_stage;
