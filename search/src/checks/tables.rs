//! Waves from tables, with and without jumps, against the reference: the ends and the figures of a driven
//! mass.

use crate::draw::Draw;
use crate::models::curve::Curve;
use crate::models::driven::Driven;
use crate::reference::{At, Plain, extremes_of_cubic, integral_of_cubic, next_of};
use crate::{Check, Outcome};
use gear_dynamics::excitation::Side;
use gear_dynamics::model::Machine;
use gear_dynamics::sweep::bounds::SweepEngine;
use gear_dynamics::sweep::{Axis, LaneTaylor, Located};
use gear_dynamics::{Dop853, Integrator, ParameterError, Periodic, State, Sweep, Taylor};
use std::f64::consts::TAU;

/// The checks of this file.
pub const CHECKS: [Check; 1] =
    [Check { name: "reference-of-tables", run: |draw| tables(draw).unwrap_or_else(Outcome::Fails) }];

/// x'' = p(φ) - c x' - κ(φ) x with the curves p and κ.
#[derive(Debug)]
struct Mass {
    curves: [Curve; 2],
    speed: f64,
    damping: f64,
    start: [f64; 2],
}

/// Mean, RMS, minimum and maximum of coordinate and velocity.
type Numbers = [[f64; 4]; 2];

/// Periods before the measurement and in it.
const SETTLE: usize = 1;
const MEASURE: usize = 2;

/// Accuracy of the end of a run by `Dop853`, which passes over knots that lie close together, and by `Taylor`
/// or by short steps; shares of the range.
const OF_KNOTS: f64 = 1e-8;
const OF_SERIES: f64 = 1e-9;

/// Accuracy of the figures of a row.
const OF_ROWS: f64 = 1e-8;

/// Least number of steps of the reference in a period.
const STEPS: f64 = 1024.0;

fn told(error: impl std::fmt::Display) -> String {
    error.to_string()
}

impl Mass {
    fn draw(draw: &mut Draw) -> Self {
        let push = Curve::draw(draw, 0.0, 1.0);
        let mean = draw.within(0.5, 3.0);
        let part = draw.within(0.1, 0.6) * mean;
        let stiffness = Curve::draw(draw, mean, part);
        let speed = draw.within(0.4, 2.0);
        let start = [draw.within(-0.5, 0.5), draw.within(-0.5, 0.5)];
        Mass { curves: [push, stiffness], speed, damping: draw.within(0.02, 0.3), start }
    }

    /// The period of the drives: both curves repeat after the common divisor of their orders.
    fn period(&self) -> f64 {
        let [a, b] = [0, 1].map(|i| self.curves[i].order);
        let common = (1..=a.min(b)).rev().find(|n| a % n == 0 && b % n == 0).unwrap_or(1);
        TAU / (self.speed * f64::from(common))
    }

    /// The figures of the measured periods and the state at their end, with `steps` steps in a period.
    fn reference(&self, steps: f64) -> (Numbers, Vec<f64>) {
        let curves = [0, 1].map(|i| self.curves[i].plain());
        let places: Vec<f64> =
            self.curves.iter().flat_map(|curve| curve.places()).map(|angle| angle / self.speed).collect();
        let accel = |at: &At<'_>| {
            let [push, stiffness] = [0, 1].map(|i| curves[i](self.speed * at.t));
            push - self.damping * at.v[0] - stiffness * at.q[0]
        };
        let plain = Plain {
            dof: 1,
            contacts: 0,
            accel: &|at, _, a| a[0] = accel(at),
            distances: &|_, _| [0.0; 2],
            jump: &|t| next_of(&places, TAU / self.speed, t),
            impact: None,
        };
        let period = self.period();
        let [begin, end] = [SETTLE, SETTLE + MEASURE].map(|n| n as f64 * period);
        let (y, _) = plain.run(0.0, &self.start, begin, period / steps, &mut |_| {});
        let mut sums = [[0.0; 2]; 2];
        let mut extremes = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        let (y, _) = plain.run(begin, &y, end, period / steps, &mut |part| {
            let (ends, h) = ([&part.start, &part.end], part.end.t - part.start.t);
            let [x, v, a] = [ends.map(|at| at.q[0]), ends.map(|at| at.v[0]), ends.map(accel)];
            for (i, (values, slopes)) in [(x, v), (v, a)].into_iter().enumerate() {
                let [low, high] = extremes_of_cubic(values, slopes, h);
                extremes[i] = [extremes[i][0].min(low), extremes[i][1].max(high)];
                let squares = [0, 1].map(|k| values[k] * values[k]);
                let rates = [0, 1].map(|k| 2.0 * values[k] * slopes[k]);
                sums[i][0] += integral_of_cubic(values, slopes, h);
                sums[i][1] += integral_of_cubic(squares, rates, h);
            }
        });
        let figures = |i: usize| {
            let [mean, square] = sums[i].map(|sum| sum / (end - begin));
            [mean, square.sqrt(), extremes[i][0], extremes[i][1]]
        };
        ([0, 1].map(figures), y)
    }
}

fn tables(draw: &mut Draw) -> Result<Outcome, String> {
    let mass = Mass::draw(draw);
    draw.note(|| format!("{mass:?}"));
    compare(draw, &mass).map_err(|error| format!("{error}; {mass:?}"))
}

fn compare(draw: &mut Draw, mass: &Mass) -> Result<Outcome, String> {
    let waves = [mass.curves[0].wave().map_err(told)?, mass.curves[1].wave().map_err(told)?];
    // The splines themselves, away from the jumps.
    for (wave, curve) in waves.iter().zip(&mass.curves) {
        let plain = curve.plain();
        for _ in 0..8 {
            let angle = draw.within(-20.0, 20.0);
            let [exact, found] = [plain(angle), wave.value(angle, Side::After)];
            if (found - exact).abs() > 1e-12 {
                return Err(format!("the wave at {angle:?} is {found:?}, {exact:?}"));
            }
        }
    }
    let machine = Driven { waves }.at(mass.speed, 0.0, mass.damping).map_err(told)?;
    let period = mass.period();
    if (machine.period() - period).abs() > 1e-12 * period {
        return Err(format!("the period is {:?}, {period:?}", machine.period()));
    }
    let [(before, coarse), (exact, fine)] = [STEPS, 2.0 * STEPS].map(|steps| mass.reference(steps));
    let size = [0, 1].map(|i| exact[i][3] - exact[i][2]);
    let start = State::new(0.0, &[mass.start[0]], &[mass.start[1]]);
    let end = (SETTLE + MEASURE) as f64 * period;
    let short = Dop853::new().rtol(1e-12).atol(1e-14).max_step(period / 3000.0);
    let ends = [
        ("Dop853", Dop853::new().rtol(1e-12).atol(1e-14).end(&machine, &start, end), OF_KNOTS),
        ("Dop853 by short steps", short.end(&machine, &start, end), OF_SERIES),
        ("Taylor", Taylor::new().end(&machine, &start, end), OF_SERIES),
    ];
    for (name, state, share) in ends {
        let state = state.map_err(|error| format!("{name}: {error}"))?;
        for (i, found) in [state.q[0], state.v[0]].into_iter().enumerate() {
            let allowed = 2.0 * (fine[i] - coarse[i]).abs() + share * size[i];
            let off = (found - fine[i]).abs();
            draw.note(|| format!("{name}: end {i} off by {off:e}, allowed {allowed:e}"));
            if off.is_nan() || off > allowed {
                return Err(format!("{name}: end {i} off by {off:e}, allowed {allowed:e}"));
            }
        }
    }
    let rows = [
        ("LaneTaylor", figures(&machine, &start, &LaneTaylor::new(Taylor::new())), OF_ROWS),
        (
            "Located(Dop853)",
            figures(&machine, &start, &Located(Dop853::new().rtol(1e-12).atol(1e-14))),
            OF_ROWS,
        ),
        ("Located(Taylor)", figures(&machine, &start, &Located(Taylor::new())), OF_ROWS),
    ];
    for (name, row, share) in rows {
        let found = row.map_err(|error| format!("{name}: {error}"))?;
        for i in 0..2 {
            for (k, what) in ["mean", "RMS", "minimum", "maximum"].into_iter().enumerate() {
                let allowed = 2.0 * (exact[i][k] - before[i][k]).abs() + share * size[i];
                let off = (found[i][k] - exact[i][k]).abs();
                draw.note(|| format!("{name}: {what} {i} off by {off:e}, allowed {allowed:e}"));
                if off.is_nan() || off > allowed {
                    let channel = ["coordinate", "velocity"][i];
                    return Err(format!(
                        "{name}: {what} of the {channel} off by {off:e}, allowed {allowed:e}"
                    ));
                }
            }
        }
    }
    Ok(Outcome::Agrees)
}

fn figures<E: SweepEngine<Swept>>(
    machine: &Machine<Driven>,
    start: &State,
    engine: &E,
) -> Result<Numbers, String> {
    let speed = machine.constant("speed").map_err(told)?;
    let points = Axis::of_values("speed", &[speed]).map_err(told)?;
    let sweep = Sweep::new(points).settle(SETTLE).measure(MEASURE).channels(&["q0", "v0"]);
    let sweep = sweep.of(engine, |p| machine.with("speed", p["speed"]));
    let rows = sweep.start(|_, _| Ok::<_, ParameterError>(start.clone())).run().map_err(told)?;
    let row = rows.get(0).map_err(told)?;
    Ok(["q0", "v0"].map(|name| row.channel(name).map_or([f64::NAN; 4], |s| [s.mean, s.rms, s.min, s.max])))
}

/// The model of the sweeps.
type Swept = Machine<Driven>;
