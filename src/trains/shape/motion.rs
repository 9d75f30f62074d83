//! Motions of the bodies of a train.

use crate::contact::Nonlinearity;
use crate::error::{ParameterError, check};
use crate::trains::shape::elements::Entry;
use crate::trains::shape::train_shape::Train;

impl<N: Nonlinearity> Train<N> {
    /// Angle `[rad]` and displacement of the centre along x and y `[m]` of each body, from coordinates or
    /// from the [shape of a mode](crate::linear::Mode::shape). Angles are counterclockwise, also of a body
    /// that turns clockwise. A locked body does not turn. The centre of a body without bearing moves only
    /// if it is the pin of a carrier.
    ///
    /// ```
    /// use gear_dynamics::trains::SpurPair;
    /// let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[])?.parts()?.build("driver", 0.6)?;
    /// let [driver, driven] = [0, 1].map(|body| pair.motion(&[1.0]).map(|bodies| bodies[body][0]));
    /// assert!(driver? * driven? > 0.0); // the meshing gears turn against each other: both flanks press
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`ParameterError::Length`] for another number of coordinates.
    pub fn motion(&self, q: &[f64]) -> Result<Vec<[f64; 3]>, ParameterError> {
        let shape = self.shape();
        check::length("coordinates of the motion", shape.coordinates.len(), q.len())?;
        let q = shape.in_inertial(q);
        let of = |row: &Vec<Entry>| row.iter().map(|entry| entry.by * q[entry.at]).sum();
        Ok(shape.drawing().bodies.iter().map(|body| body.motion.each_ref().map(of)).collect())
    }
}
