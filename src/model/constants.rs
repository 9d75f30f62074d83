//! Named constants of a model, and the exact derivatives with respect to them.

use crate::contact::piece::Piece;
use crate::error::ParameterError;
use crate::model::equations::{Channel, Periodic};

/// The derivative of the drives of a model with respect to a constant c, at a fixed phase of the period.
///
/// ```
/// use gear_dynamics::{Model, NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let model: &dyn Model = &pair;
/// let slope = model.named_constants().ok_or("constants")?.drive_slope(0); // the speed
/// assert!((slope.speed - 0.01).abs() < 1e-16); // φ' is the speed: (∂φ'/∂c)/φ' = 1/100
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DriveSlope {
    /// ∂u/∂c at a fixed phase, one entry per drive. It is the same at every phase.
    pub drives: Vec<f64>,
    /// (∂φ'/∂c)/φ' = -(∂T/∂c)/T: relative change of the speed of the angle, with the period T.
    pub speed: f64,
}

impl DriveSlope {
    /// The slope with respect to c/unit.
    pub(crate) fn times(mut self, unit: f64) -> Self {
        self.drives.iter_mut().for_each(|slope| *slope *= unit);
        self.speed *= unit;
        self
    }
}

/// A model with named constants that act through its drives. A [`Machine`](crate::Machine) is one.
///
/// ```
/// use gear_dynamics::{Model, NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let model: &dyn Model = &pair;
/// let constants = model.named_constants().ok_or("constants")?;
/// let load = constants.place("load torque")?;
/// assert_eq!(constants.values()[load], pair.constant("load torque")?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Constants {
    /// Names and units.
    fn names(&self) -> &[Channel];
    /// Values, in the order of the names.
    fn values(&self) -> &[f64];
    /// The same model with other values of some constants: pairs of index and value.
    ///
    /// # Errors
    /// A value out of range.
    ///
    /// # Panics
    /// If a constant does not exist.
    fn with_values(&self, values: &[(usize, f64)]) -> Result<Box<dyn Periodic + '_>, ParameterError>;
    /// The derivative of the drives with respect to constant `i`, at a fixed phase.
    ///
    /// # Panics
    /// If there is no constant `i`.
    fn drive_slope(&self, i: usize) -> DriveSlope;
    /// Writes Σ_k ∂a/∂u_k w_k, with every contact on a given piece: the derivative of the accelerations along
    /// the change w = `along` of the drives.
    fn accel_along(
        &self,
        along: &[f64],
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        out: &mut [f64],
    );

    /// Index of the constant of this name.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchConstant`], which lists the names.
    fn place(&self, name: &str) -> Result<usize, ParameterError> {
        place_of(self.names(), name)
    }
}

/// Index of a name in a list of constants.
pub(crate) fn place_of(names: &[Channel], name: &str) -> Result<usize, ParameterError> {
    names.iter().position(|channel| channel.name == name).ok_or_else(|| {
        let known: Vec<&str> = names.iter().map(|channel| channel.name.as_str()).collect();
        ParameterError::NoSuchConstant { name: name.into(), known: known.join(", ") }
    })
}
