//! Errors and warnings of a train.

use crate::error::ParameterError;
use thiserror::Error;

/// A suspicious input that may be intended: [`Parts::accept`](crate::trains::Parts::accept) accepts it.
///
/// ```
/// use gear_dynamics::trains::{Body, MeshPart, Parts, TrainError, Warning};
/// use gear_dynamics::Wave;
/// let mut parts = Parts::new();
/// parts.body("pinion", Body::new(2e-3)).body("wheel", Body::new(8e-3));
/// parts.mesh("mesh", "pinion", "wheel", MeshPart::external([20, 40], [0.03, 0.06], Wave::constant(2e8)?));
/// parts.torque("motor", "pinion", 30.0); // no load
/// let error = parts.build("pinion", 100.0).unwrap_err();
/// assert!(matches!(error, TrainError::Warning { warning: Warning::Unbalanced, .. }));
/// assert!(parts.accept(Warning::Unbalanced).build("pinion", 100.0).is_ok());
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Warning {
    /// The torques accelerate the train. `build` checks it at the torques of the parts.
    /// [`Machine::with`](crate::Machine::with) may change one torque alone, and then does not;
    /// [`Parts::load`](crate::trains::Parts::load) balances the torques at all values.
    Unbalanced,
    /// A noncircular gear in a train that nothing holds to its kinematic rotation.
    Drifts,
    /// A body has a bearing without stiffness.
    Unsupported,
    /// Parts of the train are not connected.
    Disconnected,
    /// Meshes with gears on one body vary over their teeth, and more than one of them states no phase. What
    /// the train does depends on the phases between them.
    PhaseUnstated,
    /// A value is a thousand times off what steel gears have, or the order of a wave equals the number of
    /// teeth of a gear of its mesh. Orders count periods per mesh cycle. The wave may have been meant per
    /// turn of the gear. Trains of dimensionless numbers accept this warning.
    UnusualValue,
}

/// The reason why a train cannot be built.
///
/// ```
/// use gear_dynamics::trains::{Body, MeshPart, Parts};
/// use gear_dynamics::Wave;
/// let mut parts = Parts::new();
/// for name in ["a", "b", "c"] {
///     parts.body(name, Body::new(2e-3));
/// }
/// for (name, first, second) in [("ab", "a", "b"), ("bc", "b", "c"), ("ca", "c", "a")] {
///     parts.mesh(name, first, second, MeshPart::external([20, 20], [0.03, 0.03], Wave::constant(2e8)?));
/// }
/// let error = parts.build("a", 100.0).unwrap_err().to_string();
/// assert!(error.starts_with("the train cannot turn: \"ca\""), "{error}");
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TrainError {
    /// A parameter out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A body without inertia.
    #[error(
        "\"{body}\" has no inertia, and its acceleration is not determined: leave it out. Two springs on both \
         sides of it are one spring k1 k2/(k1 + k2); ideal gears z1, z2 are one body with the inertia \
         J1 + (z1/z2)² J2, on which a shaft of the second gear has the stiffness (z1/z2)² k and a torque the \
         value (z1/z2) T"
    )]
    NoInertia {
        /// Its name.
        body: String,
    },
    /// Two parts have the same name, or a part has the name of a constant that every train has.
    #[error("there is more than one \"{name}\": names must be different")]
    DuplicateName {
        /// The name.
        name: String,
    },
    /// Two loads that balance the other torques: each would be what the other one leaves.
    #[error(
        "there is a load on \"{}\" and another one on \"{}\": one balances all torques; state the other one as a \
         torque (Parts::torque)",
        bodies[0],
        bodies[1]
    )]
    TwoLoads {
        /// The first two bodies that were given.
        bodies: [String; 2],
    },
    /// A part refers to a body that does not exist.
    #[error("\"{part}\" refers to the body \"{body}\", which does not exist; there are: {known}")]
    NoSuchBody {
        /// The part.
        part: String,
        /// The name given.
        body: String,
        /// The names of all bodies.
        known: String,
    },
    /// A mesh or a shaft joins a body with itself.
    #[error("\"{part}\" joins \"{body}\" with itself")]
    JoinsItself {
        /// The part.
        part: String,
        /// The body.
        body: String,
    },
    /// A mesh or shaft contradicts the speeds that follow from the others.
    #[error(
        "the train cannot turn: \"{part}\" requires \"{body}\" to turn at {found:?} times the reference speed, \
         other parts at {expected:?} times"
    )]
    Locked {
        /// The part that closes the loop.
        part: String,
        /// A body of it.
        body: String,
        /// Speed by this part, over the reference speed.
        found: f64,
        /// Speed by the other parts, over the reference speed.
        expected: f64,
    },
    /// A shaft or a mesh joins a body that turns to one that does not.
    #[error(
        "\"{part}\" joins \"{body}\", which turns at {speed:?} times the reference speed, to \"{ground}\", \
         which is grounded: a shaft or a mesh to the ground, with play or without, is for bodies that do not \
         turn"
    )]
    LockedToGround {
        /// The shaft or the mesh.
        part: String,
        /// The body that turns.
        body: String,
        /// Its speed by the other parts, over the reference speed.
        speed: f64,
        /// The grounded body.
        ground: String,
    },
    /// The speed of a body does not follow from that of the reference body.
    #[error(
        "the speed of \"{body}\" does not follow from that of the reference body: connect it, or hold a body \
         of its planetary set (Body::grounded)"
    )]
    SpeedUndetermined {
        /// The body.
        body: String,
    },
    /// The reference body is grounded or at rest.
    #[error("the reference body \"{body}\" is at rest: give the speed of a body that turns")]
    ReferenceAtRest {
        /// The body.
        body: String,
    },
    /// A tooth number of 0 or above 1 000 000.
    #[error("the gears of \"{mesh}\" have {teeth} teeth: 1 to 1000000 are allowed")]
    ToothNumber {
        /// The mesh.
        mesh: String,
        /// The number given.
        teeth: u32,
    },
    /// A planetary set whose sun and ring meshes cannot have one centre distance.
    #[error(
        "a ring of {ring} teeth has no centre distance in common with a sun of {sun} and planets of {planet}: \
         (z_sun + z_planet)/cos α_sun = (z_ring - z_planet)/cos α_ring has no angle α_ring; some {near} teeth are \
         usual, z_sun + 2 z_planet"
    )]
    RingTeeth {
        /// Teeth of the sun.
        sun: u32,
        /// Teeth of each planet.
        planet: u32,
        /// Teeth of the ring.
        ring: u32,
        /// z_sun + 2 z_planet.
        near: u64,
    },
    /// Base radii do not have the ratio of the tooth numbers.
    #[error(
        "the base radii of \"{mesh}\" have the ratio {radii:?}, its tooth numbers {teeth:?}: compute the radii from \
         the teeth"
    )]
    RadiiContradictTeeth {
        /// The mesh.
        mesh: String,
        /// r_1/r_2.
        radii: f64,
        /// z_1/z_2.
        teeth: f64,
    },
    /// Noncircular gears where only round ones are possible.
    #[error("the gears of \"{mesh}\" are not round, but {why}")]
    NotRound {
        /// The mesh.
        mesh: String,
        /// The reason.
        why: &'static str,
    },
    /// The radius of a noncircular gear jumps.
    #[error("a base radius of \"{mesh}\" jumps at {angle:?} rad: the ratio of its gears would jump")]
    RadiusJumps {
        /// The mesh.
        mesh: String,
        /// Mean angle of the gear `[rad]`.
        angle: f64,
    },
    /// The mean ratio of noncircular gears contradicts their tooth numbers.
    #[error(
        "the mean ratio of the noncircular gears of \"{mesh}\" is {ratio:?}, that of their teeth {teeth:?}: scale a base \
         radius"
    )]
    MeanRatio {
        /// The mesh.
        mesh: String,
        /// Mean of θ_2'/θ_1'.
        ratio: f64,
        /// z_1/z_2.
        teeth: f64,
    },
    /// A part that needs an even rotation on a body that a noncircular gear turns unevenly.
    #[error(
        "\"{part}\" follows the turn of \"{body}\", which turns unevenly: waves, carriers and rotating frames need \
         round gears that turn evenly"
    )]
    Uneven {
        /// The mesh, torque or frame.
        part: String,
        /// The body.
        body: String,
    },
    /// Two ways round a loop with noncircular gears turn a body differently.
    #[error(
        "the train cannot turn: \"{part}\" turns \"{body}\" by another law than the other parts of its loop"
    )]
    UnevenLoop {
        /// The part that closes the loop.
        part: String,
        /// A body of it.
        body: String,
    },
    /// Two bodies of a mesh have the same centre, and its line of action matters.
    #[error("the gears of \"{mesh}\" have the same centre: Body::centre sets it")]
    SameCentre {
        /// The mesh.
        mesh: String,
    },
    /// A mesh joins planets of different carriers.
    #[error("\"{mesh}\" joins planets of different carriers")]
    TwoCarriers {
        /// The mesh.
        mesh: String,
    },
    /// A carrier is itself carried.
    #[error("\"{carrier}\" carries \"{planet}\", but is carried itself")]
    NestedCarrier {
        /// The carrier.
        carrier: String,
        /// The planet.
        planet: String,
    },
    /// The radius of a planet does not fit its meshes.
    #[error("\"{mesh}\" requires the centre of \"{planet}\" at the radius {required:?} m, not {found:?} m")]
    CentreDistance {
        /// The mesh.
        mesh: String,
        /// The planet.
        planet: String,
        /// Radius (r_1 ± r_2)/cos α that the mesh requires `[m]`.
        required: f64,
        /// The radius stated, or required by another mesh `[m]`.
        found: f64,
    },
    /// A radius is stated for a body that is no planet.
    #[error("\"{body}\" has a radius on a carrier and no carrier: name it by Body::carried_by")]
    RadiusWithoutCarrier {
        /// The body.
        body: String,
    },
    /// A planet meshes with no central gear.
    #[error("the planet \"{planet}\" meshes with no central gear: give its radius (Body::radius)")]
    PlanetWithoutMesh {
        /// The planet.
        planet: String,
    },
    /// A planet cannot be put in at its angle.
    #[error(
        "the planet \"{planet}\" does not assemble at {angle:?} rad: the nearest angle at which its teeth fit is \
         {nearest:?} rad"
    )]
    DoesNotAssemble {
        /// The planet.
        planet: String,
        /// Angle given `[rad]`.
        angle: f64,
        /// Nearest angle that fits `[rad]`.
        nearest: f64,
    },
    /// A phase stated for a mesh contradicts tooth numbers.
    #[error(
        "the phase of \"{mesh}\" is stated as {stated:?} mesh cycles: it is {computed:?} by its teeth and place, or by \
         MeshPart::phase"
    )]
    PhaseContradicts {
        /// The mesh.
        mesh: String,
        /// The phase stated, in mesh cycles.
        stated: f64,
        /// The phase computed, in mesh cycles in [0, 1).
        computed: f64,
    },
    /// The phase of a mesh does not follow from its teeth.
    #[error(
        "the phase of \"{mesh}\" does not follow from its teeth: one of its gears, with the same teeth, must be in \
         another mesh with a phase, and all three bodies need centres of their own (Body::centre)"
    )]
    PhaseUndetermined {
        /// The mesh.
        mesh: String,
    },
    /// The teeth of gears in a loop do not meet.
    #[error(
        "the gears of \"{mesh}\" cannot be put in at their places: the teeth of its loop miss by {gap:?} of a pitch, \
         0.001 is allowed"
    )]
    TeethMiss {
        /// A mesh of the loop.
        mesh: String,
        /// The gap, in pitches.
        gap: f64,
    },
    /// A wave that varies belongs to a mesh that does not turn, or a torque acts on a locked body.
    #[error("\"{part}\" does not turn: a wave that varies and a torque need rotation")]
    AtRest {
        /// The mesh or torque.
        part: String,
    },
    /// A torque, a drag or a support acts on a body whose rotation is prescribed.
    #[error("\"{part}\" acts on \"{body}\", whose rotation is prescribed: it would have no effect")]
    Prescribed {
        /// The torque, "drag" or "support".
        part: String,
        /// The body.
        body: String,
    },
    /// The contact law of a planet's mesh has edges that move with the mesh angle.
    #[error("the contact law of \"{mesh}\" has edges that move: a mesh with a phase cannot shift them")]
    MovingEdges {
        /// The mesh.
        mesh: String,
    },
    /// A part that does not turn with the carrier whose frame is stated.
    #[error("\"{part}\" does not turn with the carrier of the rotating frame: {why}")]
    NotRotating {
        /// The part.
        part: String,
        /// The reason.
        why: &'static str,
    },
    /// The tooth numbers have no common angle that can be computed.
    #[error(
        "the wave of \"{part}\" and the other waves repeat together only after more than 4294967295 of their \
         periods: choose tooth numbers with common factors, or state the waves that matter least by their means"
    )]
    NoCommonAngle {
        /// The mesh or torque.
        part: String,
    },
    /// The relative coordinates contradict a part that depends on absolute motion.
    #[error("relative coordinates do not exist with {part}, which depends on the absolute motion")]
    NotRelative {
        /// The part.
        part: String,
    },
    /// Bearings of different stiffness along x and y where all directions must be equal.
    #[error("the bearing of \"{body}\" must have the same stiffness and damping along x and y: {why}")]
    NotIsotropic {
        /// The body.
        body: String,
        /// The reason.
        why: &'static str,
    },
    /// Something unusual that has not been accepted.
    #[error("{message} (Parts::accept({warning:?}) accepts it)")]
    Warning {
        /// What it is.
        warning: Warning,
        /// The sentence with names and values.
        message: String,
    },
}
