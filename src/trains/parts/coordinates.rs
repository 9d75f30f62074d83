//! The coordinates of a train.

/// What the coordinates of a train are measured from.
///
/// The default is relative coordinates if the train has torques that balance and nothing holds its rotation,
/// and inertial ones otherwise. Its rotation is held by supports, by drag and by torques over the speed of
/// bodies that turn, by noncircular gears and by a rotating frame.
///
/// ```
/// use gear_dynamics::trains::{Body, Coordinates, MeshPart, Parts};
/// use gear_dynamics::{Model, Wave};
/// let mut parts = Parts::new();
/// parts.body("pinion", Body::new(2e-3)).body("wheel", Body::new(8e-3));
/// parts.mesh("mesh", "pinion", "wheel", MeshPart::external([20, 40], [0.03, 0.06], Wave::constant(2e8)?));
/// parts.torque("drive", "pinion", 30.0).load("wheel");
/// assert_eq!(parts.build("pinion", 100.0)?.dof(), 1); // relative
/// assert_eq!(parts.coordinates(Coordinates::Inertial).build("pinion", 100.0)?.dof(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinates {
    /// One coordinate for every angle: deviations from the kinematic rotation at constant speed. They drift
    /// if the torques do not balance.
    Inertial,
    /// Deviations q_j - r_j q_last from the rigid motion of the last turning body, whose coordinate is left
    /// out, with the speed ratio r_j. Deflections are the same. Torques out of balance accelerate the train,
    /// and the coordinates do not drift.
    Relative,
}
