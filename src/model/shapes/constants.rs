//! The constants of a machine as parameters.

use crate::contact::Piece;
use crate::dual::Dual;
use crate::error::{ParameterError, check};
use crate::model::channel::Channel;
use crate::model::drive_slope::DriveSlope;
use crate::model::equations::{Constants, Model, Periodic};
use crate::model::shapes::dual_jacobian::slope_along;
use crate::model::shapes::machine::Machine;
use crate::model::shapes::shape::Shape;

/// Machines are equal if their shapes and their constants are equal.
impl<G: Shape> PartialEq for Machine<G> {
    fn eq(&self, other: &Self) -> bool {
        self.values() == other.values() && self.shares_lanes_with(other)
    }
}

impl<G: Shape> Machine<G> {
    /// The slot of a constant: its index among the drives, at which [`Noisy`](crate::drives::Noisy) and
    /// [`Driven`](crate::drives::Driven) add to it.
    ///
    /// # Errors
    /// A name that the shape does not have; a constant that [`Shape::prepare`] does not return unchanged;
    /// the speed of the angle, for which [`VaryingSpeed`](crate::drives::VaryingSpeed) is used.
    pub fn slot(&self, name: &str) -> Result<usize, ParameterError> {
        let index = self.index(name)?;
        let changed = |by: &Dual| by.slope[0] != 0.0;
        let prepared = self.shape().prepare(&self.along(index));
        let reached: Vec<usize> = (0..prepared.len()).filter(|&i| changed(&prepared[i])).collect();
        match reached[..] {
            // The speed (i = 0) is excluded: adding to its drive would not change the angle of the waves.
            [i] if i > 0 && prepared[i].slope[0] == 1.0 && prepared[i].value == self.values()[index] => {
                Ok(self.slot_of(i))
            }
            _ => Err(ParameterError::NotADrive { name: name.into() }),
        }
    }
    /// The index of a prepared constant among the drives.
    pub(crate) fn slot_of(&self, prepared: usize) -> usize {
        self.size().waves + if prepared == 0 { 0 } else { prepared + 1 }
    }

    /// The constants as dual numbers with the slope 1 at `index` and 0 elsewhere.
    pub(crate) fn along(&self, index: usize) -> Vec<Dual> {
        let slope = |i: usize| [if i == index { 1.0 } else { 0.0 }];
        self.values().iter().enumerate().map(|(i, &value)| Dual { value, slope: slope(i) }).collect()
    }

    /// ∂a/∂c for a constant c, at a fixed angle of the waves. It is exact, by dual numbers through
    /// [`Shape::prepare`].
    ///
    /// # Errors
    /// An unknown name; a wrong number of drives, coordinates or velocities.
    pub fn slope(&self, name: &str, u: &[f64], q: &[f64], v: &[f64]) -> Result<Vec<f64>, ParameterError> {
        let (index, dof) = (self.index(name)?, self.size().dof);
        check::length("drives", u.len(), self.drives())?;
        check::length("coordinates", q.len(), dof)?;
        check::length("velocities", v.len(), dof)?;
        let mut a = vec![0.0; dof];
        self.accel_along(&self.drive_slope(index).drives, None, u, q, v, &mut a);
        Ok(a)
    }
}

impl<G: Shape> Constants for Machine<G> {
    fn names(&self) -> &[Channel] {
        self.names()
    }
    fn values(&self) -> &[f64] {
        self.values()
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
