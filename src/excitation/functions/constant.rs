//! A constant excitation.

use crate::error::{ParameterError, check};
use crate::excitation::enclosed_angle::EnclosedAngle;
use crate::excitation::excitation_trait::{Excitation, same};
use crate::excitation::jet::Jet;
use crate::interval::number::Interval;
use crate::series::{PowerSeries, Series};

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
    /// The constant 0.
    pub(crate) fn zero() -> Self {
        Constant(0.0)
    }
    /// A constant within ±1e50.
    ///
    /// # Errors
    /// A value beyond ±1e50.
    pub fn new(value: f64) -> Result<Self, ParameterError> {
        Ok(Constant(check::quantity("constant excitation", value)?))
    }
}

impl Excitation for Constant {
    fn jet(&self, _: f64) -> Jet {
        Jet::constant(self.0)
    }
    fn series(&self, _: &Series) -> Jet<Series> {
        Jet::constant(self.0.into())
    }
    fn enclosure(&self, _: EnclosedAngle) -> Jet<PowerSeries<Interval>> {
        Jet::constant(self.0.into())
    }
    fn fourier(&self) -> Option<(f64, Vec<[f64; 2]>)> {
        Some((self.0, Vec::new()))
    }
    fn same_as(&self, other: &dyn Excitation) -> bool {
        same(self, other)
    }
}
