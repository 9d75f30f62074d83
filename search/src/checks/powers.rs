//! Powers of a coordinate, of sines and of flat bases by Taylor series, as forces and as drives, from rest and from
//! elsewhere, against an integrator of its own: their series have gaps, and last terms that hide what comes later.

use crate::checks::steep::{Reference, apart};
use crate::draw::Draw;
use crate::{Check, Outcome};
use gear_dynamics::contact::PieceChoice;
use gear_dynamics::excitation::{Angle, Side};
use gear_dynamics::model::{Channel, Drives, Machine, Scalar, Shape, Size};
use gear_dynamics::sweep::{Axis, LaneTaylor, Point, Points};
use gear_dynamics::{Integrator, ParameterError, State, Sweep, Taylor};

/// The checks of this file.
pub const CHECKS: [Check; 2] = [
    Check { name: "powers-from-rest", run: powers },
    Check { name: "powers-as-drives", run: powers_as_drives },
];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Base {
    Motion,
    Sine,
    /// (1 + cos z)/2.
    High,
    /// (1 - cos z)/2.
    Flat,
    /// z (1 - z).
    Hump,
}

/// A drive over its angle.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pulse {
    Cosine,
    /// ((1 - cos φ)/2)ⁿ.
    Flat(u32),
    /// sinⁿ φ ((1 - cos φ)/2)ⁿ.
    Product(u32),
    /// ((1 + cos φ)/2)ⁿ + e^(cos φ/2)/100, which has no finite series.
    Beside(u32),
}

impl Pulse {
    fn at<S: Scalar>(self, sin: S, cos: S) -> S {
        let [flat, high] = [S::from(1.0) - cos, S::from(1.0) + cos].map(|x| x * 0.5);
        let power = |base: S, n: u32| (1..n).fold(base, |power, _| power * base);
        match self {
            Pulse::Cosine => cos,
            Pulse::Flat(n) => power(flat, n),
            Pulse::Product(n) => power(sin * flat, n),
            Pulse::Beside(n) => power(high, n) + (cos * 0.5).exp() * 0.01,
        }
    }
}

/// q'' = F + P p(Ωt) - c q' - k q - A b(q/ε)ⁿ.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Power {
    base: Base,
    exponent: u32,
    pulse: Pulse,
}

impl Power {
    fn at<S: Scalar>(self, z: S) -> S {
        let one = S::from(1.0);
        let base = match self.base {
            Base::Motion => z,
            Base::Sine => z.sin(),
            Base::High => (one + z.cos()) * 0.5,
            Base::Flat => (one - z.cos()) * 0.5,
            Base::Hump => z * (one - z),
        };
        (1..self.exponent).fold(base, |power, _| power * base)
    }
}

const NAMES: [&str; 7] = ["speed", "mean force", "force", "damping", "stiffness", "power", "width"];

impl Shape for Power {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 1, constants: NAMES.len(), ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        NAMES.map(|name| Channel::new(name, "1")).into()
    }
    fn waves<A: Angle>(&self, angle: A, _: Side, u: &mut [A::Number]) {
        u[0] = match self.pulse {
            Pulse::Cosine => angle.number().cos(),
            pulse => {
                let (sin, cos) = angle.number().sin_cos();
                pulse.at(sin, cos)
            }
        };
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [pulse] = u.waves();
        let [mean, force, damping, stiffness, power, width] = u.constants();
        a[0] = mean + force * pulse - damping * v[0] - stiffness * q[0] - power * self.at(q[0] / width);
    }
}

/// Allowed error, in relative tolerances of the growing motion.
const ALLOWED: f64 = 1000.0;

/// Change of the start, in relative tolerances, that stands for the errors of all steps.
const ESCAPE: f64 = 100.0;

fn powers(draw: &mut Draw) -> Outcome {
    let base = draw.one_of(&[Base::Motion, Base::Sine, Base::High, Base::Flat, Base::Hump]);
    // Odd powers of the coordinate restore; high ones of humps are small.
    let exponent = match base {
        Base::Motion => draw.one_of(&[3, 5, 7, 9, 13]),
        Base::Hump => 2 + draw.below(9) as u32,
        _ => 2 + draw.below(20) as u32,
    };
    let shape = Power { base, exponent, pulse: Pulse::Cosine };
    let or_none = |draw: &mut Draw, x: f64| if draw.below(2) == 0 { 0.0 } else { x };
    let force = draw.scale(0.01, 1.0);
    let damping = draw.scale(0.01, 0.3);
    let stiffness = draw.scale(0.1, 1.0);
    let height = if base == Base::Hump { 4f64.powi(exponent as i32) } else { 1.0 };
    let values = [
        draw.within(0.4, 1.6),
        draw.scale(0.05, 1.0),
        or_none(draw, force),
        or_none(draw, damping),
        if base == Base::Motion { or_none(draw, stiffness) } else { stiffness },
        height * draw.scale(0.1, 1.0),
        draw.scale(0.3, 1.0),
    ];
    let start =
        if draw.below(2) == 0 { [0.0, 0.0] } else { [draw.within(-0.5, 0.5), draw.within(-0.3, 0.3)] };
    compare(draw, shape, values, start)
}

/// A pulse drives a linear oscillator, or one with a cubic force.
fn powers_as_drives(draw: &mut Draw) -> Outcome {
    let n = 2 + draw.below(25) as u32;
    let pulse = draw.one_of(&[Pulse::Flat(n), Pulse::Product(n.min(12)), Pulse::Beside(n)]);
    let shape = Power { base: Base::Motion, exponent: 3, pulse };
    let or_none = |draw: &mut Draw, x: f64| if draw.below(2) == 0 { 0.0 } else { x };
    let [mean, damping, cubic] = [draw.scale(0.05, 0.5), draw.scale(0.01, 0.3), draw.scale(0.1, 1.0)];
    let values = [
        draw.scale(0.3, 2.0),
        or_none(draw, mean),
        draw.scale(0.1, 3.0),
        or_none(draw, damping),
        draw.scale(0.1, 2.0),
        or_none(draw, cubic),
        1.0,
    ];
    let start =
        if draw.below(2) == 0 { [0.0, 0.0] } else { [draw.within(-0.5, 0.5), draw.within(-0.3, 0.3)] };
    compare(draw, shape, values, start)
}

/// A power and its pulse against the reference.
fn compare(draw: &mut Draw, shape: Power, values: [f64; 7], start: [f64; 2]) -> Outcome {
    let f = move |t: f64, [x, v]: [f64; 2]| {
        let [speed, mean, force, damping, stiffness, power, width] = values;
        let (sin, cos) = (speed * t).sin_cos();
        mean + force * shape.pulse.at(sin, cos) - damping * v - stiffness * x - power * shape.at(x / width)
    };
    compare_with(draw, shape, &NAMES, &values, f, start)
}

/// Single runs and lanes of a shape of one coordinate over two periods at four tolerances against the equation
/// x'' = f(t, \[x, x'\]) of a closure. The first constant is the speed.
pub fn compare_with<G: Shape + Clone + std::fmt::Debug>(
    draw: &mut Draw,
    shape: G,
    names: &[&str],
    values: &[f64],
    f: impl Fn(f64, [f64; 2]) -> f64,
    start: [f64; 2],
) -> Outcome {
    let constants: Vec<(&str, f64)> = names.iter().copied().zip(values.iter().copied()).collect();
    let text = format!("{shape:?}, {values:?}, {start:?}");
    draw.note(|| text.clone());
    let end = 2.0 * std::f64::consts::TAU / values[0];
    let reference = match Reference::of(&f, start, end) {
        Ok(reference) => reference,
        Err(skipped) => return skipped,
    };
    let Reference { exact, open, growth, .. } = reference;
    let size = exact[0].abs().max(exact[1].abs()).max(1.0);
    let machine = match Machine::of_constants(shape, &constants) {
        Ok(machine) => machine,
        Err(error) => return Outcome::Fails(error.to_string()),
    };
    let state = State::new(0.0, &start[..1], &start[1..]);
    for rtol in [1e-5, 1e-7, 1e-9, 1e-11] {
        let taylor = Taylor::new().rtol(rtol).atol(1e-3 * rtol);
        let allowed = ALLOWED * rtol * growth * size + 10.0 * open + 1e-9;
        let single = match taylor.end(&machine, &state, end) {
            Ok(end) => apart([end.q[0], end.v[0]], exact),
            // Beside a saddle the motion escapes from a start within the tolerance, too.
            Err(_) if reference.escapes(&f, start, end, ESCAPE * rtol) => continue,
            Err(error) => return Outcome::Fails(format!("rtol {rtol:e}: {error}; {text}")),
        };
        let points = Axis::of_values("speed", &[values[0], 1.1 * values[0]]).map(Points::from);
        let lanes = points.map_err(|error| error.to_string()).and_then(|points| {
            let begin = |_: &Point<'_>, _: &Machine<G>| Ok::<_, ParameterError>(state.clone());
            let sweep = Sweep::new(points).settle(1).measure(1).channels(&["q0"]).strobe(1);
            let (engine, family) =
                (LaneTaylor::new(taylor), |p: &Point<'_>| machine.with("speed", p["speed"]));
            let rows = sweep.of(&engine, family).start(begin).run().map_err(|error| error.to_string())?;
            let row = rows.get(0).map_err(|error| error.to_string())?;
            Ok(row.strobes().last().map_or(f64::NAN, |y| apart([y[0], y[1]], exact)))
        });
        let lanes = match lanes {
            Ok(lanes) => lanes,
            Err(error) => return Outcome::Fails(format!("lanes, rtol {rtol:e}: {error}; {text}")),
        };
        let what = format!("rtol {rtol:e}: off by {single:.1e}, in lanes {lanes:.1e}, allowed {allowed:.1e}");
        draw.note(|| what.clone());
        if !(single <= allowed && lanes <= allowed) {
            return Outcome::Fails(format!("{what}; {text}"));
        }
    }
    Outcome::Agrees
}
