//! A torque on a body.

use crate::excitation::Wave;
use crate::trains::parts::characteristic::Characteristic;

/// How a torque depends on the motion.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Course {
    Constant,
    /// A factor over the turn of the body.
    OfAngle(Wave),
    /// A factor over the speed of the body.
    OfSpeed(Characteristic),
}

/// A torque on a body along its rotation.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TorquePart {
    pub(crate) name: String,
    pub(crate) body: String,
    pub(crate) value: f64,
    pub(crate) course: Course,
}
