//! Derivatives of the drives with respect to a constant.

/// The derivative of the drives of a model with respect to a constant c, at a fixed phase of the period.
///
/// ```
/// use gear_dynamics::{Model, NfgPair, NfgParams};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let model: &dyn Model = &pair;
/// let slope = model.offers().constants.ok_or("constants")?.drive_slope(0); // the speed
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
