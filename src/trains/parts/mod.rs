//! The parts of a train.

pub(crate) mod body;
pub(crate) mod characteristic;
pub(crate) mod collection;
pub(crate) mod coordinates;
pub(crate) mod mesh_part;
pub(crate) mod shaft_part;
pub(crate) mod torque_part;
