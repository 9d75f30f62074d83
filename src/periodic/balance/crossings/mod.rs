//! Crossings of the contacts along an orbit.

pub(crate) mod contact_history;
pub(crate) mod instants;
pub(crate) mod stencil;
