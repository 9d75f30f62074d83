//! Drawings of trains: bodies, places, links, motions.

use crate::trains::shape::elements::Entry;

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

/// The drawing of a shape. Shapes whose drawings differ are equal.
#[derive(Clone, Debug)]
pub(crate) struct Shown(pub(crate) Drawing);

impl PartialEq for Shown {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// A body of a [`Drawing`].
///
/// ```
/// # use gear_dynamics::trains::{Body, MeshPart, Parts};
/// # use gear_dynamics::Wave;
/// let mut parts = Parts::new();
/// parts.body("pinion", Body::new(2e-3)).body("wheel", Body::new(8e-3).centre([0.1, 0.0]));
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
    /// φ over its angle; `None` if it does not turn evenly.
    pub(crate) ratio: Option<f64>,
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
