//! Checks of a model for inconsistencies between its parts.

pub(crate) mod contact_checks;
pub(crate) mod display;
pub(crate) mod drives;
pub(crate) mod inconsistency;
pub(crate) mod lines;
pub(crate) mod near_a_state;
pub(crate) mod offers;
pub(crate) mod point;
pub(crate) mod rates;
pub(crate) mod tolerances;

pub use crate::check::inconsistency::Inconsistency;
pub use crate::check::near_a_state::{check_model, check_periodic};
