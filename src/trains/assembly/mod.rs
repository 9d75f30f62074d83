//! Makes the shape of a train.

pub(crate) mod assemble;
pub(crate) mod builder;
pub(crate) mod drawn;
pub(crate) mod links;
pub(crate) mod planet_sets;
pub(crate) mod rotating;
pub(crate) mod rows;
pub(crate) mod torques;
