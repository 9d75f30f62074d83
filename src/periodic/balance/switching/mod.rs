//! When contacts change their piece along an orbit.

pub(crate) mod contacts;
pub(crate) mod instants;
pub(crate) mod stencil;
