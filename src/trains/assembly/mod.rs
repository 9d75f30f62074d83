//! Makes the shape of a train.

pub(crate) mod assemble;
pub(crate) mod balance;
pub(crate) mod checks;
pub(crate) mod links;
pub(crate) mod rotation;
pub(crate) mod rows;
pub(crate) mod torques;
