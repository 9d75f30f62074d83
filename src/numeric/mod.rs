//! Numerical tools that several modules use.

pub(crate) mod chi_square;
pub(crate) mod differences;
pub(crate) mod equations;
pub(crate) mod gauss;
pub(crate) mod lagrange;
pub(crate) mod moments;
pub(crate) mod norms;
#[cfg(feature = "serde")]
pub(crate) mod not_finite;
pub(crate) mod search;
pub(crate) mod sine;
pub(crate) mod split_mix;
pub(crate) mod spread;
