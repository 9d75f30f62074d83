//! Bodies of a train and their bearings.

/// A bearing: mass, stiffness, damping and radial clearance in two directions.
///
/// ```
/// use gear_dynamics::trains::Bearing;
/// let bearing = Bearing::new(2.0, 1e8).damping(300.0).half_clearance(2e-5);
/// assert_eq!(bearing.stiffness, [1e8, 1e8]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct Bearing {
    /// Mass of the body `[kg]`.
    pub mass: f64,
    /// Stiffness along x and y [N/m], not negative.
    pub stiffness: [f64; 2],
    /// Damping along x and y [N s/m], not negative.
    pub damping: [f64; 2],
    /// Half of the radial clearance `[m]`: the distance from the centre at which the bearing carries. With a
    /// clearance, both stiffnesses must be equal.
    pub half_clearance: f64,
    /// Whether the body moves along y alone, for example along a line of action.
    pub along_y: bool,
}

impl Bearing {
    /// A bearing of equal stiffness in all directions, without damping and clearance, for a body of mass
    /// `mass`.
    pub fn new(mass: f64, stiffness: f64) -> Self {
        Bearing { mass, stiffness: [stiffness; 2], damping: [0.0; 2], half_clearance: 0.0, along_y: false }
    }
    /// The same bearing with a damping [N s/m] in all directions.
    pub fn damping(self, damping: f64) -> Self {
        Bearing { damping: [damping; 2], ..self }
    }
    /// The same bearing for a body that moves along y alone. With centres on the x axis and the pressure
    /// angle 0, y is the line of action.
    pub fn along_y(self) -> Self {
        Bearing { along_y: true, ..self }
    }
    /// The same bearing with half a radial clearance: it carries when the centre is farther than this `[m]`
    /// from its place.
    pub fn half_clearance(self, half_clearance: f64) -> Self {
        Bearing { half_clearance, ..self }
    }
}

/// The place of a planet on its carrier.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Place {
    pub(crate) carrier: String,
    /// Angle on the carrier `[rad]`, counterclockwise from x.
    pub(crate) angle: f64,
}

/// A body of a train: a gear, a motor, a load or a carrier.
///
/// Its coordinate is the angle along its own mean rotation. With a [`Bearing`] it also has x and y.
///
/// ```
/// use gear_dynamics::trains::{Bearing, Body};
/// let sun = Body::new(3.9e-4).bearing(Bearing::new(0.4, 1e8));
/// assert_eq!(sun.inertia(), 3.9e-4);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct Body {
    pub(crate) inertia: f64,
    pub(crate) bearing: Option<Bearing>,
    /// Centre `[m]`; `None`: at the origin, or at the centre of the carrier.
    pub(crate) centre: Option<[f64; 2]>,
    pub(crate) place: Option<Place>,
    /// Radius of the centre of a planet `[m]`; `None`: from its first mesh with a central gear.
    pub(crate) radius: Option<f64>,
    /// Whether it takes no part in the mean rotation.
    pub(crate) grounded: bool,
    /// Whether it has no angle among the coordinates: locked, or, if not grounded, prescribed.
    pub(crate) locked: bool,
    /// Torsional stiffness and damping to the ground.
    pub(crate) support: [f64; 2],
    pub(crate) drag: f64,
}

impl Body {
    /// A body that turns, with the moment of inertia J [kg m²].
    pub fn new(inertia: f64) -> Self {
        Body {
            inertia,
            bearing: None,
            centre: None,
            place: None,
            radius: None,
            grounded: false,
            locked: false,
            support: [0.0; 2],
            drag: 0.0,
        }
    }
    /// The same body on a bearing. The bearing of a planet connects it to its carrier.
    pub fn bearing(self, bearing: Bearing) -> Self {
        Body { bearing: Some(bearing), ..self }
    }
    /// The same body with its centre at x and y `[m]`. Only directions between centres matter.
    pub fn centre(self, centre: [f64; 2]) -> Self {
        Body { centre: Some(centre), ..self }
    }
    /// A planet on a carrier at the given angle `[rad]`. The radius of its centre follows from its meshes.
    ///
    /// Without a bearing the planet is fixed to the carrier and turns about its pin.
    pub fn carried_by(self, carrier: impl Into<String>, angle: f64) -> Self {
        Body { place: Some(Place { carrier: carrier.into(), angle }), ..self }
    }
    /// The same planet with the radius `[m]` of its centre on the carrier. A body that no carrier carries
    /// is refused with a radius
    /// ([`TrainError::RadiusWithoutCarrier`](crate::trains::TrainError::RadiusWithoutCarrier)).
    pub fn radius(self, radius: f64) -> Self {
        Body { radius: Some(radius), ..self }
    }
    /// The same body with a prescribed rotation: it turns exactly along its ideal rotation and has no angle
    /// among the coordinates. For example a shaft that an engine with a flywheel turns, also at a varying
    /// speed ([`SpeedLaw`](crate::drives::SpeedLaw)). It then drives the train, whichever body is the
    /// reference. Its inertia has no effect; a torque, a drag or a support has none either and is refused.
    pub fn prescribed(self) -> Self {
        Body { locked: true, grounded: false, ..self }
    }
    /// The same body held by a torsional spring [N m/rad] and damper [N m s/rad] to the ground. It does not
    /// take part in the mean rotation.
    pub fn grounded(self, stiffness: f64, damping: f64) -> Self {
        Body { grounded: true, ..self.restrained(stiffness, damping) }
    }
    /// The same body locked: it does not turn at all and has no angle among the coordinates.
    pub fn locked(self) -> Self {
        Body { grounded: true, locked: true, ..self }
    }
    /// The same body with a torsional spring [N m/rad] and damper [N m s/rad] on the deviation from its
    /// kinematic rotation.
    pub fn restrained(self, stiffness: f64, damping: f64) -> Self {
        Body { support: [stiffness, damping], ..self }
    }
    /// The same body with a drag torque -c q' [N m] on the deviation from its kinematic speed: the slope of a
    /// motor or load characteristic. c in [N m s/rad].
    pub fn drag(self, drag: f64) -> Self {
        Body { drag, ..self }
    }
    /// Whether its rotation is prescribed.
    pub(crate) fn is_prescribed(&self) -> bool {
        self.locked && !self.grounded
    }
    /// Moment of inertia J [kg m²].
    pub fn inertia(&self) -> f64 {
        self.inertia
    }
}
