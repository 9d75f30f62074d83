//! The checks of contacts at their edges.

pub(crate) mod contact_checks;
pub(crate) mod deflection_line;
