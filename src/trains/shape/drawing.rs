//! Drawings of trains: bodies, places, links, motions.

use crate::contact::Nonlinearity;
use crate::error::{ParameterError, check};
use crate::trains::shape::elements::Entry;
use crate::trains::shape::train_shape::Train;

/// What a drawing of a train shows: its bodies at their places, and what joins them.
///
/// ```
/// # use gear_dynamics::trains::{Body, MeshPart, Parts};
/// # use gear_dynamics::Wave;
/// let mut parts = Parts::new();
/// parts.body("pinion", Body::new(2e-3)).body("wheel", Body::new(8e-3));
/// parts.mesh("mesh", "pinion", "wheel", MeshPart::external([20, 40], [0.03, 0.06], Wave::constant(2e8)?));
/// let train = parts.build("pinion", 100.0)?;
/// let drawing = train.shape().drawing();
/// assert_eq!(drawing.bodies[1].name, "wheel");
/// assert!((drawing.links[0].distance.ok_or("a mesh")? - 0.09 / 20f64.to_radians().cos()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// The bodies, in the order of their statement.
    pub bodies: Vec<DrawnBody>,
    /// Meshes, then shafts.
    pub links: Vec<DrawnLink>,
}

/// A body of a [`Drawing`].
///
/// ```
/// # use gear_dynamics::trains::{Body, MeshPart, Parts};
/// # use gear_dynamics::Wave;
/// let mut parts = Parts::new();
/// parts.body("pinion", Body::new(2e-3)).body("wheel", Body::new(8e-3).at([0.1, 0.0]));
/// parts.mesh("mesh", "pinion", "wheel", MeshPart::external([20, 40], [0.03, 0.06], Wave::constant(2e8)?));
/// let train = parts.build("pinion", 100.0)?;
/// let wheel = &train.shape().drawing().bodies[1];
/// assert_eq!((wheel.centre, wheel.internal, wheel.carrier), (Some([0.1, 0.0]), false, None));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnBody {
    /// Name.
    pub name: String,
    /// Centre `[m]`; `None`: not stated, and not given by a carrier.
    pub centre: Option<[f64; 2]>,
    /// Radius of its largest pitch circle `[m]`; 0 for a body without teeth.
    pub radius: f64,
    /// Whether its teeth point inwards.
    pub internal: bool,
    /// Index of the carrier of a planet.
    pub carrier: Option<usize>,
    /// Counterclockwise angle, x and y of the centre, as sums over the inertial coordinates.
    pub(crate) motion: [Vec<Entry>; 3],
}

/// A mesh or a shaft between two bodies of a [`Drawing`].
///
/// ```
/// let shaft = gear_dynamics::trains::DrawnLink { ends: [0, 1], distance: None };
/// assert_eq!(shaft.distance, None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnLink {
    /// Indices of the bodies.
    pub ends: [usize; 2],
    /// Centre distance of a mesh `[m]`; `None` for a shaft.
    pub distance: Option<f64>,
}

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
        Ok(shape.drawing.bodies.iter().map(|body| body.motion.each_ref().map(of)).collect())
    }
}
