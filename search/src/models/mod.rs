//! Random models.

pub mod pair;
pub mod symmetric;
pub mod two_stage;
