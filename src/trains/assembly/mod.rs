//! Checks the parts of a train and makes its shape.

pub(crate) mod assemble;
pub(crate) mod balance;
pub(crate) mod checks;
pub(crate) mod fraction;
pub(crate) mod kinematics;
pub(crate) mod links;
pub(crate) mod names;
pub(crate) mod orders;
pub(crate) mod phases;
pub(crate) mod places;
pub(crate) mod rotation;
pub(crate) mod rows;
pub(crate) mod torques;
pub(crate) mod train_error;
