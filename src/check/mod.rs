//! Checks of a model of one's own.
//!
//! [`check_model`] compares the methods of any model at a state: forces, edges, Jacobians.
//! [`check_periodic`] also compares drives one period apart. Each [`Inconsistency`] names the method, the
//! index and both values; an empty list means that no two methods contradict each other.

pub(crate) mod contacts;
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
