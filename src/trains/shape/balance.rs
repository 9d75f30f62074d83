//! Whether the torques of a train balance.

use crate::error::ParameterError;

/// Power of the torques in the rigid motion, as a share of that of all of them, above which they do not balance.
const BALANCED: f64 = 1e-6;

/// The power of constant torques in the rigid motion of a train that turns freely.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Balance {
    /// Power of a unit of each torque, over the speed of the reference body.
    pub(crate) powers: Vec<f64>,
    /// Inertia of all bodies, seen from the reference body [kg m²].
    pub(crate) inertia: f64,
}

impl Balance {
    /// Whether the torques balance.
    ///
    /// # Errors
    /// [`ParameterError::Unbalanced`].
    pub(crate) fn check(&self, torques: &[f64]) -> Result<(), ParameterError> {
        let (mut power, mut size) = (0.0, 0.0f64);
        for (of, torque) in self.powers.iter().zip(torques) {
            (power, size) = (power + of * torque, size + (of * torque).abs());
        }
        if power.abs() <= BALANCED * size {
            return Ok(());
        }
        Err(ParameterError::Unbalanced { acceleration: power / self.inertia })
    }
}
