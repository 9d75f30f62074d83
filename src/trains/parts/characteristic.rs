//! Torques over the speed.

use crate::scalar::Scalar;

/// An induction motor by Kloss's equation: the torque 2 T s s_k/(s² + s_k²) at the speed Ω, with the slip
/// s = 1 - Ω/Ω_s.
///
/// ```
/// use gear_dynamics::trains::{Body, InductionMotor, Parts};
/// use gear_dynamics::{Integrator, State, Taylor};
/// let motor = InductionMotor { breakdown_torque: 40.0, breakdown_slip: 0.2, synchronous_speed: 100.0 };
/// let mut parts = Parts::new();
/// parts.body("rotor", Body::new(0.5)).motor("torque", "rotor", motor);
/// // From 90 rad/s, s = 0.1, the torque is 32 N m.
/// let end = Taylor::new().end(&parts.build("rotor", 90.0)?, &State::at_rest(1), 1e-4)?;
/// assert!((end.v[0] / 1e-4 - 32.0 / 0.5).abs() < 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InductionMotor {
    /// Breakdown torque T [N m].
    pub breakdown_torque: f64,
    /// Breakdown slip s_k `[1]`.
    pub breakdown_slip: f64,
    /// Synchronous speed Ω_s `[rad/s]`.
    pub synchronous_speed: f64,
}

/// A torque over the speed Ω, as a share of its constant.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Characteristic {
    /// An induction motor by Kloss's equation: 2 s s_k/(s² + s_k²), s = 1 - Ω/Ω_s.
    Induction { breakdown_slip: f64, synchronous: f64 },
    /// Σ c_k Ω^k.
    Polynomial(Vec<f64>),
}

impl Characteristic {
    #[inline(always)]
    pub(crate) fn at<S: Scalar>(&self, speed: S) -> S {
        match self {
            Characteristic::Induction { breakdown_slip, synchronous } => {
                let slip = S::from(1.0) - speed * (1.0 / synchronous);
                let most = slip * slip + S::from(breakdown_slip * breakdown_slip);
                slip * (2.0 * breakdown_slip) / most
            }
            Characteristic::Polynomial(coefficients) => {
                coefficients.iter().rev().fold(S::from(0.0), |sum, c| sum * speed + S::from(*c))
            }
        }
    }
}
