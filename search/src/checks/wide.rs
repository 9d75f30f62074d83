//! Gaps that are wide beside the motion, with edges and transmission errors that move, against the reference: the far edge
//! must not be felt, from a start on a flank neither.

use crate::draw::Draw;
use crate::reference::Plain;
use crate::{Check, Outcome};
use gear_dynamics::contact::{Contact, Deflection, PieceChoice};
use gear_dynamics::excitation::{Angle, Side};
use gear_dynamics::model::{Channel, Drives, Machine, Scalar, Shape, Size};
use gear_dynamics::sweep::{Axis, LaneTaylor, Point, Points};
use gear_dynamics::{
    Backlash, Dop853, Integrator, ParameterError, Periodic, Rk4, Rk45, State, Sweep, Taylor,
};

/// The checks of this file.
pub const CHECKS: [Check; 1] = [Check { name: "reference-of-wide-gaps", run: wide }];

/// q'' = F + P cos φ - c q' - k f(d) with d = q - e sin nφ and edges at ±b (1 + m sin rφ), one of them moved far away.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wide {
    law: Backlash,
    /// n, r.
    orders: [u32; 2],
    /// The distance of the far edge from the origin, in b.
    far: f64,
    /// Whether the lower edge is the far one.
    below: bool,
}

const NAMES: [&str; 8] = ["speed", "load", "pulse", "damping", "stiffness", "edge", "move", "error"];

impl Wide {
    /// The edges, from b, m and sin rφ.
    fn edges<S: Scalar>(&self, edge: S, by: S, sin: S) -> [S; 2] {
        let near = edge + edge * by * sin;
        let far = edge * self.far;
        if self.below { [-far, near] } else { [-near, far] }
    }
}

impl Shape for Wide {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 5, contacts: 1, constants: NAMES.len(), ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        NAMES.map(|name| Channel::new(name, "1")).into()
    }
    fn waves<A: Angle>(&self, angle: A, _: Side, u: &mut [A::Number]) {
        let [(s, c), (x, y)] = self.orders.map(|order| (angle.number() * f64::from(order)).sin_cos());
        u.copy_from_slice(&[angle.number().cos(), s, c, x, y]);
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        choice: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let [_, s, c, x, y] = u.waves();
        let [_, _, _, stiffness, edge, by, error] = u.constants();
        let [lower, upper] = self.edges(edge, by, x);
        let moves = edge * by * y * f64::from(self.orders[1]) * u.speed();
        let none = S::from(0.0);
        let [lower_rate, upper_rate] = if self.below { [none, moves] } else { [-moves, none] };
        let d = q[0] - error * s;
        let rate = v[0] - error * c * f64::from(self.orders[0]) * u.speed();
        let force = stiffness * choice.force(i, &self.law, Deflection { d, rate, lower, upper });
        Contact { deflection: d, rate, lower, upper, lower_rate, upper_rate, force }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [cos, ..] = u.waves::<5>();
        let [load, pulse, damping, ..] = u.constants::<7>();
        a[0] = load + pulse * cos - damping * v[0] - self.contact(law, 0, u, q, v).force;
    }
}

fn wide(draw: &mut Draw) -> Outcome {
    run(draw).unwrap_or_else(Outcome::Fails)
}

/// Steps of the reference in the run.
const STEPS: f64 = 6000.0;

/// Largest growth of a small difference.
const GROWTH: f64 = 1e3;

/// Allowed error, in relative tolerances of the growing motion.
const ALLOWED: f64 = 1000.0;

fn told(error: impl std::fmt::Display) -> String {
    error.to_string()
}

fn run(draw: &mut Draw) -> Result<Outcome, String> {
    let shape = Wide {
        law: Backlash::new(0.0).map_err(told)?,
        orders: [1 + draw.below(20) as u32, 1 + draw.below(8) as u32],
        far: draw.scale(10.0, 1e14),
        below: draw.below(2) == 0,
    };
    let or_none = |draw: &mut Draw, x: f64| if draw.below(2) == 0 { 0.0 } else { x };
    let [by, error, pulse] = [draw.scale(1e-3, 0.9), draw.scale(1e-3, 0.5), draw.scale(0.01, 1.0)];
    let values = [
        draw.scale(0.2, 3.0),
        draw.within(-0.3, 0.3),
        or_none(draw, pulse),
        draw.scale(0.02, 0.5),
        draw.scale(0.3, 100.0),
        draw.scale(0.05, 2.0),
        or_none(draw, by),
        or_none(draw, error),
    ];
    let sign = if shape.below { 1.0 } else { -1.0 };
    // Half of the runs begin at rest a little way on the near flank.
    let start = match draw.below(2) {
        0 => [draw.within(-1.5, 1.5), draw.within(-1.0, 1.0)],
        _ => [sign * values[5] * (1.0 + draw.scale(1e-6, 0.3)), 0.0],
    };
    let text = format!("{shape:?} {values:?} {start:?}");
    draw.note(|| text.clone());
    let [speed, load, pulse, damping, stiffness, edge, by, error] = values;
    let place = |t: f64, q: f64| {
        let [n, r] = shape.orders.map(|order| (f64::from(order) * speed * t).sin());
        let [lower, upper] = shape.edges(edge, by, r);
        [q - error * n - lower, q - error * n - upper]
    };
    let plain = Plain {
        dof: 1,
        contacts: 1,
        accel: &|at, zones, a| {
            let [lower, upper] = place(at.t, at.q[0]);
            let force = match zones[0] {
                -1 => lower,
                0 => 0.0,
                _ => upper,
            };
            a[0] = load + pulse * (speed * at.t).cos() - damping * at.v[0] - stiffness * force;
        },
        distances: &|at, _| place(at.t, at.q[0]),
        jump: &|_| f64::INFINITY,
        impact: None,
    };
    let machine =
        Machine::of_constants(shape, &NAMES.into_iter().zip(values).collect::<Vec<_>>()).map_err(told)?;
    let end = 2.0 * machine.period();
    let count = STEPS.max(1000.0 * end);
    let at = |y: [f64; 2], n: f64| plain.run(0.0, &y, end, end / n, &mut |_| {}).0;
    let apart = |a: &[f64], b: &[f64]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
    let [coarse, exact] = [count, 2.0 * count].map(|n| at(start, n));
    let open = apart(&coarse, &exact);
    let changes = [[1e-7, 0.0], [-1e-7, 0.0], [0.0, 1e-7], [0.0, -1e-7]];
    let grown = changes.map(|[x, v]| apart(&at([start[0] + x, start[1] + v], count), &coarse) / 1e-7);
    let growth = grown.into_iter().fold(1.0, f64::max);
    if open.is_nan() || open > 1e-7 || growth > GROWTH {
        return Ok(Outcome::Skipped("the reference is not accurate, or the motion sensitive"));
    }
    let size = exact[0].abs().max(exact[1].abs()).max(1.0);
    let state = State::new(0.0, &start[..1], &start[1..]);
    let check = |name: &str, rtol: f64, y: [f64; 2]| {
        let (off, allowed) = (apart(&y, &exact), ALLOWED * rtol * growth * size + 10.0 * open + 1e-9);
        draw.note(|| format!("{name}, {rtol:e}: off by {off:.1e}, allowed {allowed:.1e}"));
        if off <= allowed {
            Ok(())
        } else {
            Err(format!("{name}, rtol {rtol:e}: off by {off:.1e}, allowed {allowed:.1e}; {text}"))
        }
    };
    for rtol in [1e-5, 1e-8, 1e-11] {
        let atol = 1e-2 * rtol;
        let taylor = Taylor::new().rtol(rtol).atol(atol);
        let solvers: [(&str, &dyn Integrator); 3] = [
            ("Taylor", &taylor),
            ("Dop853", &Dop853::new().rtol(rtol).atol(atol)),
            ("Rk45", &Rk45::new().rtol(rtol).atol(atol)),
        ];
        for (name, solver) in solvers {
            let end =
                solver.end(&machine, &state, end).map_err(|error| format!("{name}: {error}; {text}"))?;
            check(name, rtol, [end.q[0], end.v[0]])?;
        }
        let points = Axis::of_values("speed", &[speed, 1.1 * speed]).map(Points::from).map_err(told)?;
        let begin = |_: &Point<'_>, _: &Machine<Wide>| Ok::<_, ParameterError>(state.clone());
        let sweep = Sweep::new(points).settle(1).measure(1).channels(&["q0"]).strobe(1);
        let (engine, family) = (LaneTaylor::new(taylor), |p: &Point<'_>| machine.with("speed", p["speed"]));
        let rows = sweep.of(&engine, family).start(begin).run().map_err(told)?;
        let row = rows.get(0).map_err(|error| format!("lanes: {error}; {text}"))?;
        let last = row.strobes().last().map_or([f64::NAN; 2], |y| [y[0], y[1]]);
        check("lanes", rtol, last)?;
    }
    let end = Rk4::new(machine.period() / 4000.0).end(&machine, &state, end);
    let end = end.map_err(|error| format!("Rk4: {error}; {text}"))?;
    check("Rk4", 1e-8, [end.q[0], end.v[0]])?;
    Ok(Outcome::Agrees)
}
