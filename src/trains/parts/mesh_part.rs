//! Meshes of a train.

use crate::contact::{Backlash, ContactDamping, Nonlinearity};
use crate::excitation::{RectangularWave, Side, Wave};
use crate::teeth::GearPair;
use std::f64::consts::PI;

/// Which gear has internal teeth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Kind {
    #[default]
    External,
    /// The second gear is internal.
    SecondInternal,
    /// The first gear is internal.
    FirstInternal,
}

/// One of the two gears of a mesh.
///
/// ```
/// use gear_dynamics::trains::OfMesh;
/// assert_eq!(OfMesh::Driven as usize, 1);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OfMesh {
    /// The first gear, which drives.
    Driver = 0,
    /// The second gear.
    Driven = 1,
}

/// The phase of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Phase {
    /// Not stated: that of a planet's place, otherwise 0.
    Unstated,
    /// The mesh is ahead of its waves by this number of mesh cycles. The phase of a planet's place is added.
    Ahead(f64),
    /// The phase follows from the teeth of a gear that two meshes share.
    FromTeeth,
}

/// Tooth friction of a mesh: coefficient and sign over the mesh cycle.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FrictionPart {
    pub(crate) coefficient: f64,
    pub(crate) sign: Wave,
}

/// A mesh of two gears, of which the first one drives.
///
/// d = r_1 q_1 - r_2 q_2 + n (x_1 - x_2) - e for gears at rest in space, with the angles q along the rotation
/// of each gear. n is the line of action of the flanks that touch when the first gear drives. Stiffness k,
/// error e and friction sign are waves of the mesh angle: 2π is one tooth.
///
/// ```
/// use gear_dynamics::{excitation::Fourier, trains::MeshPart, Wave};
/// let stiffness = Wave::new(Fourier::new(3e8, &[[5e7, 0.0]])?);
/// let mesh = MeshPart::external([20, 40], [0.03, 0.06], stiffness).half_backlash(5e-5).damping(800.0);
/// assert_eq!(mesh.teeth(), [20, 40]);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct MeshPart<N = Backlash> {
    pub(crate) law: N,
    pub(crate) gears: MeshGears,
}

/// A mesh without its contact law.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeshGears {
    pub(crate) kind: Kind,
    pub(crate) teeth: [u32; 2],
    pub(crate) radii: [f64; 2],
    pub(crate) pressure_angle: f64,
    pub(crate) stiffness: Wave,
    pub(crate) error: Wave,
    /// Waves over the turns of the first and the second gear: added to the error, multiplying the stiffness.
    pub(crate) error_of_turn: [Option<Wave>; 2],
    pub(crate) stiffness_of_turn: [Option<Wave>; 2],
    /// Waves over the turns of noncircular gears, which multiply the base radii.
    pub(crate) radius_of_turn: [Option<Wave>; 2],
    pub(crate) contact_damping: ContactDamping,
    pub(crate) damping: f64,
    pub(crate) half_backlash: f64,
    pub(crate) phase: Phase,
    pub(crate) stated_phase: Option<f64>,
    pub(crate) friction: Option<FrictionPart>,
    /// Mesh angle of the pitch point `[rad]`.
    pub(crate) pitch_point: f64,
    /// For each gear, half of the angle that a tooth takes up on the working pitch circle `[rad]`. `None`: a
    /// quarter of the pitch.
    pub(crate) half_thickness: [Option<f64>; 2],
}

impl MeshGears {
    /// Whether both gears are round.
    pub(crate) fn is_round(&self) -> bool {
        self.radius_of_turn.iter().all(Option::is_none)
    }
}

impl MeshPart {
    /// A mesh of two external gears with the given numbers of teeth, base radii `[m]` and mesh stiffness
    /// [N/m] over the mesh angle. Defaults: no error, damping and backlash; pressure angle 20°.
    pub fn external(teeth: [u32; 2], base_radii: [f64; 2], stiffness: Wave) -> Self {
        let gears = MeshGears {
            kind: Kind::External,
            teeth,
            radii: base_radii,
            pressure_angle: 20f64.to_radians(),
            stiffness,
            error: Wave::zero(),
            error_of_turn: [None, None],
            stiffness_of_turn: [None, None],
            radius_of_turn: [None, None],
            contact_damping: ContactDamping::Always,
            damping: 0.0,
            half_backlash: 0.0,
            phase: Phase::Unstated,
            stated_phase: None,
            friction: None,
            pitch_point: 0.5 * PI,
            half_thickness: [None, None],
        };
        MeshPart { law: Backlash::none(), gears }
    }
    /// A mesh whose gear with more teeth is internal (the second one, if the numbers are equal).
    pub fn internal(teeth: [u32; 2], base_radii: [f64; 2], stiffness: Wave) -> Self {
        let mut mesh = MeshPart::external(teeth, base_radii, stiffness);
        mesh.gears.kind = if teeth[0] > teeth[1] { Kind::FirstInternal } else { Kind::SecondInternal };
        mesh
    }
    /// The mesh of a pair of involute gears with the given mesh stiffness over the mesh angle: tooth numbers,
    /// base radii, working pressure angle, and b = 1/2 backlash cos α_w along the line of action
    /// ([`GearPair::backlash`] is the circumferential one).
    ///
    /// ```
    /// use gear_dynamics::teeth::{GearPair, InvoluteGear, PotentialEnergy};
    /// use gear_dynamics::{Wave, trains::MeshPart};
    /// let gear = |z| InvoluteGear::external(z, 0.003)?.with_face_width(0.02);
    /// let pair = GearPair::new(&gear(25)?, &gear(50)?)?;
    /// let mesh = MeshPart::of_pair(&pair, Wave::new(PotentialEnergy::tian_2004().wave(&pair)?));
    /// assert_eq!(mesh.teeth(), [25, 50]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of_pair(pair: &GearPair, stiffness: Wave) -> Self {
        let teeth = pair.gears().each_ref().map(|gear| gear.teeth());
        let radii = pair.gears().each_ref().map(|gear| gear.base_radius());
        let new = if pair.is_internal() { MeshPart::internal } else { MeshPart::external };
        let mut mesh = new(teeth, radii, stiffness).pressure_angle(pair.working_pressure_angle());
        mesh.gears.pitch_point = pair.pitch_point();
        mesh.gears.half_thickness = pair.gears().each_ref().map(|gear| {
            let radius = gear.base_radius() / libm::cos(pair.working_pressure_angle());
            Some(gear.tooth_thickness(radius).ok()? / (2.0 * radius))
        });
        // Along the line of action.
        mesh.half_backlash((0.5 * pair.backlash() * libm::cos(pair.working_pressure_angle())).max(0.0))
    }
    /// The same mesh with half a backlash b `[m]` along the line of action. It becomes the constant
    /// `<mesh> half backlash`.
    pub fn half_backlash(mut self, half_backlash: f64) -> Self {
        self.gears.half_backlash = half_backlash;
        self
    }
}

impl<N: Nonlinearity> MeshPart<N> {
    /// The same mesh with another contact law. All meshes of a train have laws of one type; see
    /// [`MixedLaw`](crate::contact::MixedLaw). The half backlash b becomes that of the law; one that was
    /// stated before is replaced.
    pub fn law<L: Nonlinearity>(self, law: L) -> MeshPart<L> {
        let upper = law.edges(0.0, Side::After).upper;
        let half_backlash = if L::HALF_BACKLASH && upper.is_finite() { upper } else { 0.0 };
        MeshPart { law, gears: MeshGears { half_backlash, ..self.gears } }
    }
    /// The same mesh with a static transmission error e `[m]` over the mesh angle.
    pub fn error(mut self, error: Wave) -> Self {
        self.gears.error = error;
        self
    }
    /// The same mesh with an error `[m]` over the turn of one of its gears, added to the static transmission
    /// error: eccentricity, runout, pitch errors.
    pub fn error_of_turn(mut self, gear: OfMesh, error: Wave) -> Self {
        self.gears.error_of_turn[gear as usize] = Some(error);
        self
    }
    /// The same mesh with a factor over the turn of one of its gears that multiplies the stiffness: a cracked
    /// or spalled tooth.
    pub fn stiffness_of_turn(mut self, gear: OfMesh, factor: Wave) -> Self {
        self.gears.stiffness_of_turn[gear as usize] = Some(factor);
        self
    }
    /// Makes a gear of the mesh noncircular: its base radius is r g. r is stated with the tooth numbers,
    /// and g is a positive wave without jumps over the mean turn of the gear, the angle by which it has
    /// turned at its mean speed.
    ///
    /// The gear moves the contact by r g q, and the bodies behind it turn unevenly:
    /// θ_2' = θ_1' r_1 g_1/(r_2 g_2). The mean of this ratio must be z_1/z_2. The reference body turns
    /// evenly: with another reference body, the same gear has another g. See the guide,
    /// [trains](crate::guide::trains).
    ///
    /// ```
    /// use gear_dynamics::{excitation::InstantCentre, trains::{Body, MeshPart, OfMesh, Parts}, Wave};
    /// let centre = InstantCentre::new(0.2)?; // θ_2' = θ_1' z_1/z_2 (1 - ε²)/(1 + 2 ε cos φ + ε²)
    /// let (r1, [z1, z2]) = (0.0211, [18, 63]); // m, teeth
    /// let r2 = r1 * 3.5 * (1.0 + 0.2 * 0.2) / (1.0 - 0.2 * 0.2);
    /// let mesh = MeshPart::external([z1, z2], [r1, r2], Wave::constant(2e8)?)
    ///     .radius_of_turn(OfMesh::Driven, Wave::new(centre.radius(1.0)?));
    /// let mut parts = Parts::new();
    /// parts.body("pinion", Body::new(1e-3).restrained(1e4, 5.0)).body("face gear", Body::new(1e-2));
    /// parts.mesh("mesh", "pinion", "face gear", mesh);
    /// assert!((parts.build("pinion", 160.0)?.shape().ratio() - 18.0 / 63.0).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn radius_of_turn(mut self, gear: OfMesh, factor: Wave) -> Self {
        self.gears.radius_of_turn[gear as usize] = Some(factor);
        self
    }
    /// The same mesh with a working pressure angle `[rad]`. Default: 20°. It matters for bodies on bearings,
    /// for planets and for friction.
    pub fn pressure_angle(mut self, pressure_angle: f64) -> Self {
        self.gears.pressure_angle = pressure_angle;
        self
    }
    /// The same mesh with a damping c [N s/m]; it becomes the constant `<mesh> damping`.
    pub fn damping(mut self, damping: f64) -> Self {
        self.gears.damping = damping;
        self
    }
    /// The same mesh with damping that acts always or only in contact. Default: always.
    pub fn contact_damping(mut self, contact_damping: ContactDamping) -> Self {
        self.gears.contact_damping = contact_damping;
        self
    }
    /// The same mesh ahead by a part of its mesh cycle. The mesh of a planet is shifted by the position of
    /// the planet in addition. Default: 0, which [`Warning::PhaseUnstated`] asks to state where the phases of
    /// several meshes matter.
    ///
    /// [`Warning::PhaseUnstated`]: crate::trains::Warning::PhaseUnstated
    pub fn phase(mut self, cycles: f64) -> Self {
        self.gears.phase = Phase::Ahead(cycles);
        self
    }
    /// The same mesh with the phase 0, unless it states another one.
    pub(crate) fn phase_or_zero(mut self) -> Self {
        if self.gears.phase == Phase::Unstated {
            self.gears.phase = Phase::Ahead(0.0);
        }
        self
    }
    /// The same mesh with the phase that follows from the teeth of a gear which it shares with another mesh:
    /// an idler, two wheels on one pinion, the ring mesh of a planet. The three bodies need places
    /// ([`Body::centre`], or planets).
    ///
    /// Gears of one body with equal tooth numbers and radii count as one gear. A mesh is behind another mesh
    /// of its gear of z teeth by z (β_2 - β_1)/2π mesh cycles, with the directions β of the pitch points from
    /// the gear, in its sense of rotation; less half a pitch (or the tooth thickness of
    /// [`of_pair`](MeshPart::of_pair)) if the other mesh drives the gear and this one is driven by it. The
    /// mesh angles of the pitch points are aligned. It replaces [`phase`](MeshPart::phase).   Source: Parker
    /// and Lin 2004, J. Mech. Des. 126, 365, for planets.
    ///
    /// [`Body::centre`]: crate::trains::Body::centre
    ///
    /// ```
    /// use gear_dynamics::{trains::{Body, MeshPart, Parts}, Wave};
    /// // An idler of 31 teeth between two gears, the second one 90° to the side.
    /// let mut parts = Parts::new();
    /// for (name, centre) in [("driver", [-0.09, 0.0]), ("idler", [0.0, 0.0]), ("driven", [0.0, 0.09])] {
    ///     parts.body(name, Body::new(1e-3).centre(centre));
    /// }
    /// let mesh = || Wave::constant(2e8).map(|k| MeshPart::external([31, 31], [0.042, 0.042], k));
    /// // The idler turns clockwise from 180° to 90°: 31/4 pitches, less one half.
    /// let second = mesh()?.phase_from_teeth().stated_phase(-31.0 / 4.0 + 0.5);
    /// parts.mesh("first", "driver", "idler", mesh()?).mesh("second", "idler", "driven", second);
    /// assert!(parts.build("driver", 100.0).is_ok());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn phase_from_teeth(mut self) -> Self {
        self.gears.phase = Phase::FromTeeth;
        self
    }
    /// `build` fails unless tooth counts and places give this phase, in mesh cycles ahead of the wave.
    pub fn stated_phase(mut self, cycles: f64) -> Self {
        self.gears.stated_phase = Some(cycles);
        self
    }
    /// The same mesh with tooth friction: the force μ s W perpendicular to the line of action. The sign s is
    /// -1 in the half cycle before the pitch point (approach) and 1 in the half cycle after it (recess). The
    /// pitch point is that of [`of_pair`](MeshPart::of_pair), otherwise at the mesh angle π/2. μ becomes the
    /// constant `<mesh> friction`.
    ///
    /// The whole load W has one sign, and its lever arms are those of the pitch point. Between real teeth two
    /// pairs share the load for most of the cycle, one in approach and one in recess, so that their forces
    /// nearly cancel: with a contact ratio of 1.68 this force is 3 to 4.5 times too large at the mesh order.
    /// At the pitch point teeth do not slide: the model loses no power by friction. It is an excitation, not
    /// a loss.
    pub fn friction(mut self, coefficient: f64) -> Self {
        // `RectangularWave::sign` reverses from -1 to 1 at 3π/2.
        let sign = Wave::new(RectangularWave::sign());
        let shifted = sign.clone().with_phase(1.5 * PI - self.gears.pitch_point);
        self.gears.friction = Some(FrictionPart { coefficient, sign: shifted.unwrap_or(sign) });
        self
    }
    /// Numbers of teeth.
    pub fn teeth(&self) -> [u32; 2] {
        self.gears.teeth
    }
    /// The bare stiffness wave [N/m].
    pub fn stiffness(&self) -> &Wave {
        &self.gears.stiffness
    }
}
