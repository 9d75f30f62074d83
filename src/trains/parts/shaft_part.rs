//! Shafts and couplings.

use crate::contact::Backlash;

/// A shaft or coupling between two bodies: a torsional spring k [N m/rad], by default without damping and
/// without clearance.
///
/// ```
/// use gear_dynamics::trains::{Body, Parts, ShaftPart};
/// use gear_dynamics::linear::Modes;
/// let mut parts = Parts::new();
/// parts.body("motor", Body::new(0.02)).body("load", Body::new(0.02));
/// parts.shaft("shaft", "motor", "load", ShaftPart::new(1e4).damping(0.1)); // N m/rad, N m s/rad
/// let modes = Modes::in_contact(&parts.build("motor", 100.0)?, 0.0)?;
/// let fastest = modes.frequencies().into_iter().fold(0.0, f64::max);
/// assert!((fastest - 1000.0).abs() < 0.01); // √(2 k/J)
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct ShaftPart<N = Backlash> {
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
    /// Half of the clearance `[rad]`, and the law of the contact.
    pub(crate) clearance: Option<(f64, N)>,
}

impl<N> ShaftPart<N> {
    /// A shaft with the stiffness k [N m/rad].
    pub fn new(stiffness: f64) -> Self {
        ShaftPart { stiffness, damping: 0.0, clearance: None }
    }
    /// Damping c [N m s/rad]. Default: 0.
    pub fn damping(self, damping: f64) -> Self {
        ShaftPart { damping, ..self }
    }
}

impl ShaftPart {
    /// Half of the clearance `[rad]`: the shaft carries no torque while the angle between its ends is within
    /// ± this angle. Default: none.
    pub fn half_clearance(self, half_clearance: f64) -> Self {
        ShaftPart { clearance: Some((half_clearance, Backlash::none())), ..self }
    }
}
