//! Random models.

pub mod pair;
pub mod symmetric;
