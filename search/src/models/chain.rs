//! Chains of masses with contacts between neighbours: random shapes.

use crate::draw::Draw;
use gear_dynamics::contact::{
    AsymmetricBacklash, Contact, Deflection, MixedLaw, Nonlinearity, PieceChoice, PowerLaw,
};
use gear_dynamics::excitation::{Angle, Fourier, RectangularWave, Side};
use gear_dynamics::model::{Channel, Drives, Machine, Scalar, Shape, Size};
use gear_dynamics::{Backlash, ParameterError, Wave};

/// x_i'' + c x_i' + k x_i + γ x_i³ = F_i + P_i cos φ - W_i + W_{i+1},   W_i = s_i(φ) g(x_i - x_{i-1} - e_i(φ)),
/// with x_0 = 0 and a contact law g of half backlash b: n masses and n contacts, dimensionless.
#[derive(PartialEq)]
pub struct Chain<N = MixedLaw> {
    masses: usize,
    law: N,
    force: Wave,
    stiffness: Vec<Wave>,
    error: Vec<Wave>,
}

const NAMES: [&str; 7] = ["speed", "damping", "linear", "cubic", "half backlash", "mean force", "force"];

/// Dead zone with flanks of different slopes.
pub fn flanks(_: &mut Draw, half_backlash: f64) -> Result<AsymmetricBacklash, ParameterError> {
    AsymmetricBacklash::new(-half_backlash, half_backlash)?.with_slopes(0.5, 1.5)
}

/// One of several laws.
pub fn any_law(draw: &mut Draw, half_backlash: f64) -> Result<MixedLaw, ParameterError> {
    Ok(match draw.below(3) {
        0 => MixedLaw::Backlash(Backlash::new(half_backlash)?),
        1 => MixedLaw::Power(PowerLaw::new(half_backlash, draw.within(1.2, 3.0), 1.0)?),
        _ => MixedLaw::Asymmetric(flanks(draw, half_backlash)?),
    })
}

impl<N: Nonlinearity + std::fmt::Debug> Chain<N> {
    /// Draws a chain of 1 to 3 masses with contacts of a law of the given half width.
    pub fn draw(
        draw: &mut Draw,
        law: fn(&mut Draw, f64) -> Result<N, ParameterError>,
    ) -> Result<Machine<Self>, ParameterError> {
        let masses = 1 + draw.below(3);
        let half_backlash = draw.scale(0.1, 2.0);
        let law = law(draw, half_backlash)?;
        let mut wave = |mean: f64, size: f64| {
            let terms = [(); 2].map(|()| [draw.within(-size, size), draw.within(-size, size)]);
            Fourier::new(mean, &terms).map(Wave::new)
        };
        let error = (0..masses).map(|_| wave(0.0, 0.1)).collect::<Result<Vec<_>, _>>()?;
        let mut stiffness = (0..masses).map(|_| wave(1.0, 0.1)).collect::<Result<Vec<_>, _>>()?;
        if draw.below(3) == 0 {
            stiffness[0] = Wave::new(RectangularWave::of_contact_ratio(draw.within(1.1, 1.9), 0.8, 1.2)?);
        }
        let force = Wave::new(Fourier::new(0.0, &[[1.0, 0.0]])?);
        let values = [
            draw.within(0.4, 2.5),
            draw.within(0.05, 0.3),
            draw.within(0.05, 0.5),
            draw.within(0.0, 0.2),
            half_backlash,
            draw.within(0.1, 0.6),
            draw.within(0.0, 0.5),
        ];
        let constants: Vec<(&str, f64)> = NAMES.into_iter().zip(values).collect();
        Machine::of_constants(Chain { masses, law, force, stiffness, error }, &constants)
    }

    /// Its law and its constants.
    pub fn describe(machine: &Machine<Self>) -> String {
        let shape = machine.shape();
        format!("{} masses, {:?}, {:?}", shape.masses, shape.law, machine.values())
    }
}

impl<N: Nonlinearity> Shape for Chain<N> {
    #[inline(always)]
    fn size(&self) -> Size {
        let n = self.masses;
        Size { dof: n, waves: 1 + 3 * n, contacts: n, constants: NAMES.len(), ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        NAMES.map(|name| Channel::new(name, "1")).into()
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u[0] = self.force.value(angle, side);
        for (i, (stiffness, error)) in self.stiffness.iter().zip(&self.error).enumerate() {
            u[1 + 3 * i] = stiffness.value(angle, side);
            u[2 + 3 * i] = error.value(angle, side);
            u[3 + 3 * i] = error.jet(angle, side).rate;
        }
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        self.stiffness[0].next_edge(angle)
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
        let [stiffness, error, slope] = u.waves_from(1 + 3 * i);
        let [_, _, _, b] = u.constants();
        let (mut deflection, mut rate) = (q[i] - error, v[i] - slope * u.speed());
        if i > 0 {
            (deflection, rate) = (deflection - q[i - 1], rate - v[i - 1]);
        }
        let force =
            stiffness * law.force(i, &self.law, Deflection { d: deflection, rate, lower: -b, upper: b });
        Contact { deflection, rate, lower: -b, upper: b, force, ..Contact::default() }
    }
    #[inline(always)]
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [damping, linear, cubic, _, mean, force] = u.constants();
        let [cos] = u.waves();
        for i in 0..self.masses {
            a[i] = mean + force * cos - damping * v[i] - linear * q[i] - cubic * q[i] * q[i] * q[i];
        }
        for i in 0..self.masses {
            let force = self.contact(law, i, u, q, v).force;
            a[i] = a[i] - force;
            if i > 0 {
                a[i - 1] = a[i - 1] + force;
            }
        }
    }
}
