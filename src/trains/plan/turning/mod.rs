//! How the bodies turn: exact ratios, mean speeds, orders, uneven rotations.

pub(crate) mod fraction;
pub(crate) mod kinematics;
pub(crate) mod orders;
pub(crate) mod rotation;

/// Relative difference up to which radii and ratios of speeds count as equal.
pub(crate) const SAME: f64 = 1e-6;
