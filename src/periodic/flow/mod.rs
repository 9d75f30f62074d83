//! The flow and its derivative with respect to the start.

pub(crate) mod continued;
pub(crate) mod flow_method;
pub(crate) mod follow;
pub(crate) mod jumps;
pub(crate) mod rebound;
pub(crate) mod saltation;
pub(crate) mod tangent;
pub(crate) mod tangent_tape;
pub(crate) mod variation;
pub(crate) mod walk;
