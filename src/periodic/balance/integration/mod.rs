//! The ways of integrating accelerations along an orbit, one file each.

pub(crate) mod choice;
pub(crate) mod closed;
pub(crate) mod integration_trait;
pub(crate) mod jumps;
pub(crate) mod kinks;
pub(crate) mod panels;
pub(crate) mod sampled;
pub(crate) mod truncated;
