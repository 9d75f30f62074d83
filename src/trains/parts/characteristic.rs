//! Torques over the speed.

use crate::scalar::Scalar;

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
