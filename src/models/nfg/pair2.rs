//! Two degrees of freedom: Eq. (4).

use crate::contact::choice::{ByDeflection, PieceChoice};
use crate::contact::laws::backlash::Backlash;
use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::contact::mesh::{LOWER, Mesh, UPPER};
use crate::contact::tooth::Contact;
use crate::error::{ParameterError, check};
use crate::excitation::angle::Excitation;
use crate::excitation::centre::{CentreCurve, InstantCentre};
use crate::excitation::fourier::Fourier;
use crate::excitation::side::Side;
use crate::excitation::wave::{Wave, reduced};
use crate::model::equations::{Channel, Model, State};
use crate::model::machine::Machine;
use crate::model::shape::{Drives, Shape, Size};
use crate::models::nfg::params::{CentreForcing, NfgParams, NfgReading, Radius};
use crate::scalar::Scalar;

/// The pair in two degrees of freedom, elastic angles q1 of the pinion and q2 of the face gear `[rad]` over time `[s]`.
///
/// I1 q1'' + r_b1 W = T1,   I2 q2'' - r_b2 W = -T2 - I2 θ2'',
/// W = c_m x' + k_m f(x),   x = r_b1 q1 - r_b2 q2 - e,   x' = r_b1 q1' - r_b2 q2' - r_b2' q2 - e'
///
/// f is the dead zone of half width b `[m]`. By default T1 = r_b1 (T2 + I2 θ2'')/r_b2 balances the rigid motion, and the model tends to
/// [`NfgPair`](crate::NfgPair) as 1/I1. Of the readings, radius and centre forcing apply; the rest has no counterpart here.
///
/// Constants: `speed` ω1 [rad/s], `load torque` T2 [N m], `mesh damping` c_m [N s/m], `inertia` I2 and `pinion inertia` I1 [kg m²],
/// `half backlash` b `[m]`, if the law is [`Backlash`].
///
/// Channels of its own: `base radius` r_b2 and `elastic part` f(x), both `[m]`.
///
/// Under positive load the drive flank is the upper one.   Source: Liu 2021, Eq. (4), corrected.
///
/// ```
/// use gear_dynamics::{Model, NfgParams, models::nfg::NfgPair2};
/// let pair = NfgPair2::new(&NfgParams::table1(), 0.01)?;
/// assert_eq!((pair.dof(), pair.contacts()), (2, 1));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
pub type NfgPair2<N = Backlash> = Machine<NfgShape2<N>>;

/// What all pairs of two degrees of freedom share that run in lanes.
///
/// ```
/// use gear_dynamics::{models::nfg::NfgPair2, NfgParams};
/// let pair = NfgPair2::new(&NfgParams::table1(), 0.01)?;
/// assert!((pair.shape().pinion_radius() - 0.021_143_08).abs() < 1e-8);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct NfgShape2<N = Backlash> {
    /// T1, if it does not balance the rigid motion.
    torque: Option<f64>,
    /// r_b1 `[m]`.
    pinion_radius: f64,
    /// L `[m]`.
    radius: f64,
    beta: f64,
    ratio: f64,
    /// dθ2/dx.
    rotation: CentreCurve,
    mesh: Mesh<N>,
}

// Waves: those of the mesh, then the gear.
const RADIUS: usize = 7; // r_b2 [m]
const RADIUS_RATE: usize = 8; // dr_b2/dx [m]
const ROTATION: usize = 9; // dθ2/dx
const CENTRE: usize = 10; // d²θ2/dx²
const WAVES: usize = 11;

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
    pub fn with_reading(
        params: &NfgParams,
        pinion_inertia: f64,
        reading: NfgReading,
    ) -> Result<Self, ParameterError> {
        params.check()?;
        let stiffness = Wave::new(Fourier::new(params.stiffness, &params.stiffness_harmonics)?);
        let error = Wave::new(Fourier::new(params.error, &params.error_harmonics)?);
        // The half width is a constant: the shape is the same for all.
        let mesh = Mesh::new(stiffness, error, Backlash::new(0.0)?);
        NfgPair2::made(params, pinion_inertia, reading, mesh, params.half_backlash)
    }
}

impl<N: Nonlinearity> NfgPair2<N> {
    /// Stiffness [N/m], transmission error `[m]` and contact law of one's own, in place of those of the parameters: waves of the mesh phase, one
    /// turn for a tooth.
    ///
    /// # Errors
    /// As [`new`](NfgPair2::new).
    pub fn with_mesh(
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
        let cos = libm::cos(params.pressure_angle);
        let (radius, pinion_radius) = match reading.radius {
            Radius::Base => (params.mean_base_radius(), params.pinion_pitch_radius() * cos),
            Radius::Pitch => (params.mean_pitch_radius(), params.pinion_pitch_radius()),
        };
        let centre = InstantCentre::new(params.eccentric_ratio)?;
        let mean_square = 1.0 + 0.5 * params.beta() * params.beta();
        let natural = params.check_derived(radius, reading)?;
        let damping = 2.0 * params.damping_ratio * params.inertia * natural / (radius * radius * mean_square);
        let shape = NfgShape2 {
            torque: None,
            pinion_radius,
            radius,
            beta: params.beta(),
            ratio: params.ratio,
            rotation: match reading.centre_forcing {
                CentreForcing::Exact => centre.rotation(),
                CentreForcing::Series(order) => centre.rotation_series(order as usize)?,
            },
            mesh: mesh.per_turn(params.face_gear_teeth().round() as u32)?,
        };
        let constants = [
            ("speed", params.speed),
            ("load torque", params.load_torque),
            ("mesh damping", damping),
            ("inertia", params.inertia),
            ("pinion inertia", pinion_inertia),
            ("half backlash", half_backlash),
        ];
        Machine::with_constants(shape, if N::HALF_WIDTH { &constants } else { &constants[..5] })
    }

    /// A constant torque T1 [N m] on the pinion in place of the one that balances the rigid motion.
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

    /// c_m [N s/m].
    pub fn damping(&self) -> f64 {
        self.constants()[2]
    }

    /// At t = 0: the pinion at q1 = 0, the face gear at rest on the drive flank, for a law of slope 1 on its flanks.
    ///
    /// # Errors
    /// A mesh stiffness that is not positive at the start; a law with a lower flank alone, since the load rests on the upper one. A law without edges
    /// carries at 0.
    pub fn static_start(&self) -> Result<State, ParameterError> {
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
        // q = q2 + e/r_b2 is at rest, so q2' takes up the rate of the error, as in the model of one degree of freedom.
        let stretch = radius_rate / radius;
        let q2 = -(deflection + error) / radius;
        let v2 = -u.speed() * (error_rate - error * stretch) / radius;
        let start = State::new(0.0, &[0.0, q2], &[0.0, v2]);
        start.check(2)?;
        Ok(start)
    }
}

impl<N: Nonlinearity> NfgShape2<N> {
    /// r_b1 `[m]`.
    pub fn pinion_radius(&self) -> f64 {
        self.pinion_radius
    }

    /// The waves of the mesh, the edges those of the constant half backlash if the law has it from there.
    #[inline(always)]
    fn mesh_waves<S: Scalar>(&self, u: Drives<'_, S>) -> [S; 7] {
        let (mut waves, [_, _, _, _, _, width]) = (u.waves(), u.constants());
        if N::HALF_WIDTH {
            (waves[LOWER], waves[UPPER]) = (-width, width);
        }
        waves
    }
}

impl<N: Nonlinearity> Shape for NfgShape2<N> {
    #[inline(always)]
    fn size(&self) -> Size {
        Size { dof: 2, waves: WAVES, contacts: 1, constants: if N::HALF_WIDTH { 7 } else { 6 } }
    }
    fn constants(&self) -> Vec<Channel> {
        let constants = [
            ("speed", "rad/s"),
            ("load torque", "N m"),
            ("mesh damping", "N s/m"),
            ("inertia", "kg m²"),
            ("pinion inertia", "kg m²"),
            ("half backlash", "m"),
        ];
        let count = if N::HALF_WIDTH { 6 } else { 5 };
        constants[..count].iter().map(|(name, unit)| Channel::new(*name, *unit)).collect()
    }
    fn check(&self, constants: &[f64]) -> Result<(), ParameterError> {
        check::scale("speed", constants[0])?;
        check::not_negative("load torque", constants[1])?;
        check::not_negative("mesh damping", constants[2])?;
        check::scale("inertia", constants[3])?;
        check::scale("pinion inertia", constants[4])?;
        constants[5..].iter().try_for_each(|b| check::not_negative("half backlash", *b).map(drop))
    }
    /// ω_c = ω1/i_j [rad/s], T2, c_m, I2, 1/I2, 1/I1, b.
    fn prepare<S: Scalar>(&self, constants: &[S]) -> Vec<S> {
        let &[speed, load, damping, inertia, pinion_inertia, ref half_backlash @ ..] = constants else {
            return Vec::new();
        };
        let one = S::from(1.0);
        let mut prepared =
            vec![speed / S::from(self.ratio), load, damping, inertia, one / inertia, one / pinion_inertia];
        prepared.extend(half_backlash);
        prepared
    }

    #[inline(always)]
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let (waves, omega, [load, _, inertia, per_inertia, per_pinion]) =
            (u.all_waves(), u.speed(), u.constants());
        let w = self.contact(law, 0, u, q, v).force;
        let turning = load + inertia * (omega * omega * waves[CENTRE] + u.acceleration() * waves[ROTATION]);
        let torque = match self.torque {
            Some(torque) => S::from(torque),
            None => turning * self.pinion_radius / waves[RADIUS],
        };
        a[0] = (torque - w * self.pinion_radius) * per_pinion;
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
        self.mesh.contact(law, i, &self.mesh_waves(u), omega, damping, x, rate)
    }

    fn waves(&self, phase: f64, side: Side, u: &mut [f64]) {
        let ((s, c), rotation) = (libm::sincos(phase), self.rotation.jet(reduced(phase)));
        self.mesh.waves(phase, side, u);
        u[RADIUS] = self.radius * (1.0 + self.beta * c);
        u[RADIUS_RATE] = -self.radius * self.beta * s;
        (u[ROTATION], u[CENTRE]) = (rotation.value, rotation.rate);
    }
    fn next_edge(&self, phase: f64) -> Option<f64> {
        self.mesh.next_edge(phase)
    }

    fn channels(&self) -> Vec<Channel> {
        vec![Channel::new("base radius", "m"), Channel::new("elastic part", "m")]
    }
    fn observe(&self, u: Drives<'_, f64>, _: &[f64], _: &[f64], contacts: &[Contact], out: &mut [f64]) {
        let contact = contacts[0];
        out[0] = u.all_waves()[RADIUS];
        out[1] = ByDeflection.force(
            0,
            self.mesh.law(),
            contact.deflection,
            contact.rate,
            contact.lower,
            contact.upper,
        );
    }
}
