//! The equations of the noncircular face gear pair with one degree of freedom.   Source: Liu 2021, Eq. (9).

use crate::contact::{Backlash, Contact, Deflection, Mesh, Nonlinearity, PieceChoice, mesh};
use crate::error::ParameterError;
use crate::excitation::{Angle, Fourier, Jet, Side};
use crate::model::{Channel, Drives, Shape, Size};
use crate::models::nfg::constants::{Constants, Range};
use crate::models::nfg::face_gear::FaceGear;
use crate::models::nfg::nfg_params::{Damping, ErrorForcing, HalfBacklash, NfgReading};
use crate::scalar::Scalar;

/// The shape of [`NfgPair`](crate::NfgPair): reading, geometry, waves of the mesh and contact law. Pairs of
/// equal shape share lanes.
///
/// ```
/// use gear_dynamics::{NfgPair, NfgParams, Shape};
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// assert_eq!(pair.shape().size().waves, 6);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct NfgShape<N = Backlash> {
    pub(crate) reading: NfgReading,
    pub(crate) gear: FaceGear,
    /// k_m/k0 `[1]` and e `[m]` over x, with Z2 periods in 2π, and the contact law.
    pub(crate) mesh: Mesh<N>,
    /// Whether the lower and the upper edge of the law are infinite.
    pub(crate) missing: [bool; 2],
    /// Fourier series of k_m/k0 and of e, if the parameters give both as harmonics. One sine and cosine of
    /// the mesh phase then serve both.
    pub(crate) series: Option<[Fourier; 2]>,
}

pub(crate) const CONSTANTS: Constants = Constants([
    ("speed", "rad/s", Range::Scale),
    ("load torque", "N m", Range::NotNegative),
    ("inertia", "kg m²", Range::Scale),
    ("stiffness", "N/m", Range::Scale),
    ("damping ratio", "1", Range::NotNegative),
    ("half backlash", "m", Range::NotNegative),
]);

// Indices of the waves.
pub(crate) const STIFFNESS: usize = 0; // F
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
pub(crate) struct At<S> {
    /// Argument of the contact law per q: 1 for a [`Backlash`], otherwise the radius r_b2 or L [m/rad].
    unit: S,
    /// 1/unit.
    pub(crate) per_unit: S,
    /// unit'/unit.
    unit_stretch: S,
    /// Edges in the unit of the argument.
    pub(crate) lower: S,
    upper: S,
    /// Rates of the edges over τ.
    lower_rate: S,
    upper_rate: S,
    /// 2 ζ D.
    damping: S,
    /// r'/r, or 0 at a constant damping ratio.
    stretch: S,
}

impl<N: Nonlinearity> NfgShape<N> {
    /// ω_n = L √(k0 (1 + β²/2)/I2) [rad/s] from the inertia I2 and the mean stiffness k0.
    pub(crate) fn natural<S: Scalar>(&self, inertia: S, stiffness: S) -> S {
        (stiffness * self.gear.radius * self.gear.radius * self.gear.mean_square() / inertia).sqrt()
    }

    #[inline(always)]
    pub(crate) fn at<S: Scalar>(&self, u: Drives<'_, S>) -> At<S> {
        let (waves, omega, zero, one) = (u.all_waves(), u.speed(), S::from(0.0), S::from(1.0));
        let [damping, _, _, _, width] = u.constants();
        let (inverse, rho_stretch) = (waves[INVERSE], waves[STRETCH] * omega);
        let mean = matches!(self.reading.half_backlash, HalfBacklash::Mean);
        let (damping, stretch) = match self.reading.damping {
            Damping::ConstantRatio => (damping, zero),
            Damping::ConstantCoefficient => {
                (damping * waves[RADIUS] * waves[RADIUS] * (1.0 / self.gear.mean_square()), rho_stretch)
            }
        };
        if N::HALF_BACKLASH {
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
            (S::from(self.gear.radius), S::from(1.0 / self.gear.radius), zero)
        } else {
            (waves[RADIUS] * self.gear.radius, inverse * (1.0 / self.gear.radius), rho_stretch)
        };
        let (lower, upper) = (waves[LOWER], waves[UPPER]);
        let (lower_rate, upper_rate) = (waves[LOWER_RATE] * omega, waves[UPPER_RATE] * omega);
        At { unit, per_unit, unit_stretch, lower, upper, lower_rate, upper_rate, damping, stretch }
    }

    /// What the contact law reads: q and q' for a [`Backlash`], otherwise `[m]` and [m/s].
    #[inline(always)]
    fn deflection<S: Scalar>(&self, at: &At<S>, natural: S, q: S, v: S) -> Deflection<S> {
        let (x, rate) = if N::HALF_BACKLASH {
            (q, v)
        } else {
            (at.unit * q, at.unit * (v + at.unit_stretch * q) * natural)
        };
        Deflection { d: x, rate, lower: at.lower, upper: at.upper }
    }

    /// 2 ζ D (q' + (r'/r) q) + F f(q), the acceleration by the mesh with reversed sign.
    #[inline(always)]
    fn tooth<S: Scalar, L: PieceChoice<S>>(&self, law: &L, at: &At<S>, u: Drives<'_, S>, q: S, v: S) -> S {
        let (stiffness, [_, _, _, natural]) = (u.all_waves()[STIFFNESS], u.constants());
        let stiffness = if N::HALF_BACKLASH { stiffness } else { stiffness * at.per_unit };
        let deflection = self.deflection(at, natural, q, v);
        self.mesh.force(law, 0, deflection, v + at.stretch * q, stiffness, at.damping)
    }

    /// k_m/k0 and e with their derivatives over x.
    fn mesh_waves<A: Angle>(&self, phase: A, side: Side) -> [Jet<A::Number>; 2] {
        match &self.series {
            Some([stiffness, error]) => {
                let teeth = f64::from(self.gear.teeth);
                let mesh = phase.times(teeth).number().sin_cos();
                [stiffness.jet_of(mesh, teeth), error.jet_of(mesh, teeth)]
            }
            _ => [self.mesh.stiffness().jet(phase, side), self.mesh.error().jet(phase, side)],
        }
    }
}

impl<N: Nonlinearity> Shape for NfgShape<N> {
    #[inline(always)]
    fn size(&self) -> Size {
        Size {
            dof: 1,
            waves: if N::HALF_BACKLASH { WAVES } else { ALL_WAVES },
            contacts: 1 + self.mesh.law().kinks(),
            kinks: self.mesh.law().kinks(),
            constants: 5 + usize::from(N::HALF_BACKLASH),
        }
    }
    fn names(&self) -> Vec<Channel> {
        CONSTANTS.names::<N>()
    }
    fn cycles_in_a_period(&self) -> u32 {
        self.gear.teeth
    }
    fn check(&self, constants: &[f64]) -> Result<(), ParameterError> {
        CONSTANTS.check(constants)
    }
    /// Returns ω_c/ω_n, 2 ζ, B0, I2 ω_n²/L, ω_n and, for a [`Backlash`], b/L.
    fn prepare<S: Scalar>(&self, constants: &[S]) -> Vec<S> {
        let &[speed, load, inertia, stiffness, damping, ref half_backlash @ ..] = constants else {
            return Vec::new();
        };
        let natural = self.natural(inertia, stiffness);
        let radius = S::from(self.gear.radius);
        let mut prepared = vec![
            speed / S::from(self.gear.ratio) / natural,
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
        a[0] = forcing - self.tooth(law, &at, u, q[0], v[0]);
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
        let [_, _, mesh_force, natural] = u.constants();
        // The contact in metres: d = r_b2 q, d' = r_b2 q' + r_b2' q, and likewise for the edges.
        let r = waves[RADIUS] * self.gear.radius;
        let r_rate = r * waves[STRETCH] * u.speed();
        let per_unit_rate = -(at.per_unit * at.unit_stretch);
        let edge = |x: S, rate: S, missing: bool| {
            if missing {
                return (x, S::from(0.0));
            }
            let (x, rate) = if N::HALF_BACKLASH {
                (x, rate)
            } else {
                (x * at.per_unit, rate * at.per_unit + x * per_unit_rate)
            };
            (r * x, r_rate * x + r * rate)
        };
        let (lower, lower_rate) = edge(at.lower, at.lower_rate, self.missing[0]);
        let (upper, upper_rate) = edge(at.upper, at.upper_rate, self.missing[1]);
        let force = self.tooth(law, &at, u, q[0], v[0]) * mesh_force * waves[INVERSE];
        let deflection = match i.checked_sub(1) {
            None => r * q[0],
            Some(k) => {
                let Deflection { d: x, rate, .. } = self.deflection(&at, natural, q[0], v[0]);
                r * (at.per_unit * self.mesh.law().kink(k, x, rate))
            }
        };
        Contact { deflection, rate: r * v[0] + r_rate * q[0], lower, upper, lower_rate, upper_rate, force }
    }

    fn waves<A: Angle>(&self, phase: A, side: Side, u: &mut [A::Number]) {
        let ((s, c), one) = (phase.number().sin_cos(), A::Number::from(1.0));
        let rho = Jet::new(one + c * self.gear.beta, s * -self.gear.beta, c * -self.gear.beta);
        let [stiffness, error] = self.mesh_waves(phase, side);
        let rotation = phase.jet_of(&self.gear.rotation, side);
        u[STIFFNESS] = stiffness.value * rho.value * rho.value / A::Number::from(self.gear.mean_square());
        u[RADIUS] = rho.value;
        u[INVERSE] = one / rho.value;
        u[STRETCH] = rho.rate / rho.value;
        let [error_rate, error_second] = match self.reading.error_forcing {
            ErrorForcing::MeanRadius => [error.rate, error.second],
            ErrorForcing::Frozen => [error.rate / rho.value, error.second / rho.value],
            ErrorForcing::Exact => {
                let over = error / rho;
                [over.rate, over.second]
            }
        };
        let radius = A::Number::from(self.gear.radius);
        u[FORCING] = rotation.rate - error_second / radius;
        u[FORCING_RATE] = rotation.value - error_rate / radius;
        if !N::HALF_BACKLASH {
            self.mesh.edges(phase, side, &mut u[WAVES - mesh::LOWER..]);
        }
    }
    fn next_edge(&self, phase: f64) -> Option<f64> {
        self.mesh.next_edge(phase)
    }
    fn next_knot(&self, phase: f64) -> Option<f64> {
        self.mesh.next_knot(phase)
    }

    fn channels(&self) -> Vec<Channel> {
        vec![Channel::new("base radius", "m"), Channel::new("elastic part", "rad")]
    }
    fn write_channels(&self, u: Drives<'_, f64>, q: &[f64], v: &[f64], _: &[Contact], out: &mut [f64]) {
        let at = self.at(u);
        let [_, _, _, natural] = u.constants();
        out[0] = self.gear.radius * u.all_waves()[RADIUS];
        out[1] = at.per_unit * self.mesh.law().force(self.deflection(&at, natural, q[0], v[0]));
    }
}
