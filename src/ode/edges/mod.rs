//! Location of edges and of rigid stops inside a step.

pub(crate) mod arrival;
pub(crate) mod collisions;
pub(crate) mod exit;
pub(crate) mod first_root;
pub(crate) mod gaps;
pub(crate) mod locate;
pub(crate) mod passage;
pub(crate) mod sliding;
pub(crate) mod stops;
pub(crate) mod strike;
