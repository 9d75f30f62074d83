//! The constants of a machine as parameters.

use crate::contact::Piece;
use crate::dual::Dual;
use crate::error::ParameterError;
use crate::model::channel::Channel;
use crate::model::drive_slope::DriveSlope;
use crate::model::equations::{Constants, Model, Periodic};
use crate::model::shapes::compiled::Compiled;
use crate::model::shapes::dual_jacobian::slope_along;
use crate::model::shapes::shape::Shape;

impl<G: Shape> Compiled<G> {
    /// The index of a prepared constant among the drives.
    pub(crate) fn slot_of(&self, prepared: usize) -> usize {
        self.size().waves + if prepared == 0 { 0 } else { prepared + 1 }
    }

    /// The constants as dual numbers with the slope 1 at `index` and 0 elsewhere.
    pub(crate) fn along(&self, index: usize) -> Vec<Dual> {
        let slope = |i: usize| [if i == index { 1.0 } else { 0.0 }];
        self.values().iter().enumerate().map(|(i, &value)| Dual { value, slope: slope(i) }).collect()
    }
}

impl<G: Shape> Constants for Compiled<G> {
    fn names(&self) -> &[Channel] {
        &self.fixed.names
    }
    fn values(&self) -> &[f64] {
        &self.constants
    }
    fn with_values(&self, values: &[(usize, f64)]) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        Ok(Box::new(self.with_indexed(values)?))
    }
    fn drive_slope(&self, i: usize) -> DriveSlope {
        let prepared: Vec<Dual> = self.shape().prepare(&self.along(i));
        let mut drives = vec![0.0; self.drives()];
        for (k, x) in prepared.iter().enumerate() {
            drives[self.slot_of(k)] = x.slope[0];
        }
        DriveSlope { drives, speed: prepared.first().map_or(0.0, |x| x.slope[0] / x.value) }
    }
    fn accel_along(
        &self,
        along: &[f64],
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        out: &mut [f64],
    ) {
        slope_along(self.shape(), along, pieces, u, q, v, out);
    }
}
