//! Steep smooth forces and drives by Taylor series, against an integrator of its own.

use crate::draw::Draw;
use crate::{Check, Outcome};
use gear_dynamics::contact::PieceChoice;
use gear_dynamics::excitation::{Angle, Side};
use gear_dynamics::model::{Channel, Drives, Machine, Scalar, Shape, Size};
use gear_dynamics::ode::IntegrateError;
use gear_dynamics::sweep::{Axis, LaneTaylor, Point, PointError, Points};
use gear_dynamics::{Integrator, ParameterError, Periodic, State, Sweep, Taylor};

/// The checks of this file.
pub const CHECKS: [Check; 1] = [Check { name: "steep-forces", run: steep }];

/// A steep function of one number.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// tanh x.
    Tanh,
    /// 1/(1 + e^-x).
    Logistic,
    /// e^(-x²).
    Gaussian,
    /// 1/(1 + x²).
    Lorentzian,
    /// x/√(1 + x²).
    Root,
    /// 1/(1 + x²)^4.5.
    Power,
    /// ln(1 + e^x).
    Softplus,
}

const KINDS: [Kind; 7] =
    [Kind::Tanh, Kind::Logistic, Kind::Gaussian, Kind::Lorentzian, Kind::Root, Kind::Power, Kind::Softplus];

impl Kind {
    /// Whether lanes refuse it as a force: it has a root or a power of something that varies.
    fn refused_in_lanes(self) -> bool {
        matches!(self, Kind::Root | Kind::Power)
    }

    /// Whether the coefficients of its exponential may overflow at an argument.
    fn overflows(self, x: f64) -> bool {
        match self {
            Kind::Tanh => x > 300.0,
            Kind::Logistic => x < -600.0,
            Kind::Softplus => x > 600.0,
            _ => false,
        }
    }

    /// Its value.
    fn at<S: Scalar>(self, x: S) -> S {
        let one = S::from(1.0);
        match self {
            Kind::Tanh => one - S::from(2.0) / ((x * 2.0).exp() + one),
            Kind::Logistic => one / (one + (-x).exp()),
            Kind::Gaussian => (-(x * x)).exp(),
            Kind::Lorentzian => one / (one + x * x),
            Kind::Root => x / (one + x * x).sqrt(),
            Kind::Power => (one + x * x).powf(-4.5),
            Kind::Softplus => (one + x.exp()).ln(),
        }
    }
}

/// x'' = P g((cos φ - c)/d) + Q cos φ - x - 0.1 x' - A f((y - y0)/ε), y = x or x'.
#[derive(Clone, Debug, PartialEq)]
struct Steep {
    force: Kind,
    of_velocity: bool,
    drive: Kind,
    /// c, 1/d.
    place: f64,
    per: f64,
}

const NAMES: [&str; 6] = ["speed", "drive", "cosine", "force", "place", "width"];

impl Shape for Steep {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 2, constants: NAMES.len(), ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        NAMES.map(|name| Channel::new(name, "1")).into()
    }
    fn waves<A: Angle>(&self, angle: A, _: Side, u: &mut [A::Number]) {
        let cos = angle.number().cos();
        u[0] = cos;
        u[1] = self.drive.at((cos - A::Number::from(self.place)) * self.per);
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [cos, steep] = u.waves();
        let [drive, cosine, force, place, width] = u.constants();
        let y = if self.of_velocity { v[0] } else { q[0] };
        a[0] = drive * steep + cosine * cos - q[0] - v[0] * 0.1 - force * self.force.at((y - place) / width);
    }
}

/// A motion by steps that are halved until its end no longer changes.
pub struct Reference {
    /// Its end.
    pub exact: [f64; 2],
    /// The last change of the end.
    pub open: f64,
    /// How much a small difference of the start grows, at least 1: an error enters in both directions, at every step.
    pub growth: f64,
    /// Number of steps.
    pub n: usize,
}

impl Reference {
    /// The motion of q'' = f(t, [q, q']) from `start` to the time `end`, or why it is skipped.
    pub fn of(f: &dyn Fn(f64, [f64; 2]) -> f64, start: [f64; 2], end: f64) -> Result<Self, Outcome> {
        let mut n = 4096;
        let [mut coarse, mut exact] = [n, 2 * n].map(|n| reference(f, start, end, n));
        while apart(coarse, exact) > 1e-10 && n < 1 << 20 {
            n *= 2;
            (coarse, exact) = (exact, reference(f, start, end, 2 * n));
        }
        let open = apart(coarse, exact);
        if open.is_nan() || open > 1e-8 {
            return Err(Outcome::Skipped("the reference does not converge"));
        }
        let grown =
            |by: [f64; 2]| apart(reference(f, [start[0] + by[0], start[1] + by[1]], end, n), exact) / 1e-7;
        let growth = grown([1e-7, 0.0]).max(grown([0.0, 1e-7])).max(1.0);
        if growth > 1e3 {
            return Err(Outcome::Skipped("the motion is sensitive"));
        }
        Ok(Reference { exact, open, growth, n })
    }

    /// Whether the motion from a start that differs by `by` is far away, or infinite, at the end.
    pub fn escapes(&self, f: &dyn Fn(f64, [f64; 2]) -> f64, start: [f64; 2], end: f64, by: f64) -> bool {
        let changes = [[by, 0.0], [-by, 0.0], [0.0, by], [0.0, -by]];
        changes.into_iter().any(|[x, v]| {
            let y = reference(f, [start[0] + x, start[1] + v], end, self.n);
            let apart = apart(y, self.exact);
            apart.is_nan() || apart > 1e3
        })
    }
}

/// The end of `n` steps of the classical Runge-Kutta method of order 4.
fn reference(f: &dyn Fn(f64, [f64; 2]) -> f64, y: [f64; 2], end: f64, n: usize) -> [f64; 2] {
    let (h, mut y) = (end / n as f64, y);
    for i in 0..n {
        let t = end * i as f64 / n as f64;
        let [x, v] = y;
        let a = f(t, [x, v]);
        let (v2, a2) = (v + 0.5 * h * a, f(t + 0.5 * h, [x + 0.5 * h * v, v + 0.5 * h * a]));
        let (v3, a3) = (v + 0.5 * h * a2, f(t + 0.5 * h, [x + 0.5 * h * v2, v + 0.5 * h * a2]));
        let (v4, a4) = (v + h * a3, f(t + h, [x + h * v3, v + h * a3]));
        y = [x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4), v + h / 6.0 * (a + 2.0 * a2 + 2.0 * a3 + a4)];
    }
    y
}

/// The largest difference.
pub fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs())
}

/// Allowed error, in relative tolerances of the growing motion.
const ALLOWED: f64 = 1000.0;

/// `Taylor`, and `LaneTaylor` where it takes the force, over two periods at three tolerances.
fn steep(draw: &mut Draw) -> Outcome {
    let widest = draw.scale(1.0 / 300.0, 1.0);
    let shape = Steep {
        force: draw.one_of(&KINDS),
        of_velocity: draw.below(2) == 0,
        drive: draw.one_of(&KINDS),
        place: draw.within(-1.0, 1.0),
        per: 1.0 / draw.scale(0.01, 1.0),
    };
    let size = draw.scale(0.02, 1.0);
    let values = [
        draw.within(0.4, 1.6),
        if draw.below(2) == 0 { 0.0 } else { draw.scale(0.02, 1.0) },
        draw.within(0.2, 1.0),
        // The slope of the force by its argument is bounded, so that the reference remains exact.
        size.min(30.0 * widest),
        draw.within(-0.7, 0.7),
        widest,
    ];
    let constants: Vec<(&str, f64)> = NAMES.into_iter().zip(values).collect();
    let text = format!("{shape:?}, {values:?}");
    draw.note(|| text.clone());
    let (force, of_velocity) = (shape.force, shape.of_velocity);
    let refused_in_lanes = force.refused_in_lanes();
    let start = [draw.within(-1.0, 1.0), draw.within(-0.5, 0.5)];
    let own = shape.clone();
    let f = move |t: f64, [x, v]: [f64; 2]| {
        let [speed, drive, cosine, force, place, width] = values;
        let (cos, y) = ((speed * t).cos(), if own.of_velocity { v } else { x });
        drive * own.drive.at((cos - own.place) * own.per) + cosine * cos
            - x
            - 0.1 * v
            - force * own.force.at((y - place) / width)
    };
    let end = 2.0 * std::f64::consts::TAU / values[0];
    let Reference { exact, open, growth, n } = match Reference::of(&f, start, end) {
        Ok(reference) => reference,
        Err(skipped) => return skipped,
    };
    let size = exact[0].abs().max(exact[1].abs()).max(1.0);
    let machine = match Machine::of_constants(shape, &constants) {
        Ok(machine) => machine,
        Err(error) => return Outcome::Fails(error.to_string()),
    };
    let overflows = |t: f64| {
        let [x, v] = reference(&f, start, t, n);
        force.overflows((if of_velocity { v } else { x } - values[4]) / values[5])
    };
    let state = State::new(0.0, &start[..1], &start[1..]);
    for rtol in [1e-5, 1e-8, 1e-11] {
        let taylor = Taylor::new().rtol(rtol).atol(1e-3 * rtol);
        let allowed = ALLOWED * rtol * growth * size + 10.0 * open + 1e-9;
        let single = match taylor.end(&machine, &state, end) {
            Ok(end) => apart([end.q[0], end.v[0]], exact),
            Err(IntegrateError::NoSeriesAt { t, .. }) if overflows(t) => {
                return Outcome::Skipped("an exponential overflows");
            }
            Err(error) => return Outcome::Fails(format!("rtol {rtol:e}: {error}; {text}")),
        };
        if refused_in_lanes {
            draw.note(|| format!("rtol {rtol:e}: off by {single:.1e}, allowed {allowed:.1e}"));
            if single.is_nan() || single > allowed {
                return Outcome::Fails(format!(
                    "rtol {rtol:e}: off by {single:.1e}, allowed {allowed:.1e}; {text}"
                ));
            }
            continue;
        }
        let points = Axis::of_values("speed", &[values[0], 1.1 * values[0]]).map(Points::from);
        let rows = points.map_err(|error| error.to_string()).and_then(|points| {
            let begin = |_: &Point<'_>, _: &Machine<Steep>| Ok::<_, ParameterError>(state.clone());
            let sweep = Sweep::new(points).settle(1).measure(1).channels(&["q0"]).strobe(1);
            let engine = LaneTaylor::new(taylor);
            let family = |p: &Point<'_>| machine.with("speed", p["speed"]);
            sweep.of(&engine, family).start(begin).run().map_err(|error| error.to_string())
        });
        let lanes = match &rows {
            Ok(rows) => match rows.get(0) {
                Ok(row) => row.strobes().last().map_or(f64::NAN, |y| apart([y[0], y[1]], exact)),
                // Lanes meet the same exponential at their own steps.
                Err(PointError::Integrate(IntegrateError::NoSeriesAt { t, .. })) if overflows(t) => {
                    return Outcome::Skipped("an exponential overflows");
                }
                Err(error) => return Outcome::Fails(format!("lanes, rtol {rtol:e}: {error}; {text}")),
            },
            Err(error) => return Outcome::Fails(format!("lanes, rtol {rtol:e}: {error}; {text}")),
        };
        draw.note(|| {
            format!("rtol {rtol:e}: off by {single:.1e}, in lanes {lanes:.1e}, allowed {allowed:.1e}")
        });
        if !(single <= allowed && lanes <= allowed) {
            let period = machine.period();
            let what = format!("rtol {rtol:e}: off by {single:.1e}, in lanes {lanes:.1e}");
            return Outcome::Fails(format!("{what}, allowed {allowed:.1e}; period {period:.3}; {text}"));
        }
    }
    Outcome::Agrees
}
