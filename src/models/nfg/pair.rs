//! The noncircular face gear pair with one degree of freedom.   Source: Liu 2021, Eq. (9).

use crate::contact::choice::{ByDeflection, PieceChoice};
use crate::contact::laws::backlash::Backlash;
use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::contact::mesh;
use crate::contact::mesh::{Mesh, MeshDrives};
use crate::contact::tooth::Contact;
use crate::error::{ParameterError, check};
use crate::excitation::angle::Excitation;
use crate::excitation::centre::{CentreCurve, InstantCentre};
use crate::excitation::fourier::Fourier;
use crate::excitation::jet::Jet;
use crate::excitation::side::Side;
use crate::excitation::wave::{Wave, reduced};
use crate::model::equations::{Channel, Model, State};
use crate::model::machine::Machine;
use crate::model::shape::{Drives, Shape, Size};
use crate::models::nfg::params::{
    CentreForcing, Damping, ErrorForcing, HalfWidth, NfgParams, NfgReading, Radius,
};
use crate::scalar::Scalar;

/// The noncircular face gear pair with one degree of freedom. The speed of the pinion is prescribed.
///
/// q'' + 2 ζ D (q' + (r'/r) q) + F f(q) = -B0 - θ2'' + ē''.   Source: Liu 2021, Eq. (9), corrected.
///
/// - The time is τ = ω_n t `[1]`; a prime is a derivative over τ.
/// - The coordinate is q = q2 + e/r_b2 `[rad]`, with the elastic angle q2 of the face gear.
/// - x = (ω_c/ω_n) τ is the phase of the instantaneous centre; ē = e/r_b2 `[rad]`; r is r_b2.
/// - F = (k_m/k0) (1 + β cos x)²/(1 + β²/2) and B0 = T2/(I2 ω_n²).
/// - f is the contact law, by default the dead zone of half width b̄ `[rad]`.
/// - [`NfgReading`] selects the forms of b̄, D, r'/r, θ2'' and ē''.
///
/// If the speed varies ([`VaryingSpeed`](crate::drives::VaryingSpeed)), θ2'' and ē'' contain a term in x'' in
/// addition to the term in x'².
///
/// Constants: `speed` ω1 [rad/s], `load torque` T2 [N m], `inertia` I2 [kg m²], `stiffness` k0 [N/m],
/// `damping ratio` ζ `[1]` and, if the law is a [`Backlash`], `half backlash` b `[m]`, half of the backlash.
/// The shape stores k_m/k0, so k_m is proportional to the constant k0.
///
/// The contact has the deflection r_b2 q `[m]`, the edges ∓r_b2 b̄ `[m]` and a mesh force `[N]`. Under
/// positive load the drive flank is the lower flank. Own channels: `base radius` r_b2 `[m]` and
/// `elastic part` f(q) `[rad]`, q less the gap.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, analysis::Probe, excitation::Side};
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
pub type NfgPair<N = Backlash> = Machine<NfgShape<N>>;

/// The shape of [`NfgPair`]: reading, geometry, waves of the mesh and contact law. Pairs of equal shape share
/// lanes.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, Shape};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// assert_eq!(pair.shape().size().waves, 6);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct NfgShape<N = Backlash> {
    reading: NfgReading,
    /// Mean radius L `[m]`.
    radius: f64,
    /// Reduction ratio i_j `[1]`.
    ratio: f64,
    /// β = 2 ε/(1 + ε²) `[1]`.
    beta: f64,
    /// Number of teeth of the face gear Z2.
    teeth: f64,
    /// dθ2/dx.
    rotation: CentreCurve,
    /// k_m/k0 `[1]` and e `[m]` over x, with Z2 periods in 2π, and the contact law.
    mesh: Mesh<N>,
    /// Whether the lower and the upper edge of the law are infinite.
    missing: [bool; 2],
    /// Fourier series of k_m/k0 and of e, if the parameters give both as harmonics. One sine and cosine of
    /// the mesh phase then serve both.
    series: Option<[Fourier; 2]>,
}

// Indices of the waves.
const STIFFNESS: usize = 0; // F
const RADIUS: usize = 1; // r_b2/L
const INVERSE: usize = 2; // L/r_b2: in lanes a multiplication is faster than a division
const STRETCH: usize = 3; // (dr_b2/dx)/r_b2
const FORCING: usize = 4; // d²(θ2 - ē)/dx²
const FORCING_RATE: usize = 5; // d(θ2 - ē)/dx
const WAVES: usize = 6;
// Indices of the further waves of a law other than `Backlash`: its edges [m] and their rates over x.
const LOWER: usize = WAVES;
const UPPER: usize = WAVES + 1;
const LOWER_RATE: usize = WAVES + 2;
const UPPER_RATE: usize = WAVES + 3;
const ALL_WAVES: usize = WAVES + 4;

/// Quantities of the algebra that depend on the drives alone.
struct At<S> {
    /// Argument of the contact law per q: 1 for a [`Backlash`], otherwise the radius r_b2 or L [m/rad].
    unit: S,
    /// 1/unit.
    per_unit: S,
    /// unit'/unit.
    unit_stretch: S,
    /// Edges in the unit of the argument.
    lower: S,
    upper: S,
    /// Rates of the edges over τ.
    lower_rate: S,
    upper_rate: S,
    /// 2 ζ D.
    damping: S,
    /// r'/r, or 0 at a constant damping ratio.
    stretch: S,
}

impl NfgPair {
    /// The pair of the [exact reading](NfgReading::exact).
    ///
    /// # Errors
    /// A [`ParameterError`] that names the first field outside its range, or a derived quantity that is
    /// outside its range or overflows.
    pub fn new(params: &NfgParams) -> Result<Self, ParameterError> {
        NfgPair::with_reading(params, NfgReading::exact())
    }

    /// The pair of a given reading.
    ///
    /// # Errors
    /// As [`new`](NfgPair::new).
    pub fn with_reading(params: &NfgParams, reading: NfgReading) -> Result<Self, ParameterError> {
        params.check()?;
        let over_mean: Vec<_> = params
            .stiffness_harmonics
            .iter()
            .map(|[c, s]| [c / params.stiffness, s / params.stiffness])
            .collect();
        let series = [Fourier::new(1.0, &over_mean)?, Fourier::new(params.error, &params.error_harmonics)?];
        let [stiffness, error] = series.clone().map(Wave::new);
        // The half backlash is a constant of the machine. With 0 in the shape, pairs of different half
        // backlash have equal shapes.
        let mesh = Mesh::new(stiffness, error, Backlash::new(0.0)?);
        NfgPair::made(params, reading, mesh, params.half_backlash, Some(series))
    }
}

impl NfgPair {
    /// b/L `[rad]`, the half width of the dead zone at the mean radius; b is half of the backlash.
    pub fn half_width(&self) -> f64 {
        self.prepared_constants()[5]
    }
}

impl<N: Nonlinearity> NfgPair<N> {
    /// The pair with a given mesh stiffness k_m [N/m], transmission error e `[m]` and contact law, in place
    /// of those of the parameters.
    ///
    /// Stiffness and error are waves of the mesh phase; 2π is one tooth. The law receives deflections in
    /// metres and rates in metres per second. The half width of a [`Backlash`] becomes the constant
    /// `half backlash`. ω_n and the constant `stiffness` still follow from k0 of the parameters.
    ///
    /// # Errors
    /// As [`new`](NfgPair::new).
    pub fn with_mesh(params: &NfgParams, reading: NfgReading, mesh: Mesh<N>) -> Result<Self, ParameterError> {
        params.check()?;
        let half_backlash =
            if N::HALF_WIDTH { mesh.law().edges(0.0, Side::After).upper } else { params.half_backlash };
        NfgPair::made(params, reading, mesh.scaled(1.0 / params.stiffness)?, half_backlash, None)
    }

    fn made(
        params: &NfgParams,
        reading: NfgReading,
        mesh: Mesh<N>,
        half_backlash: f64,
        series: Option<[Fourier; 2]>,
    ) -> Result<Self, ParameterError> {
        let radius = match reading.radius {
            Radius::Base => params.mean_base_radius(),
            Radius::Pitch => params.mean_pitch_radius(),
        };
        params.check_derived(radius, reading)?;
        let edges = mesh.law().edges(0.0, Side::After);
        let (centre, teeth) = (InstantCentre::new(params.eccentric_ratio)?, params.face_gear_teeth().round());
        let shape = NfgShape {
            reading,
            radius,
            ratio: params.ratio,
            beta: params.beta(),
            teeth,
            rotation: match reading.centre_forcing {
                CentreForcing::Exact => centre.rotation(),
                CentreForcing::Series(order) => centre.rotation_series(order as usize)?,
            },
            missing: [edges.lower == f64::NEG_INFINITY, edges.upper == f64::INFINITY],
            mesh: mesh.per_turn(teeth as u32)?,
            series,
        };
        let NfgParams { speed, load_torque, inertia, stiffness, damping_ratio, .. } = *params;
        let constants = [
            ("speed", speed),
            ("load torque", load_torque),
            ("inertia", inertia),
            ("stiffness", stiffness),
            ("damping ratio", damping_ratio),
            ("half backlash", half_backlash),
        ];
        Machine::with_constants(shape, if N::HALF_WIDTH { &constants } else { &constants[..5] })
    }

    /// The reading of the equations.
    pub fn reading(&self) -> NfgReading {
        self.shape().reading
    }
    /// Mean radius L `[m]`: base or pitch radius, as the reading selects.
    pub fn mean_radius(&self) -> f64 {
        self.shape().radius
    }
    /// Natural frequency ω_n = L √(k0 (1 + β²/2)/I2) [rad/s]; τ = ω_n t.   Source: Liu 2021, Eq. (10).
    pub fn natural_frequency(&self) -> f64 {
        let constants = self.constants();
        self.shape().natural(constants[2], constants[3])
    }
    /// Frequency of the instantaneous centre over the natural frequency, ω_c/ω_n `[1]`.
    pub fn centre_frequency(&self) -> f64 {
        self.speed()
    }

    /// The state at rest on the drive flank at τ = 0: q = -b̄ - B0/F, q' = 0. The formula assumes a law of
    /// slope 1 on its lower flank. For a law without edges it is q = -B0/F.
    ///
    /// # Errors
    /// A mesh stiffness at τ = 0 that is not positive. [`ParameterError::NoFlank`] if the law has an upper
    /// flank only, because a positive load acts on the lower flank.
    pub fn static_start(&self) -> Result<State, ParameterError> {
        if self.shape().missing == [true, false] {
            return Err(ParameterError::NoFlank { flank: "lower" });
        }
        let mut u = vec![0.0; self.drives()];
        self.drive(0.0, Side::After, &mut u);
        let u = Drives::new(self.size().waves, &u);
        let at = self.shape().at(u);
        let [_, load] = u.constants();
        let load = load / check::positive("mesh stiffness at the start", u.all_waves()[STIFFNESS])?;
        let start = State::new(
            0.0,
            &[if self.shape().missing[0] { 0.0 } else { at.lower * at.per_unit } - load],
            &[0.0],
        );
        start.check(1)?;
        Ok(start)
    }
}

impl<N: Nonlinearity> NfgShape<N> {
    /// ω_n = L √(k0 (1 + β²/2)/I2) [rad/s] from the inertia I2 and the mean stiffness k0.
    fn natural<S: Scalar>(&self, inertia: S, stiffness: S) -> S {
        (stiffness * self.radius * self.radius * (1.0 + 0.5 * self.beta * self.beta) / inertia).sqrt()
    }

    #[inline(always)]
    fn at<S: Scalar>(&self, u: Drives<'_, S>) -> At<S> {
        let (waves, omega, zero, one) = (u.all_waves(), u.speed(), S::from(0.0), S::from(1.0));
        let [damping, _, _, _, width] = u.constants();
        let (inverse, rho_stretch) = (waves[INVERSE], waves[STRETCH] * omega);
        let mean = matches!(self.reading.half_width, HalfWidth::Mean);
        let (damping, stretch) = match self.reading.damping {
            Damping::ConstantRatio => (damping, zero),
            Damping::ConstantCoefficient => (
                damping * waves[RADIUS] * waves[RADIUS] * (1.0 / (1.0 + 0.5 * self.beta * self.beta)),
                rho_stretch,
            ),
        };
        if N::HALF_WIDTH {
            // f(c x; c b) = c f(x; b) for a dead zone. Its argument therefore is q itself.
            let (width, rate) =
                if mean { (width, zero) } else { (width * inverse, -(width * inverse * rho_stretch)) };
            let (unit, per_unit, unit_stretch) = (one, one, zero);
            return At {
                unit,
                per_unit,
                unit_stretch,
                lower: -width,
                upper: width,
                lower_rate: -rate,
                upper_rate: rate,
                damping,
                stretch,
            };
        }
        let (unit, per_unit, unit_stretch) = if mean {
            (S::from(self.radius), S::from(1.0 / self.radius), zero)
        } else {
            (waves[RADIUS] * self.radius, inverse * (1.0 / self.radius), rho_stretch)
        };
        let (lower, upper) = (waves[LOWER], waves[UPPER]);
        let (lower_rate, upper_rate) = (waves[LOWER_RATE] * omega, waves[UPPER_RATE] * omega);
        At { unit, per_unit, unit_stretch, lower, upper, lower_rate, upper_rate, damping, stretch }
    }

    /// Argument of the contact law and its rate: q and q' for a [`Backlash`], otherwise `[m]` and [m/s].
    #[inline(always)]
    fn deflection<S: Scalar>(&self, at: &At<S>, natural: S, q: S, v: S) -> (S, S) {
        if N::HALF_WIDTH { (q, v) } else { (at.unit * q, at.unit * (v + at.unit_stretch * q) * natural) }
    }

    /// 2 ζ D (q' + (r'/r) q) + F f(q), the acceleration by the mesh with reversed sign.
    #[inline(always)]
    fn tooth<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        at: &At<S>,
        u: Drives<'_, S>,
        q: S,
        v: S,
    ) -> S {
        let (stiffness, [_, _, _, natural]) = (u.all_waves()[STIFFNESS], u.constants());
        let (x, rate) = self.deflection(at, natural, q, v);
        let stiffness = if N::HALF_WIDTH { stiffness } else { stiffness * at.per_unit };
        let drives = MeshDrives { stiffness, damping: at.damping, lower: at.lower, upper: at.upper };
        self.mesh.force(law, i, x, rate, v + at.stretch * q, drives)
    }

    /// k_m/k0 and e with their derivatives over x.
    fn mesh_waves(&self, phase: f64, side: Side) -> [Jet; 2] {
        match &self.series {
            Some([stiffness, error]) => {
                let mesh = libm::sincos(self.teeth * phase);
                [stiffness.jet_of(mesh, self.teeth), error.jet_of(mesh, self.teeth)]
            }
            None => [self.mesh.stiffness().jet(phase, side), self.mesh.error().jet(phase, side)],
        }
    }
}

impl<N: Nonlinearity> Shape for NfgShape<N> {
    #[inline(always)]
    fn size(&self) -> Size {
        Size {
            dof: 1,
            waves: if N::HALF_WIDTH { WAVES } else { ALL_WAVES },
            contacts: 1,
            constants: if N::HALF_WIDTH { 6 } else { 5 },
        }
    }
    fn constants(&self) -> Vec<Channel> {
        let constants = [
            ("speed", "rad/s"),
            ("load torque", "N m"),
            ("inertia", "kg m²"),
            ("stiffness", "N/m"),
            ("damping ratio", "1"),
            ("half backlash", "m"),
        ];
        let count = if N::HALF_WIDTH { 6 } else { 5 };
        constants[..count].iter().map(|(name, unit)| Channel::new(*name, *unit)).collect()
    }
    fn check(&self, constants: &[f64]) -> Result<(), ParameterError> {
        check::scale("speed", constants[0])?;
        check::not_negative("load torque", constants[1])?;
        check::scale("inertia", constants[2])?;
        check::scale("stiffness", constants[3])?;
        check::not_negative("damping ratio", constants[4])?;
        constants[5..].iter().try_for_each(|b| check::not_negative("half backlash", *b).map(drop))
    }
    /// Returns ω_c/ω_n, 2 ζ, B0, I2 ω_n²/L, ω_n and, for a [`Backlash`], b/L.
    fn prepare<S: Scalar>(&self, constants: &[S]) -> Vec<S> {
        let &[speed, load, inertia, stiffness, damping, ref half_backlash @ ..] = constants else {
            return Vec::new();
        };
        let natural = self.natural(inertia, stiffness);
        let radius = S::from(self.radius);
        let mut prepared = vec![
            speed / S::from(self.ratio) / natural,
            S::from(2.0) * damping,
            load / (inertia * natural * natural),
            inertia * natural * natural / radius,
            natural,
        ];
        prepared.extend(half_backlash.iter().map(|b| *b / radius));
        prepared
    }

    #[inline(always)]
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let (at, waves, omega) = (self.at(u), u.all_waves(), u.speed());
        let [_, load] = u.constants();
        let forcing = -load - omega * omega * waves[FORCING] - u.acceleration() * waves[FORCING_RATE];
        a[0] = forcing - self.tooth(law, 0, &at, u, q[0], v[0]);
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
        let (at, waves) = (self.at(u), u.all_waves());
        let [_, _, mesh_force] = u.constants();
        // The contact in metres: d = r_b2 q, d' = r_b2 q' + r_b2' q, and likewise for the edges.
        let r = waves[RADIUS] * self.radius;
        let r_rate = r * waves[STRETCH] * u.speed();
        let per_unit_rate = -(at.per_unit * at.unit_stretch);
        let edge = |x: S, rate: S, missing: bool| {
            if missing {
                return (x, S::from(0.0));
            }
            let (x, rate) = if N::HALF_WIDTH {
                (x, rate)
            } else {
                (x * at.per_unit, rate * at.per_unit + x * per_unit_rate)
            };
            (r * x, r_rate * x + r * rate)
        };
        let (lower, lower_rate) = edge(at.lower, at.lower_rate, self.missing[0]);
        let (upper, upper_rate) = edge(at.upper, at.upper_rate, self.missing[1]);
        let force = self.tooth(law, i, &at, u, q[0], v[0]) * mesh_force * waves[INVERSE];
        Contact {
            deflection: r * q[0],
            rate: r * v[0] + r_rate * q[0],
            lower,
            upper,
            lower_rate,
            upper_rate,
            force,
        }
    }

    fn waves(&self, phase: f64, side: Side, u: &mut [f64]) {
        let (s, c) = libm::sincos(phase);
        let rho = Jet::new(1.0 + self.beta * c, -self.beta * s, -self.beta * c);
        let [stiffness, error] = self.mesh_waves(phase, side);
        let rotation = self.rotation.jet(reduced(phase));
        u[STIFFNESS] = stiffness.value * rho.value * rho.value / (1.0 + 0.5 * self.beta * self.beta);
        u[RADIUS] = rho.value;
        u[INVERSE] = 1.0 / rho.value;
        u[STRETCH] = rho.rate / rho.value;
        let [error_rate, error_second] = match self.reading.error_forcing {
            ErrorForcing::MeanRadius => [error.rate, error.second],
            ErrorForcing::Frozen => [error.rate / rho.value, error.second / rho.value],
            ErrorForcing::Exact => {
                let over = error / rho;
                [over.rate, over.second]
            }
        };
        u[FORCING] = rotation.rate - error_second / self.radius;
        u[FORCING_RATE] = rotation.value - error_rate / self.radius;
        if !N::HALF_WIDTH {
            self.mesh.edges(phase, side, &mut u[WAVES - mesh::LOWER..]);
        }
    }
    fn next_edge(&self, phase: f64) -> Option<f64> {
        self.mesh.next_edge(phase)
    }

    fn channels(&self) -> Vec<Channel> {
        vec![Channel::new("base radius", "m"), Channel::new("elastic part", "rad")]
    }
    fn observe(&self, u: Drives<'_, f64>, q: &[f64], v: &[f64], _: &[Contact], out: &mut [f64]) {
        let at = self.at(u);
        let [_, _, _, natural] = u.constants();
        let (x, rate) = self.deflection(&at, natural, q[0], v[0]);
        out[0] = self.radius * u.all_waves()[RADIUS];
        out[1] = at.per_unit * ByDeflection.force(0, self.mesh.law(), x, rate, at.lower, at.upper);
    }
}
