//! The parts of a train, as they are stated.

use crate::contact::Backlash;
use crate::excitation::Wave;
use crate::trains::parts::body::Body;
use crate::trains::parts::characteristic::{Characteristic, InductionMotor};
use crate::trains::parts::coordinates::Coordinates;
use crate::trains::parts::mesh_part::MeshPart;
use crate::trains::parts::shaft_part::ShaftPart;
use crate::trains::parts::torque_part::{Course, TorquePart};
use crate::trains::train_error::{TrainError, Warning};

/// A shaft with its name and the bodies that it joins.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct JoinedShaft<N> {
    pub(crate) name: String,
    pub(crate) ends: [String; 2],
    pub(crate) part: ShaftPart<N>,
}

/// The frame of the displacements, which rotates with a carrier.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RotatingFrame {
    pub(crate) carrier: String,
    /// Whether the planets have their centrifugal forces and preloads.
    pub(crate) preloaded: bool,
}

/// The parts of a gear train: bodies, shafts, meshes and torques, each with a name.
///
/// [`build`](Parts::build) checks them all and makes the model. The order of the statements is free.
///
/// ```
/// use gear_dynamics::trains::{Body, MeshPart, Parts, ShaftPart};
/// use gear_dynamics::{Dop853, Integrator, Model, State, Wave};
/// let mut parts = Parts::new();
/// parts.body("motor", Body::new(5e-2)).body("pinion", Body::new(2e-3)).body("wheel", Body::new(8e-3));
/// parts.shaft("input shaft", "motor", "pinion", ShaftPart::new(5e3).damping(0.5));
/// parts.mesh(
///     "mesh",
///     "pinion",
///     "wheel",
///     MeshPart::external([20, 40], [0.03, 0.06], Wave::constant(2e8)?).half_backlash(5e-5).damping(900.0),
/// );
/// parts.torque("drive torque", "motor", 30.0).load("wheel"); // -60 N m
/// let train = parts.build("motor", 100.0)?;
/// let end = Dop853::new().end(&train, &State::at_rest(train.dof()), 1e-2)?;
/// let heavier = train.with("drive torque", 35.0)?; // shares lanes with `train`
/// assert!(end.q[0].is_finite() && heavier.shares_lanes_with(&train));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Parts<N = Backlash> {
    pub(crate) bodies: Vec<(String, Body)>,
    pub(crate) shafts: Vec<JoinedShaft<N>>,
    pub(crate) meshes: Vec<(String, [String; 2], MeshPart<N>)>,
    pub(crate) torques: Vec<TorquePart>,
    /// The body on which a torque balances all others. More than one is an error of `build`.
    pub(crate) loads: Vec<String>,
    pub(crate) coordinates: Option<Coordinates>,
    pub(crate) rotating: Option<RotatingFrame>,
    pub(crate) accepted: Vec<Warning>,
    pub(crate) without_units: bool,
    /// What is wrong with a ready train, before its parts are checked: an error of `build`.
    pub(crate) fault: Option<TrainError>,
}

impl<N> Default for Parts<N> {
    fn default() -> Self {
        Parts {
            bodies: Vec::new(),
            shafts: Vec::new(),
            meshes: Vec::new(),
            torques: Vec::new(),
            loads: Vec::new(),
            coordinates: None,
            rotating: None,
            accepted: Vec::new(),
            without_units: false,
            fault: None,
        }
    }
}

impl Parts {
    /// No parts yet, for meshes with a [`Backlash`]. For another contact law: `Parts::<Law>::default()`.
    pub fn new() -> Self {
        Parts::default()
    }
}

impl<N> Parts<N> {
    /// Adds a body.
    pub fn body(&mut self, name: &str, body: Body) -> &mut Self {
        self.bodies.push((name.into(), body));
        self
    }
    /// Adds a shaft between two bodies that turn alike.
    pub fn shaft(&mut self, name: &str, from: &str, to: &str, shaft: ShaftPart<N>) -> &mut Self {
        self.shafts.push(JoinedShaft { name: name.into(), ends: [from.into(), to.into()], part: shaft });
        self
    }
    /// Adds a mesh. `first` drives: contact on the upper flank, W > 0, pushes `second` along its rotation.
    pub fn mesh(&mut self, name: &str, first: &str, second: &str, mesh: MeshPart<N>) -> &mut Self {
        self.meshes.push((name.into(), [first.into(), second.into()], mesh));
        self
    }
    /// Adds a constant torque [N m] on a body along its rotation; a load is negative. `name` becomes a
    /// constant.
    pub fn torque(&mut self, name: &str, body: &str, value: f64) -> &mut Self {
        self.add_torque(name, body, value, Course::Constant)
    }
    /// Adds a torque [N m] times a factor over the turn of the body, for example of a piston engine.
    ///
    /// 2π is one turn, or an nth of it with `per_turn(n)`. A ripple at twice the speed is the first order
    /// of `per_turn(2)`. As the second order of a turn it has the same values, but a whole turn as its
    /// period, and orbits repeat in it.
    pub fn torque_of_angle(&mut self, name: &str, body: &str, value: f64, factor: Wave) -> &mut Self {
        self.add_torque(name, body, value, Course::OfAngle(factor))
    }
    /// Adds the torque of an induction motor. Its breakdown torque becomes the constant `name`.
    pub fn motor(&mut self, name: &str, body: &str, motor: InductionMotor) -> &mut Self {
        let InductionMotor { breakdown_torque, breakdown_slip, synchronous_speed: synchronous } = motor;
        let course = Course::OfSpeed(Characteristic::Induction { breakdown_slip, synchronous });
        self.add_torque(name, body, breakdown_torque, course)
    }
    /// Adds a torque [N m] that depends on the speed Ω [rad/s] of the body along its rotation by the factor
    /// Σ c_k Ω^k. A direct-current motor has two coefficients c_0, c_1; a fan or a propeller has three.
    ///
    /// ```
    /// use gear_dynamics::trains::{Body, Parts};
    /// use gear_dynamics::{Integrator, State, Taylor};
    /// let mut parts = Parts::new(); // J Ω' = -20 N m (Ω/100)²
    /// parts.body("fan", Body::new(0.5)).torque_of_speed("drag", "fan", -20.0, &[0.0, 0.0, 1e-4]);
    /// let end = Taylor::new().end(&parts.build("fan", 100.0)?, &State::at_rest(1), 2.0)?;
    /// let speed = 100.0 / (1.0 + 20.0 / (0.5 * 100.0) * 2.0); // Ω_0/(1 + T t/(J Ω_0))
    /// assert!((100.0 + end.v[0] - speed).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn torque_of_speed(&mut self, name: &str, body: &str, value: f64, coefficients: &[f64]) -> &mut Self {
        let course = Course::OfSpeed(Characteristic::Polynomial(coefficients.into()));
        self.add_torque(name, body, value, course)
    }
    /// Adds a torque on a body that balances all others at their mean and at the mean speeds, whatever the
    /// values of their constants are: the power of all torques in the kinematic rotation is 0. It has no
    /// constant of its own. [`build`](Parts::build) refuses a second load: it would have no equation.
    ///
    /// ```
    /// use gear_dynamics::linear::static_state;
    /// use gear_dynamics::trains::{Body, MeshPart, Parts};
    /// use gear_dynamics::Wave;
    /// let mut parts = Parts::new();
    /// parts.body("pinion", Body::new(2e-3)).body("wheel", Body::new(8e-3));
    /// let mesh = MeshPart::external([20, 40], [0.03, 0.06], Wave::constant(2e8)?);
    /// parts.mesh("mesh", "pinion", "wheel", mesh);
    /// let train = parts.torque("drive", "pinion", 30.0).load("wheel").build("pinion", 100.0)?;
    /// let heavier = static_state(&train.with("drive", 45.0)?, None)?;
    /// assert!((heavier.contacts[0].force - 1500.0).abs() < 1e-9); // 45 N m over 0.03 m
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn load(&mut self, body: &str) -> &mut Self {
        self.loads.push(body.into());
        self
    }
    fn add_torque(&mut self, name: &str, body: &str, value: f64, course: Course) -> &mut Self {
        self.torques.push(TorquePart { name: name.into(), body: body.into(), value, course });
        self
    }
    /// Sets the coordinates. Default: see [`Coordinates`].
    pub fn coordinates(&mut self, coordinates: Coordinates) -> &mut Self {
        self.coordinates = Some(coordinates);
        self
    }
    /// States all displacements x and y in the frame that rotates with a carrier at Ω: gyroscopic and
    /// centripetal terms, and those of Ω' at a varying speed. The planets have their centrifugal forces m r
    /// Ω² and the preloads of their bearings that carry these forces. The preloads neglect the displacement
    /// of the carrier, which matters if the planets do not balance each other. Default: all these terms are
    /// neglected, as in Lin and Parker 1999 at carrier speed 0.
    pub fn rotating_with(&mut self, carrier: &str) -> &mut Self {
        self.rotating = Some(RotatingFrame { carrier: carrier.into(), preloaded: true });
        self
    }
    /// [`rotating_with`](Parts::rotating_with) without centrifugal forces and preloads, for comparison with
    /// the matrices of Lin and Parker 1999. They make the rotation of a set that turns freely unstable
    /// ([errata](crate::guide::errata)).
    pub fn rotating_without_preload(&mut self, carrier: &str) -> &mut Self {
        self.rotating = Some(RotatingFrame { carrier: carrier.into(), preloaded: false });
        self
    }
    /// Accepts a warning, which is an error of [`build`](Parts::build) otherwise.
    pub fn accept(&mut self, warning: Warning) -> &mut Self {
        self.accepted.push(warning);
        self
    }
    /// Declares that all values are dimensionless: constants and channels have the unit 1, and
    /// [`Warning::UnusualValue`] is accepted.
    pub(crate) fn without_units(&mut self) -> &mut Self {
        self.without_units = true;
        self
    }
    /// Adds all parts of another train, with `name` and a space before each of their names, and the warnings
    /// that it accepts. Its choice of coordinates is left out; of two loads, that of `self` remains.
    pub fn join(&mut self, name: &str, other: Parts<N>) -> &mut Self {
        // All fields have names here, so that a new list is not lost.
        let Parts {
            bodies,
            shafts,
            meshes,
            torques,
            loads,
            coordinates: _,
            rotating,
            accepted,
            without_units,
            fault,
        } = other;
        let renamed = |own: String| format!("{name} {own}");
        self.bodies.extend(bodies.into_iter().map(|(own, mut body)| {
            if let Some(place) = &mut body.place {
                place.carrier = renamed(std::mem::take(&mut place.carrier));
            }
            (renamed(own), body)
        }));
        self.shafts.extend(shafts.into_iter().map(|shaft| JoinedShaft {
            name: renamed(shaft.name),
            ends: shaft.ends.map(renamed),
            ..shaft
        }));
        let mesh =
            |(own, ends, mesh): (String, [String; 2], MeshPart<N>)| (renamed(own), ends.map(renamed), mesh);
        self.meshes.extend(meshes.into_iter().map(mesh));
        self.torques.extend(torques.into_iter().map(|torque| TorquePart {
            name: renamed(torque.name),
            body: renamed(torque.body),
            ..torque
        }));
        self.accepted.extend(accepted);
        self.without_units |= without_units;
        self.fault = self.fault.take().or(fault);
        if self.loads.is_empty() {
            self.loads = loads.into_iter().map(renamed).collect();
        }
        let rotating = rotating.map(|frame| RotatingFrame { carrier: renamed(frame.carrier), ..frame });
        self.rotating = self.rotating.take().or(rotating);
        self
    }
}
