//! Two degrees of freedom: Eq. (4).

use super::params::{CentreForcing, NfgParams, NfgReading, Radius};
use crate::error::{ParameterError, check};
use crate::excitation::{CentreCurve, Excitation, Fourier, InstantCentre, Jet};
use crate::jacobian::dual_jacobian;
use crate::model::{AsIs, Channel, Contact, Generic, Jacobian, Law, Model, OnPieces, Periodic, State};
use crate::nonlinearity::Backlash;
use crate::piece::{Piece, Side};
use crate::scalar::Scalar;
use std::f64::consts::TAU;
use std::ops::Range;

/// The pair in two degrees of freedom, elastic angles q1 of the pinion and q2 of the face gear `[rad]` over time `[s]`.
///
/// I1 q1'' + r_b1 W = T1,   I2 q2'' - r_b2 W = -T2 - I2 θ2'',
/// W = c_m x' + k_m f(x),   x = r_b1 q1 - r_b2 q2 - e,   x' = r_b1 q1' - r_b2 q2' - r_b2' q2 - e'
///
/// f is the dead zone of half width b `[m]`. By default T1 = r_b1 (T2 + I2 θ2'')/r_b2 balances the rigid motion, and the model tends to
/// [`NfgPair`](crate::NfgPair) as 1/I1. Of the readings, radius and centre forcing apply; the rest has no counterpart here.
///
/// Channels of its own: `base radius` r_b2 and `elastic part` f(x), both `[m]`.
///
/// Under positive load the drive flank is the upper one.   Source: Liu 2021, Eq. (4), corrected.
///
/// ```
/// use gear_dynamics::{Model, NfgPair2, NfgParams};
/// let pair = NfgPair2::new(&NfgParams::table1(), 0.01)?;
/// assert_eq!((pair.dof(), pair.contacts()), (2, 1));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct NfgPair2 {
    params: NfgParams,
    pinion_inertia: f64,
    /// T1, if it does not balance the rigid motion.
    torque: Option<f64>,
    /// r_b1 `[m]`.
    pinion_radius: f64,
    /// L `[m]`.
    radius: f64,
    /// c_m [N s/m].
    damping: f64,
    centre: CentreCurve,
    stiffness: Fourier,
    error: Fourier,
    law: Backlash,
}

const STIFFNESS: usize = 0; // k_m [N/m]
const ERROR: usize = 1; // e [m]
const ERROR_RATE: usize = 2; // de/dx [m]
const RADIUS: usize = 3; // r_b2 [m]
const RADIUS_RATE: usize = 4; // dr_b2/dx [m]
const CENTRE: usize = 5; // θ2''/ω_c²
const PHASES: usize = 6;
const OMEGA: usize = 6; // ω_c [rad/s]
const DAMPING: usize = 7; // c_m [N s/m]
const LOAD: usize = 8; // T2 [N m]
const WIDTH: usize = 9; // b [m]
const DRIVES: usize = 10;

impl NfgPair2 {
    /// The exact reading, the pinion of inertia I1 [kg m²].
    ///
    /// # Errors
    /// A pinion inertia outside 1e-50 .. 1e50; every parameter out of its range, by the name of its field.
    pub fn new(params: &NfgParams, pinion_inertia: f64) -> Result<Self, ParameterError> {
        NfgPair2::with_reading(params, pinion_inertia, NfgReading::exact())
    }

    /// Radius and centre forcing as read.
    ///
    /// # Errors
    /// As [`new`](NfgPair2::new).
    pub fn with_reading(params: &NfgParams, pinion_inertia: f64, reading: NfgReading) -> Result<Self, ParameterError> {
        params.check()?;
        let cos = libm::cos(params.pressure_angle);
        let (radius, pinion_radius) = match reading.radius {
            Radius::Base => (params.mean_base_radius(), params.pinion_pitch_radius() * cos),
            Radius::Pitch => (params.mean_pitch_radius(), params.pinion_pitch_radius()),
        };
        let centre = InstantCentre::new(params.eccentric_ratio, 1.0)?;
        let mean_square = 1.0 + 0.5 * params.beta() * params.beta();
        let natural = params.check_derived(radius, reading)?;
        Ok(NfgPair2 {
            pinion_inertia: check::scale("pinion inertia", pinion_inertia)?,
            torque: None,
            pinion_radius,
            radius,
            damping: 2.0 * params.damping_ratio * params.inertia * natural / (radius * radius * mean_square),
            centre: match reading.centre_forcing {
                CentreForcing::Exact => centre.forcing(),
                CentreForcing::Series(order) => centre.forcing_series(order as usize)?,
            },
            stiffness: Fourier::new(params.stiffness, &params.stiffness_harmonics, params.face_gear_teeth().round())?,
            error: Fourier::new(params.error, &params.error_harmonics, params.face_gear_teeth().round())?,
            law: Backlash::new(params.half_backlash)?,
            params: params.clone(),
        })
    }

    /// A constant torque T1 [N m] on the pinion in place of the one that balances the rigid motion.
    ///
    /// # Errors
    /// A torque beyond ±1e50.
    pub fn with_torque(self, torque: f64) -> Result<Self, ParameterError> {
        Ok(NfgPair2 { torque: Some(check::quantity("torque on the pinion", torque)?), ..self })
    }

    /// r_b1 `[m]`.
    pub fn pinion_radius(&self) -> f64 {
        self.pinion_radius
    }
    /// c_m [N s/m].
    pub fn damping(&self) -> f64 {
        self.damping
    }

    /// At t = 0: the pinion at q1 = 0, the face gear at rest on the drive flank.
    ///
    /// # Errors
    /// A mesh stiffness that is not positive at the start.
    pub fn static_start(&self) -> Result<State, ParameterError> {
        let mut u = [0.0; DRIVES];
        self.drive(0.0, Side::After, &mut u);
        let stiffness = check::positive("mesh stiffness at the start", u[STIFFNESS])?;
        let deflection = u[WIDTH] + u[LOAD] / (u[RADIUS] * stiffness);
        // q = q2 + e/r_b2 is at rest, so q2' takes up the rate of the error, as in the model of one degree of freedom.
        let stretch = u[RADIUS_RATE] / u[RADIUS];
        let q2 = -(deflection + u[ERROR]) / u[RADIUS];
        let v2 = -u[OMEGA] * (u[ERROR_RATE] - u[ERROR] * stretch) / u[RADIUS];
        let start = State::new(0.0, &[0.0, q2], &[0.0, v2]);
        start.check(2)?;
        Ok(start)
    }

    /// x, x' and r_b2' over time.
    #[inline(always)]
    fn deflection<S: Scalar>(&self, u: &[S], q: &[S], v: &[S]) -> (S, S) {
        let x = q[0] * self.pinion_radius - u[RADIUS] * q[1] - u[ERROR];
        let rate = v[0] * self.pinion_radius - u[RADIUS] * v[1] - u[OMEGA] * (u[RADIUS_RATE] * q[1] + u[ERROR_RATE]);
        (x, rate)
    }

    #[inline(always)]
    fn force<S: Scalar, L: Law<S>>(&self, law: &L, u: &[S], x: S, rate: S) -> S {
        u[DAMPING] * rate + u[STIFFNESS] * law.force(0, &self.law, x, rate, -u[WIDTH], u[WIDTH])
    }
}

impl Generic for NfgPair2 {
    #[inline(always)]
    fn accel_on<S: Scalar, L: Law<S>>(&self, law: &L, u: &[S], q: &[S], v: &[S], a: &mut [S]) {
        let (x, rate) = self.deflection(u, q, v);
        let w = self.force(law, u, x, rate);
        let inertia = S::from(self.params.inertia);
        let turning = u[LOAD] + inertia * u[OMEGA] * u[OMEGA] * u[CENTRE];
        let torque = match self.torque {
            Some(torque) => S::from(torque),
            None => turning * self.pinion_radius / u[RADIUS],
        };
        a[0] = (torque - w * self.pinion_radius) * (1.0 / self.pinion_inertia);
        a[1] = (u[RADIUS] * w - turning) * (1.0 / self.params.inertia);
    }

    #[inline(always)]
    fn contact_on<S: Scalar>(&self, _: Range<usize>, u: &[S], q: &[S], v: &[S], out: &mut [Contact<S>]) -> bool {
        let (deflection, rate) = self.deflection(u, q, v);
        let force = self.force(&AsIs, u, deflection, rate);
        out[0] = Contact { deflection, rate, lower: -u[WIDTH], upper: u[WIDTH], force, ..Contact::default() };
        true
    }

    fn phases(&self) -> usize {
        PHASES
    }
    fn phase_drives(&self, phase: f64, side: Side, u: &mut [f64]) {
        let (s, c) = libm::sincos(phase);
        let beta = self.params.beta();
        let error: Jet = self.error.jet(phase, side);
        u[STIFFNESS] = self.stiffness.value(phase, side);
        u[ERROR] = error.value;
        u[ERROR_RATE] = error.rate;
        u[RADIUS] = self.radius * (1.0 + beta * c);
        u[RADIUS_RATE] = -self.radius * beta * s;
        u[CENTRE] = self.centre.value(phase, side);
    }
    fn constants(&self, u: &mut [f64]) {
        u[OMEGA] = self.params.centre_frequency();
        u[DAMPING] = self.damping;
        u[LOAD] = self.params.load_torque;
        u[WIDTH] = self.params.half_backlash;
    }
    fn at_speed(&self, speed: f64, u: &mut [f64]) {
        u[OMEGA] = speed;
    }
    fn shares_lanes_with(&self, other: &Self) -> bool {
        self.pinion_inertia == other.pinion_inertia
            && self.torque == other.torque
            && self.pinion_radius == other.pinion_radius
            && self.radius == other.radius
            && self.params.inertia == other.params.inertia
            && self.centre == other.centre
            && self.stiffness == other.stiffness
            && self.error == other.error
    }
}

impl Model for NfgPair2 {
    fn dof(&self) -> usize {
        2
    }
    #[inline]
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.accel_on(&AsIs, u, q, v, a);
    }
    fn drives(&self) -> usize {
        DRIVES
    }
    #[inline]
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.phase_drives(self.params.centre_frequency() * t, side, u);
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
        vec![Channel::new("base radius", "m"), Channel::new("elastic part", "m")]
    }
    fn observe(&self, u: &[f64], q: &[f64], v: &[f64], _: &[Contact], out: &mut [f64]) {
        let (x, rate) = self.deflection(u, q, v);
        out[0] = u[RADIUS];
        out[1] = AsIs.force(0, &self.law, x, rate, -u[WIDTH], u[WIDTH]);
    }
}

impl Periodic for NfgPair2 {
    /// One turn of the face gear `[s]`.
    fn period(&self) -> f64 {
        TAU / self.params.centre_frequency()
    }
}
