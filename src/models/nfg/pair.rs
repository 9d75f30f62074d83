//! One degree of freedom: Eq. (9).

use super::params::{CentreForcing, Damping, ErrorForcing, HalfWidth, NfgParams, NfgReading, Radius};
use crate::error::{ParameterError, check};
use crate::excitation::{Excitation, InstantCentre, Jet};
use crate::jacobian::dual_jacobian;
use crate::model::{AsIs, Channel, Contact, Generic, Jacobian, Law, Model, OnPieces, Periodic, State};
use crate::nonlinearity::Backlash;
use crate::piece::{Piece, Side};
use crate::scalar::Scalar;
use std::f64::consts::TAU;
use std::ops::Range;

/// The pair in one degree of freedom, the pinion turning evenly.   Source: Liu 2021, Eq. (9), corrected.
///
/// q'' + 2 ζ D (q' + (r'/r) q) + F f(q) = -B0 - θ2'' + ē''
///
/// over τ = ω_n t, with q = q2 + e/r_b2 `[rad]`, F = (k_m/k0) (1 + β cos x)²/(1 + β²/2), f the dead zone of half width b̄ and
/// x = ω̄_c τ. How b̄, D, θ2'' and ē'' are read is up to [`NfgReading`].
///
/// Its contact is in metres: deflection r_b2 q, edges ∓ r_b2 b̄; the mesh force is in newtons. The drive flank under positive load
/// is the lower one. Channels of its own: `base radius` r_b2 `[m]` and `elastic part` f(q) `[rad]`, what is left of q without the gap.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, Probe, Side};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// assert!((pair.natural_frequency() - 12_362.613_066_76).abs() < 1e-7);
/// assert!((pair.half_width() - 6.236_939_33e-4).abs() < 1e-12);
///
/// let start = pair.static_start()?; // q = -b̄ - B0/F
/// let mut probe = Probe::new(&pair);
/// let elastic = probe.index("elastic part")?;
/// let f = probe.read(start.t, Side::After, &start.q, &start.v)[elastic];
/// assert!((f + 6.0871e-6).abs() < 1e-9); // B0/F(0)
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct NfgPair {
    params: NfgParams,
    reading: NfgReading,
    /// L `[m]`.
    radius: f64,
    beta: f64,
    /// ω_n [rad/s].
    natural: f64,
    /// Z2.
    teeth: f64,
    /// The instantaneous centre over its phase.
    unit_centre: InstantCentre,
    /// Stiffness amplitudes over k0.
    stiffness: Vec<[f64; 2]>,
    /// The values of the drives that do not change with phase.
    constants: [f64; CONSTANTS],
    law: Backlash,
}

// Drives: shapes of phase, then constants.
const STIFFNESS: usize = 0; // F
const RADIUS: usize = 1; // r_b2/L
const INVERSE: usize = 2; // L/r_b2: lanes multiply faster than they divide
const STRETCH: usize = 3; // (dr_b2/dx)/r_b2
const CENTRE: usize = 4; // θ2''/ω_c²
const ERROR: usize = 5; // (L ē)'' over x [m]
const PHASES: usize = 6;
const OMEGA: usize = 6; // ω_c/ω_n
const DAMPING: usize = 7; // 2 ζ
const LOAD: usize = 8; // B0
const WIDTH: usize = 9; // b/L
const PER_LENGTH: usize = 10; // 1/L [1/m]
const LENGTH: usize = 11; // L [m]
const MESH_FORCE: usize = 12; // I2 ω_n²/L [N]
const CONSTANTS: usize = 7;

/// What the algebra needs of the drives.
struct At<S> {
    /// b̄ and its rate over τ.
    half_width: S,
    half_width_rate: S,
    /// 2 ζ D and r'/r.
    damping: S,
    stretch: S,
}

impl NfgPair {
    /// The exact reading.
    ///
    /// # Errors
    /// Every parameter out of its range, by the name of its field.
    pub fn new(params: &NfgParams) -> Result<Self, ParameterError> {
        NfgPair::with_reading(params, NfgReading::exact())
    }

    /// Any reading.
    ///
    /// # Errors
    /// As [`new`](NfgPair::new).
    pub fn with_reading(params: &NfgParams, reading: NfgReading) -> Result<Self, ParameterError> {
        params.check()?;
        let radius = match reading.radius {
            Radius::Base => params.mean_base_radius(),
            Radius::Pitch => params.mean_pitch_radius(),
        };
        let beta = params.beta();
        let natural = params.check_derived(radius, reading)?;
        let constants = [
            params.centre_frequency() / natural,
            2.0 * params.damping_ratio,
            params.load_torque / (params.inertia * natural * natural),
            params.half_backlash / radius,
            1.0 / radius,
            radius,
            params.inertia * natural * natural / radius,
        ];
        Ok(NfgPair {
            reading,
            radius,
            beta,
            natural,
            teeth: params.face_gear_teeth().round(),
            unit_centre: InstantCentre::new(params.eccentric_ratio, 1.0)?,
            stiffness: params.stiffness_harmonics.iter().map(|[c, s]| [c / params.stiffness, s / params.stiffness]).collect(),
            constants,
            law: Backlash::new(params.half_backlash / radius)?,
            params: params.clone(),
        })
    }

    /// The parameters.
    pub fn params(&self) -> &NfgParams {
        &self.params
    }
    /// The reading.
    pub fn reading(&self) -> NfgReading {
        self.reading
    }
    /// L `[m]`.
    pub fn mean_radius(&self) -> f64 {
        self.radius
    }
    /// ω_n [rad/s]: τ = ω_n t.   Eq. (10).
    pub fn natural_frequency(&self) -> f64 {
        self.natural
    }
    /// b/L `[rad]`.
    pub fn half_width(&self) -> f64 {
        self.constants[WIDTH - PHASES]
    }
    /// ω_c/ω_n `[1]`.
    pub fn centre_frequency(&self) -> f64 {
        self.constants[OMEGA - PHASES]
    }

    /// Rest on the drive flank: q = -b̄ - B0/F, q' = 0, at τ = 0.
    ///
    /// # Errors
    /// A mesh stiffness that is not positive at the start.
    pub fn static_start(&self) -> Result<State, ParameterError> {
        let mut u = [0.0; PHASES + CONSTANTS];
        self.drive(0.0, Side::After, &mut u);
        let load = u[LOAD] / check::positive("mesh stiffness at the start", u[STIFFNESS])?;
        let start = State::new(0.0, &[-self.at(&u).half_width - load], &[0.0]);
        start.check(1)?;
        Ok(start)
    }

    #[inline(always)]
    fn at<S: Scalar>(&self, u: &[S]) -> At<S> {
        let (width, omega) = (u[WIDTH], u[OMEGA]);
        let stretch = u[STRETCH] * omega;
        let (half_width, half_width_rate) = match self.reading.half_width {
            HalfWidth::Mean => (width, S::from(0.0)),
            HalfWidth::Instant => (width * u[INVERSE], -(width * u[INVERSE] * stretch)),
        };
        let (damping, stretch) = match self.reading.damping {
            Damping::ConstantRatio => (u[DAMPING], S::from(0.0)),
            Damping::ConstantCoefficient => (u[DAMPING] * u[RADIUS] * u[RADIUS] * (1.0 / (1.0 + 0.5 * self.beta * self.beta)), stretch),
        };
        At { half_width, half_width_rate, damping, stretch }
    }

    /// 2 ζ D (q' + (r'/r) q) + F f(q).
    #[inline(always)]
    fn tooth<S: Scalar, L: Law<S>>(&self, law: &L, at: &At<S>, u: &[S], q: S, v: S) -> S {
        at.damping * (v + at.stretch * q) + u[STIFFNESS] * law.force(0, &self.law, q, v, -at.half_width, at.half_width)
    }

    /// Σ_p c_p cos(p Z2 x) + s_p sin(p Z2 x) with its derivatives over x, from the sine and cosine of Z2 x.
    fn mesh_wave(&self, (s1, c1): (f64, f64), pairs: &[[f64; 2]]) -> Jet {
        let (mut s, mut c, mut order) = (s1, c1, 0.0);
        let mut jet = Jet::constant(0.0);
        for &[cos, sin] in pairs {
            order += self.teeth;
            let wave = cos * c + sin * s;
            jet = jet + Jet::new(wave, order * (sin * c - cos * s), -order * order * wave);
            (s, c) = (s * c1 + c * s1, c * c1 - s * s1);
        }
        jet
    }
}

impl Generic for NfgPair {
    #[inline(always)]
    fn accel_on<S: Scalar, L: Law<S>>(&self, law: &L, u: &[S], q: &[S], v: &[S], a: &mut [S]) {
        let at = self.at(u);
        let omega2 = u[OMEGA] * u[OMEGA];
        let forcing = -u[LOAD] - omega2 * u[CENTRE] + omega2 * u[PER_LENGTH] * u[ERROR];
        a[0] = forcing - self.tooth(law, &at, u, q[0], v[0]);
    }

    #[inline(always)]
    fn contact_on<S: Scalar>(&self, _: Range<usize>, u: &[S], q: &[S], v: &[S], out: &mut [Contact<S>]) -> bool {
        let at = self.at(u);
        // In metres: r_b2 times q and b̄, with the rates of the products.
        let r = u[RADIUS] * u[LENGTH];
        let r_rate = r * u[STRETCH] * u[OMEGA];
        let (b, b_rate) = (r * at.half_width, r_rate * at.half_width + r * at.half_width_rate);
        out[0] = Contact {
            deflection: r * q[0],
            rate: r * v[0] + r_rate * q[0],
            lower: -b,
            upper: b,
            lower_rate: -b_rate,
            upper_rate: b_rate,
            force: self.tooth(&AsIs, &at, u, q[0], v[0]) * u[MESH_FORCE] * u[INVERSE],
        };
        true
    }

    fn phases(&self) -> usize {
        PHASES
    }
    fn phase_drives(&self, phase: f64, _: Side, u: &mut [f64]) {
        let (s, c) = libm::sincos(phase);
        let rho = Jet::new(1.0 + self.beta * c, -self.beta * s, -self.beta * c);
        let mesh = libm::sincos(self.teeth * phase);
        let stiffness = 1.0 + self.mesh_wave(mesh, &self.stiffness).value;
        let error = self.mesh_wave(mesh, &self.params.error_harmonics);
        u[STIFFNESS] = stiffness * rho.value * rho.value / (1.0 + 0.5 * self.beta * self.beta);
        u[RADIUS] = rho.value;
        u[INVERSE] = 1.0 / rho.value;
        u[STRETCH] = rho.rate / rho.value;
        u[CENTRE] = self.centre(phase, s, c);
        u[ERROR] = match self.reading.error_forcing {
            ErrorForcing::MeanRadius => error.second,
            ErrorForcing::Frozen => error.second / rho.value,
            ErrorForcing::Exact => ((error + self.params.error) / rho).second,
        };
    }
    fn constants(&self, u: &mut [f64]) {
        u[PHASES..PHASES + CONSTANTS].copy_from_slice(&self.constants);
    }
    fn at_speed(&self, speed: f64, u: &mut [f64]) {
        u[OMEGA] = speed;
    }
    fn shares_lanes_with(&self, other: &Self) -> bool {
        self.reading == other.reading
            && self.teeth == other.teeth
            && self.beta == other.beta
            && self.stiffness == other.stiffness
            && self.params.error_harmonics == other.params.error_harmonics
            && self.params.error == other.params.error
    }
}

impl NfgPair {
    /// θ2''/ω_c².
    fn centre(&self, phase: f64, s: f64, c: f64) -> f64 {
        let eps = self.params.eccentric_ratio;
        match self.reading.centre_forcing {
            CentreForcing::Exact => {
                let swing = 1.0 + 2.0 * eps * c + eps * eps;
                2.0 * eps * (1.0 - eps * eps) * s / (swing * swing)
            }
            CentreForcing::Series(2) => 2.0 * eps * s - 4.0 * eps * eps * (2.0 * s * c),
            CentreForcing::Series(order) => {
                self.unit_centre.forcing_series(order as usize).map_or(f64::NAN, |series| series.value(phase, Side::After))
            }
        }
    }
}

impl Model for NfgPair {
    fn dof(&self) -> usize {
        1
    }
    #[inline]
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.accel_on(&AsIs, u, q, v, a);
    }
    fn drives(&self) -> usize {
        PHASES + CONSTANTS
    }
    #[inline]
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.phase_drives(self.constants[OMEGA - PHASES] * t, side, u);
        self.constants(u);
    }
    fn contacts(&self) -> usize {
        1
    }
    #[inline]
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        self.contact_on(0..1, u, q, v, out);
    }
    #[inline]
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) -> bool {
        self.accel_on(&OnPieces(pieces), u, q, v, a);
        true
    }
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) -> bool {
        dual_jacobian(self, pieces, u, q, v, out)
    }
    fn channels(&self) -> Vec<Channel> {
        vec![Channel::new("base radius", "m"), Channel::new("elastic part", "rad")]
    }
    fn observe(&self, u: &[f64], q: &[f64], v: &[f64], _: &[Contact], out: &mut [f64]) {
        let b = self.at(u).half_width;
        out[0] = u[LENGTH] * u[RADIUS];
        out[1] = AsIs.force(0, &self.law, q[0], v[0], -b, b);
    }
}

impl Periodic for NfgPair {
    /// One turn of the face gear, over τ.
    fn period(&self) -> f64 {
        TAU / self.centre_frequency()
    }
}
