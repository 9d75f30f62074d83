//! The constants of a machine as parameters.

use crate::contact::piece::Piece;
use crate::dual::Dual;
use crate::error::ParameterError;
use crate::model::drive_slope::DriveSlope;
use crate::model::dual_jacobian::slope_along;
use crate::model::equations::{Channel, Constants, Model, Periodic};
use crate::model::machine::Machine;
use crate::model::shape::Shape;

/// Machines are equal if their shapes and their constants are equal.
impl<G: Shape> PartialEq for Machine<G> {
    fn eq(&self, other: &Self) -> bool {
        self.constants() == other.constants() && self.shares_lanes_with(other)
    }
}

impl<G: Shape> Constants for Machine<G> {
    fn names(&self) -> &[Channel] {
        self.names()
    }
    fn values(&self) -> &[f64] {
        self.constants()
    }
    fn with_values(&self, values: &[(usize, f64)]) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        Ok(Box::new(self.with_places(values)?))
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
