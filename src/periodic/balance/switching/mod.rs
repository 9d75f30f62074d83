//! Switches of the contacts along an orbit.

pub(crate) mod contacts;
pub(crate) mod instants;
pub(crate) mod stencil;
