//! The noncircular face gear pair with two degrees of freedom.   Source: Liu 2021, Eq. (4).

use crate::contact::mesh::{LOWER, UPPER};
use crate::contact::{Backlash, Contact, Deflection, Mesh, Nonlinearity, PieceChoice};
use crate::error::{ParameterError, check};
use crate::excitation::{Angle, Side};
use crate::model::{Channel, Drives, Machine, Model, Shape, Size, State};
use crate::models::nfg::constants::{Constants, Range};
use crate::models::nfg::face_gear::{FaceGear, mesh_of};
use crate::models::nfg::nfg_params::{NfgParams, NfgReading, Radius};
use crate::scalar::Scalar;

/// The noncircular face gear pair with two degrees of freedom: the elastic angles q1 of the pinion and q2 of
/// the face gear `[rad]` over time `[s]`.
///
/// I1 q1'' + r_b1 W = T1 - I1 θ1'',   I2 q2'' - r_b2 W = -T2 - I2 θ2'',
/// W = c_m x' + k_m f(x),   x = r_b1 q1 - r_b2 q2 - e,   x' = r_b1 q1' - r_b2 q2' - r_b2' q2 - e'.
///
/// Source: Liu 2021, Eq. (4), corrected.
///
/// - f is the contact law, by default the dead zone of half backlash b `[m]`; b is half of the backlash.
/// - Default of T1: I1 θ1'' + r_b1 (T2 + I2 θ2'')/r_b2, which balances the rigid motion. The difference from
///   [`NfgPair`](crate::NfgPair) then decreases as 1/I1.
/// - Nothing holds the pinion to its even rotation. A common deviation of both gears grows: with Table 1 by
///   the factor 1.76 in a turn of the face gear for I1 = 0.01 kg m², and by 1.02 for 10 kg m².
/// - Initial value of c_m: 2 ζ I2 ω_n/(L² (1 + β²/2)), with ω_n of [`NfgPair`](crate::NfgPair).
/// - Of an [`NfgReading`] only `radius` and `centre_forcing` have an effect.
///
/// Constants: `speed` ω1 [rad/s], `load torque` T2 [N m], `mesh damping` c_m [N s/m], `inertia` I2 [kg m²],
/// `pinion inertia` I1 [kg m²] and, if the law is a [`Backlash`], `half backlash` b `[m]`.
///
/// The contact has the deflection x `[m]` and the mesh force W `[N]`. Under positive load the drive flank is
/// the upper flank. Own channels: `base radius` r_b2 `[m]` and `elastic part` f(x) `[m]`.
///
/// ```
/// use gear_dynamics::{NfgParams, ode::Probe, excitation::Side, models::nfg::NfgPair2};
/// let pair = NfgPair2::new(&NfgParams::table1(), 0.01)?;
/// let start = pair.on_drive_flank()?;
/// let mut probe = Probe::new(&pair);
/// let force = probe.index("mesh force")?;
/// let w = probe.read(start.t, Side::After, &start.q, &start.v)[force];
/// assert!((w - 270.27).abs() < 0.01); // T2/r_b2(0) = 30 N m/0.111 m
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub type NfgPair2<N = Backlash> = Machine<NfgShape2<N>>;

/// The shape of [`NfgPair2`]: geometry, torque on the pinion and mesh. Pairs of equal shape share lanes.
///
/// ```
/// use gear_dynamics::{models::nfg::NfgPair2, NfgParams, Shape};
/// let pair = NfgPair2::new(&NfgParams::table1(), 0.01)?;
/// assert_eq!(pair.shape().size().waves, 11);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct NfgShape2<N = Backlash> {
    /// Constant torque T1 on the pinion [N m]; `None` if T1 balances the rigid motion.
    torque: Option<f64>,
    /// Base radius of the pinion r_b1 `[m]`.
    pinion_radius: f64,
    gear: FaceGear,
    mesh: Mesh<N>,
}

const CONSTANTS: Constants = Constants([
    ("speed", "rad/s", Range::Scale),
    ("load torque", "N m", Range::NotNegative),
    ("mesh damping", "N s/m", Range::NotNegative),
    ("inertia", "kg m²", Range::Scale),
    ("pinion inertia", "kg m²", Range::Scale),
    ("half backlash", "m", Range::NotNegative),
]);

// Indices of the waves. Waves 0 to 6 are those of the mesh.
const RADIUS: usize = 7; // r_b2 [m]
const RADIUS_RATE: usize = 8; // dr_b2/dx [m]
const ROTATION: usize = 9; // dθ2/dx
const CENTRE: usize = 10; // d²θ2/dx²
const WAVES: usize = 11;

impl NfgPair2 {
    /// The pair of the [exact reading](NfgReading::exact). `pinion_inertia`: I1 [kg m²].
    ///
    /// # Errors
    /// A pinion inertia outside 1e-50 .. 1e50; a parameter outside its range, named by its field; a derived
    /// quantity that is outside its range or overflows.
    pub fn new(params: &NfgParams, pinion_inertia: f64) -> Result<Self, ParameterError> {
        NfgPair2::of_reading(params, pinion_inertia, NfgReading::exact())
    }

    /// The pair of a given reading, of which only `radius` and `centre_forcing` have an effect.
    ///
    /// # Errors
    /// As [`new`](NfgPair2::new).
    pub fn of_reading(
        params: &NfgParams,
        pinion_inertia: f64,
        reading: NfgReading,
    ) -> Result<Self, ParameterError> {
        params.check()?;
        let mesh = mesh_of(params.series(1.0)?)?;
        NfgPair2::made(params, pinion_inertia, reading, mesh, params.half_backlash)
    }
}

impl<N: Nonlinearity> NfgPair2<N> {
    /// The pair with a given mesh stiffness k_m [N/m], transmission error e `[m]` and contact law, in place
    /// of those of the parameters.
    ///
    /// Stiffness and error are waves of the mesh phase; 2π is one tooth. The half backlash of a [`Backlash`]
    /// becomes the constant `half backlash`. The initial c_m still follows from k0 of the parameters.
    ///
    /// # Errors
    /// As [`new`](NfgPair2::new).
    pub fn of_mesh(
        params: &NfgParams,
        pinion_inertia: f64,
        reading: NfgReading,
        mesh: Mesh<N>,
    ) -> Result<Self, ParameterError> {
        params.check()?;
        let half_backlash = mesh.law().edges(0.0, Side::After).upper;
        NfgPair2::made(params, pinion_inertia, reading, mesh, half_backlash)
    }

    fn made(
        params: &NfgParams,
        pinion_inertia: f64,
        reading: NfgReading,
        mesh: Mesh<N>,
        half_backlash: f64,
    ) -> Result<Self, ParameterError> {
        let (gear, natural) = FaceGear::of(params, reading)?;
        let pinion_radius = match reading.radius {
            Radius::Base => params.pinion_pitch_radius() * libm::cos(params.pressure_angle),
            Radius::Pitch => params.pinion_pitch_radius(),
        };
        let NfgParams { speed, load_torque, inertia, damping_ratio, .. } = *params;
        let damping =
            2.0 * damping_ratio * inertia * natural / (gear.radius * gear.radius * gear.mean_square());
        let mesh = mesh.per_turn(gear.teeth)?;
        let shape = NfgShape2 { torque: None, pinion_radius, gear, mesh };
        CONSTANTS.machine(shape, [speed, load_torque, damping, inertia, pinion_inertia, half_backlash])
    }

    /// The same pair with a constant torque T1 [N m] on the pinion. Default: the torque that balances the
    /// rigid motion.
    ///
    /// # Errors
    /// A torque beyond ±1e50.
    pub fn with_torque(self, torque: f64) -> Result<Self, ParameterError>
    where
        N: Clone,
    {
        let shape = NfgShape2 {
            torque: Some(check::quantity("torque on the pinion", torque)?),
            ..self.shape().clone()
        };
        Ok(self.reshaped(shape))
    }

    /// Mesh damping c_m [N s/m].
    pub fn damping(&self) -> f64 {
        self.values()[2]
    }

    /// The state on the drive flank at t = 0: q1 = 0, q1' = 0, x = b + T2/(r_b2 k_m), with q2' such that
    /// q2 + e/r_b2 is at rest. The formula assumes a law of slope 1 on its upper flank. For a law without
    /// edges it is x = T2/(r_b2 k_m).
    ///
    /// # Errors
    /// A mesh stiffness at t = 0 that is not positive. [`ParameterError::NoFlank`] if the law has a lower
    /// flank only, because a positive load acts on the upper flank.
    pub fn on_drive_flank(&self) -> Result<State, ParameterError> {
        let mut u = vec![0.0; self.drives()];
        self.drive(0.0, Side::After, &mut u);
        let u = Drives::new(self.size().waves, &u);
        let ([stiffness, error, error_rate, lower, upper, _, _], [load]) =
            (self.shape().mesh_waves(u), u.constants());
        let (radius, radius_rate) = (u.all_waves()[RADIUS], u.all_waves()[RADIUS_RATE]);
        if upper == f64::INFINITY && lower.is_finite() {
            return Err(ParameterError::NoFlank { flank: "upper" });
        }
        let edge = if upper == f64::INFINITY { 0.0 } else { upper };
        let deflection = edge + load / (radius * check::positive("mesh stiffness at the start", stiffness)?);
        // q = q2 + e/r_b2 is at rest, as in the model with one degree of freedom: q2' = -(e/r_b2)'.
        let stretch = radius_rate / radius;
        let q2 = -(deflection + error) / radius;
        let v2 = -u.speed() * (error_rate - error * stretch) / radius;
        let start = State::new(0.0, &[0.0, q2], &[0.0, v2]);
        start.check(2)?;
        Ok(start)
    }
}

impl<N: Nonlinearity> NfgShape2<N> {
    /// Base radius of the pinion r_b1 `[m]`; the pitch radius if the reading selects it.
    pub(crate) fn pinion_radius(&self) -> f64 {
        self.pinion_radius
    }

    /// The waves of the mesh. For a [`Backlash`] the constant half backlash replaces the edges.
    #[inline(always)]
    fn mesh_waves<S: Scalar>(&self, u: Drives<'_, S>) -> [S; 7] {
        let (mut waves, [_, _, _, _, _, half]) = (u.waves(), u.constants());
        if N::HALF_BACKLASH {
            (waves[LOWER], waves[UPPER]) = (-half, half);
        }
        waves
    }
}

impl<N: Nonlinearity> Shape for NfgShape2<N> {
    #[inline(always)]
    fn size(&self) -> Size {
        Size {
            dof: 2,
            waves: WAVES,
            contacts: 1 + self.mesh.law().kinks(),
            kinks: self.mesh.law().kinks(),
            constants: 6 + usize::from(N::HALF_BACKLASH),
        }
    }
    fn names(&self) -> Vec<Channel> {
        CONSTANTS.names::<N>()
    }
    fn check(&self, constants: &[f64]) -> Result<(), ParameterError> {
        CONSTANTS.check(constants)
    }
    /// Returns ω_c = ω1/i_j [rad/s], T2, c_m, I2, 1/I2, 1/I1 and, for a [`Backlash`], b.
    fn prepare<S: Scalar>(&self, constants: &[S]) -> Vec<S> {
        let &[speed, load, damping, inertia, pinion_inertia, ref half_backlash @ ..] = constants else {
            return Vec::new();
        };
        let one = S::from(1.0);
        let mut prepared = vec![
            speed / S::from(self.gear.ratio),
            load,
            damping,
            inertia,
            one / inertia,
            one / pinion_inertia,
        ];
        prepared.extend(half_backlash);
        prepared
    }

    #[inline(always)]
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let (waves, omega, [load, _, inertia, per_inertia, per_pinion]) =
            (u.all_waves(), u.speed(), u.constants());
        let w = self.contact(law, 0, u, q, v).force;
        let turning = load + inertia * (omega * omega * waves[CENTRE] + u.acceleration() * waves[ROTATION]);
        // T1, and the part of θ1'' that T1 does not balance.
        let (torque, rest) = match self.torque {
            Some(torque) => (S::from(torque), u.acceleration() * self.gear.ratio),
            None => (turning * self.pinion_radius / waves[RADIUS], S::from(0.0)),
        };
        a[0] = (torque - w * self.pinion_radius) * per_pinion - rest;
        a[1] = (waves[RADIUS] * w - turning) * per_inertia;
    }

    #[inline(always)]
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let (w, omega, [_, damping]) = (u.all_waves(), u.speed(), u.constants());
        let x = q[0] * self.pinion_radius - w[RADIUS] * q[1];
        let rate = v[0] * self.pinion_radius - w[RADIUS] * v[1] - omega * (w[RADIUS_RATE] * q[1]);
        let contact = self.mesh.contact(law, 0, &self.mesh_waves(u), omega, damping, x, rate);
        let Some(k) = i.checked_sub(1) else { return contact };
        Contact { deflection: self.mesh.law().kink(k, contact.deflection, contact.rate), ..contact }
    }

    fn waves<A: Angle>(&self, phase: A, side: Side, u: &mut [A::Number]) {
        let ((s, c), rotation) = (phase.number().sin_cos(), phase.jet_of(&self.gear.rotation, side));
        self.mesh.waves(phase, side, u);
        u[RADIUS] = (A::Number::from(1.0) + c * self.gear.beta) * self.gear.radius;
        u[RADIUS_RATE] = s * (-self.gear.radius * self.gear.beta);
        (u[ROTATION], u[CENTRE]) = (rotation.value, rotation.rate);
    }
    fn next_edge(&self, phase: f64) -> Option<f64> {
        self.mesh.next_edge(phase)
    }
    fn next_knot(&self, phase: f64) -> Option<f64> {
        self.mesh.next_knot(phase)
    }

    fn channels(&self) -> Vec<Channel> {
        vec![Channel::new("base radius", "m"), Channel::new("elastic part", "m")]
    }
    fn write_channels(
        &self,
        u: Drives<'_, f64>,
        _: &[f64],
        _: &[f64],
        contacts: &[Contact],
        out: &mut [f64],
    ) {
        let Contact { deflection, rate, lower, upper, .. } = contacts[0];
        out[0] = u.all_waves()[RADIUS];
        out[1] = self.mesh.law().force(Deflection { d: deflection, rate, lower, upper });
    }
}
