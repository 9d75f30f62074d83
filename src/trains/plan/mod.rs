//! What follows from the parts alone: places of the names, mean speeds, centres, phases and orders.

pub(crate) mod fraction;
pub(crate) mod kinematics;
pub(crate) mod names;
pub(crate) mod orders;
pub(crate) mod phases;
pub(crate) mod places;
