//! The flow with its derivative.

pub(crate) mod continued;
pub(crate) mod motion_size;
pub(crate) mod rebound;
pub(crate) mod saltation;
pub(crate) mod tangent;
pub(crate) mod variation;
