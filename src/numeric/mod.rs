//! Numerical tools that several rooms share.

pub(crate) mod bracket;
pub(crate) mod gauss;
pub(crate) mod norms;
pub(crate) mod spread;
