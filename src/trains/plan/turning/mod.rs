//! How the bodies turn: exact ratios, mean speeds, orders, uneven rotations.

pub(crate) mod fraction;
pub(crate) mod kinematics;
pub(crate) mod orders;
pub(crate) mod rotation;
