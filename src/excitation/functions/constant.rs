//! A constant excitation.

use crate::error::{ParameterError, check};
use crate::excitation::angle::Angle;
use crate::excitation::excitation_trait::Excitation;
use crate::excitation::jet::Jet;
use crate::excitation::wave::Wave;

/// A constant excitation.
///
/// ```
/// use gear_dynamics::excitation::{Constant, Excitation};
/// assert_eq!(Constant::new(2e8)?.value(1.0), 2e8);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constant(f64);

impl Constant {
    /// A constant within ±1e50.
    ///
    /// # Errors
    /// A value beyond ±1e50.
    pub fn new(value: f64) -> Result<Self, ParameterError> {
        Ok(Constant(check::quantity("constant excitation", value)?))
    }
}

impl Excitation for Constant {
    fn jet<A: Angle>(&self, _: A) -> Jet<A::Number> {
        Jet::constant(self.0.into())
    }
    fn fourier(&self) -> Option<(f64, Vec<[f64; 2]>)> {
        Some((self.0, Vec::new()))
    }
}

impl Wave {
    /// A constant wave.
    ///
    /// # Errors
    /// A value beyond ±1e50.
    pub fn constant(value: f64) -> Result<Self, ParameterError> {
        Ok(Wave::new(Constant::new(value)?))
    }
    /// The wave 0.
    pub(crate) fn zero() -> Self {
        Wave::new(Constant(0.0))
    }
}
