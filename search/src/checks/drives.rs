//! Jumps of the drives beside one another, at constant and at varying speed, and held values, against the reference.

use crate::draw::Draw;
use crate::reference::{Plain, next_of, wrapped};
use crate::{Check, Outcome};
use gear_dynamics::contact::PieceChoice;
use gear_dynamics::drives::{Noisy, SpeedLaw, VaryingSpeed};
use gear_dynamics::excitation::{Angle, RectangularWave, Side, earliest};
use gear_dynamics::model::{Channel, Drives, Machine, Scalar, Shape, Size};
use gear_dynamics::processes::HeldProcess;
use gear_dynamics::{Dop853, Integrator, Model, ParameterError, State, Taylor, Wave};
use std::f64::consts::{PI, TAU};

/// The checks of this file.
pub const CHECKS: [Check; 1] = [Check { name: "reference-of-drives", run: drives }];

/// x'' = F - c x' - Σ κ_i(φ) x with rectangular waves κ_i.
#[derive(Clone, Debug, PartialEq)]
struct Springs {
    waves: Vec<Wave>,
}

impl Shape for Springs {
    fn size(&self) -> Size {
        Size { dof: 1, waves: self.waves.len(), constants: 3, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        ["speed", "force", "damping"].map(|name| Channel::new(name, "1")).into()
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u.iter_mut().zip(&self.waves).for_each(|(u, wave)| *u = wave.value(angle, side));
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        earliest(self.waves.iter().map(|wave| wave.next_edge(angle)))
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [force, damping] = u.constants();
        a[0] = force - damping * v[0];
        for kappa in u.all_waves() {
            a[0] = a[0] - *kappa * q[0];
        }
    }
}

/// How the angle moves.
#[derive(Clone, Debug)]
enum Law {
    /// φ = ωt.
    Even(f64),
    /// Times and speeds of knots.
    Table(Vec<f64>, Vec<f64>),
}

impl Law {
    fn angle(&self, t: f64) -> f64 {
        let Law::Table(times, speeds) = self else {
            let Law::Even(speed) = self else { return f64::NAN };
            return speed * t;
        };
        let mut angle = 0.0;
        for k in 0..times.len() {
            let Some(next) = times.get(k + 1) else { return angle + speeds[k] * (t - times[k]) };
            let slope = (speeds[k + 1] - speeds[k]) / (next - times[k]);
            let dt = t.min(*next) - times[k];
            angle += dt * (speeds[k] + 0.5 * slope * dt);
            if t <= *next {
                return angle;
            }
        }
        angle
    }
    /// The time of an angle, by bisection.
    fn time(&self, angle: f64, end: f64) -> f64 {
        let (mut low, mut high) = (0.0, end);
        if self.angle(end) < angle {
            return f64::INFINITY;
        }
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if self.angle(middle) < angle { low = middle } else { high = middle }
        }
        high
    }
}

/// Distances of neighbouring events `[rad]`.
fn beside(draw: &mut Draw) -> f64 {
    draw.one_of(&[-1.0, 1.0]) * draw.scale(1e-15, 1e-7)
}

fn drives(draw: &mut Draw) -> Outcome {
    run(draw).unwrap_or_else(Outcome::Fails)
}

/// The ends of the runs of a model.
type Ends<'a> = dyn Fn(&dyn Model) -> Result<[State; 2], String> + 'a;

/// Times of the run.
const END: f64 = 40.0;

/// Steps of the reference in the run.
const STEPS: f64 = 8000.0;

fn told(error: impl std::fmt::Display) -> String {
    error.to_string()
}

fn run(draw: &mut Draw) -> Result<Outcome, String> {
    // (order, duty, low, high): the first duties lie beside one another.
    let duty = draw.within(0.1, 0.9);
    let count = 1 + draw.below(3);
    let waves: Vec<(u32, f64, f64, f64)> = (0..count)
        .map(|i| {
            let near = if i == 0 { 0.0 } else { beside(draw) / PI };
            let low = draw.within(0.2, 1.0);
            (1, (duty + near).clamp(0.05, 0.95), low, low * draw.within(1.5, 4.0))
        })
        .collect();
    let speed = draw.within(0.5, 2.0);
    let edge = |k: usize| k as f64 * TAU + PI * duty;
    let law = match draw.below(2) {
        0 => Law::Even(speed),
        _ => {
            // A knot beside an edge.
            let (other, k) = (speed * draw.within(0.6, 2.0), 1 + draw.below(3));
            let time = 2.0 * (edge(k) + beside(draw)) / (speed + other);
            Law::Table(vec![0.0, time, time + draw.within(2.0, 9.0)], vec![speed, other, speed])
        }
    };
    // Held values change beside an edge.
    let held = (draw.below(3) == 0).then(|| {
        let time = law.time(edge(1), END) + beside(draw) / speed;
        let values: Vec<f64> = (0..64).map(|_| draw.within(-0.5, 0.5)).collect();
        (time / 3.0, values)
    });
    let (force, damping, start) = (draw.within(0.1, 1.0), draw.within(0.02, 0.2), draw.within(-1.0, 1.0));
    let text = format!("{waves:?} {law:?} {held:?} {force} {damping} {start}");
    draw.note(|| text.clone());
    let compared = compare(draw, &waves, &law, held.as_ref(), [force, damping, start, speed]);
    compared.map_err(|error| format!("{error}; {text}"))
}

fn compare(
    draw: &mut Draw,
    waves: &[(u32, f64, f64, f64)],
    law: &Law,
    held: Option<&(f64, Vec<f64>)>,
    [force, damping, start, speed]: [f64; 4],
) -> Result<Outcome, String> {
    let shape = Springs {
        waves: waves
            .iter()
            .map(|&(order, duty, low, high)| {
                Wave::new(RectangularWave::new(low, high, duty)?).per_turn(order)
            })
            .collect::<Result<_, ParameterError>>()
            .map_err(told)?,
    };
    let constants = [("speed", speed), ("force", force), ("damping", damping)];
    let machine = Machine::of_constants(shape, &constants).map_err(told)?;
    // All jumps of the run.
    let mut jumps: Vec<f64> = Vec::new();
    let last = law.angle(END);
    for &(order, duty, ..) in waves {
        let mut angle = 0.0;
        while angle < last {
            angle = next_of(
                &[-0.5 * duty * TAU, 0.5 * duty * TAU].map(|x| x / f64::from(order)),
                TAU / f64::from(order),
                angle + 1e-300,
            );
            jumps.push(law.time(angle, END));
        }
    }
    if let Law::Table(times, _) = law {
        jumps.extend(times);
    }
    if let Some((hold, values)) = held {
        jumps.extend((1..values.len()).map(|k| k as f64 * hold));
    }
    jumps.sort_by(f64::total_cmp);
    let plain = Plain {
        dof: 1,
        contacts: 0,
        accel: &|at, _, a| {
            let angle = law.angle(at.t);
            let stiffness: f64 = waves
                .iter()
                .map(
                    |&(order, duty, low, high)| {
                        if wrapped(f64::from(order) * angle).abs() < PI * duty { high } else { low }
                    },
                )
                .sum();
            let value = held.map_or(0.0, |(hold, values)| values[((at.t / hold) as usize) % values.len()]);
            a[0] = force + value - damping * at.v[0] - stiffness * at.q[0];
        },
        distances: &|_, _| [0.0; 2],
        jump: &|t| {
            jumps[jumps.partition_point(|jump| *jump <= t)..].first().copied().unwrap_or(f64::INFINITY)
        },
        impact: None,
    };
    let [coarse, fine] =
        [STEPS, 2.0 * STEPS].map(|n| plain.run(0.0, &[start, 0.0], END, END / n, &mut |_| {}).0);
    let open = (coarse[0] - fine[0]).abs() + (coarse[1] - fine[1]).abs();
    if open > 1e-6 {
        return Ok(Outcome::Skipped("the reference is not accurate"));
    }
    let begin = State::new(0.0, &[start], &[0.0]);
    let law = match law {
        Law::Even(_) => None,
        Law::Table(times, speeds) => Some(SpeedLaw::table(times, speeds).map_err(told)?),
    };
    let moved = |model: &Ends<'_>| -> Result<[State; 2], String> {
        let process = held.map(|(hold, values)| HeldProcess::of_values(*hold, values).map_err(told));
        let slot = machine.slot("force").map_err(told)?;
        match (law.clone(), process) {
            (None, None) => model(&machine),
            (None, Some(p)) => model(&Noisy::new(machine.clone()).add(&[(slot, 1.0)], &p?).map_err(told)?),
            (Some(law), None) => model(&VaryingSpeed::new(machine.clone(), law)),
            (Some(law), Some(p)) => {
                let varying = VaryingSpeed::new(machine.clone(), law);
                model(&Noisy::new(varying).add(&[(slot, 1.0)], &p?).map_err(told)?)
            }
        }
    };
    let ends = moved(&|model| {
        let dop853 = Dop853::new().rtol(1e-11).atol(1e-13).end(model, &begin, END).map_err(told)?;
        Ok([dop853, Taylor::new().end(model, &begin, END).map_err(|error| format!("Taylor: {error}"))?])
    })?;
    for (name, end) in ["Dop853", "Taylor"].into_iter().zip(ends) {
        let off = (end.q[0] - fine[0]).abs() + (end.v[0] - fine[1]).abs();
        draw.note(|| format!("{name} {:?} {:?}, reference {fine:?}, open {open:e}", end.q, end.v));
        if off.is_nan() || off > 3.0 * open + 2e-6 {
            return Err(format!("{name} is off by {off:e}, open {open:e}"));
        }
    }
    Ok(Outcome::Agrees)
}
