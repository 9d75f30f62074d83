//! Waterfalls of run-ups and coast-downs against the reference, transformed line by line.

use crate::draw::Draw;
use crate::models::curve::Curve;
use crate::models::driven::Driven;
use crate::reference::{Plain, exceeds};
use crate::{Check, Outcome};
use gear_dynamics::analysis::Waterfall;
use gear_dynamics::drives::{SpeedLaw, VaryingSpeed};
use gear_dynamics::{Dop853, Rk45, State};
use std::f64::consts::TAU;

/// The checks of this file.
pub const CHECKS: [Check; 1] =
    [Check { name: "reference-of-waterfalls", run: |draw| waterfalls(draw).unwrap_or_else(Outcome::Fails) }];

/// A driven mass whose shaft has the speeds `speeds` at `times`, linear between them and constant afterwards.
#[derive(Debug)]
struct RunUp {
    curves: [Curve; 2],
    damping: f64,
    start: [f64; 2],
    times: Vec<f64>,
    speeds: Vec<f64>,
    turns: usize,
    samples: usize,
    windows: usize,
}

/// One window: middle, mean speed, amplitudes of the coordinate and of the velocity.
struct Line {
    t: f64,
    speed: f64,
    amplitudes: [Vec<f64>; 2],
}

/// Accuracy of a method whose steps pass over knots of a spline that lie close together, as a share of
/// the largest amplitude.
const OF_KNOTS: f64 = 1e-8;

/// Least number of steps of the reference in a turn.
const STEPS: f64 = 256.0;

fn told(error: impl std::fmt::Display) -> String {
    error.to_string()
}

impl RunUp {
    fn draw(draw: &mut Draw) -> Self {
        let push = Curve::draw(draw, 0.0, 1.0);
        let mean = draw.within(0.5, 4.0);
        let part = draw.within(0.1, 0.6) * mean;
        let stiffness = Curve::draw(draw, mean, part);
        let knots = 1 + draw.below(3);
        let (mut times, mut speeds) = (vec![0.0], vec![draw.within(0.5, 2.0)]);
        for k in 0..knots {
            times.push(times[k] + draw.within(2.0, 15.0));
            speeds.push(draw.within(0.5, 2.0));
        }
        let damping = draw.within(0.02, 0.3);
        let start = [draw.within(-0.5, 0.5), draw.within(-0.5, 0.5)];
        let turns = 1 + draw.below(2);
        let samples = draw.one_of(&[8, 12, 15, 32]);
        RunUp {
            curves: [push, stiffness],
            damping,
            start,
            times,
            speeds,
            turns,
            samples,
            windows: 1 + draw.below(3),
        }
    }

    /// The angle at a time.
    fn angle(&self, t: f64) -> f64 {
        let mut angle = 0.0;
        for (times, speeds) in self.times.windows(2).zip(self.speeds.windows(2)) {
            let slope = (speeds[1] - speeds[0]) / (times[1] - times[0]);
            let dt = t.min(times[1]) - times[0];
            angle += dt * (speeds[0] + 0.5 * slope * dt);
            if t <= times[1] {
                return angle;
            }
        }
        let last = self.times.len() - 1;
        angle + self.speeds[last] * (t - self.times[last])
    }

    /// The time of an angle, by bisection: all speeds are at least 0.5.
    fn time(&self, angle: f64) -> f64 {
        let (mut low, mut high) = (0.0, angle / 0.4);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if self.angle(middle) < angle { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }

    /// The lines, from the reference with steps of at most `h`.
    fn reference(&self, h: f64) -> Vec<Line> {
        let curves = [0, 1].map(|i| self.curves[i].plain());
        let window = self.turns * self.samples;
        let all = window * self.windows;
        let times: Vec<f64> = (0..all).map(|k| self.time(TAU * k as f64 / self.samples as f64)).collect();
        // All jumps of the drives and of the speed's slope.
        let turns = self.turns * self.windows;
        let places: Vec<f64> = self.curves.iter().flat_map(Curve::places).collect();
        let angles =
            (0..=turns + 1).flat_map(|turn| places.iter().map(move |x| x + TAU * (turn as f64 - 1.0)));
        let mut jumps: Vec<f64> = angles.filter(|angle| *angle > 0.0).map(|angle| self.time(angle)).collect();
        jumps.extend(&self.times);
        jumps.sort_by(f64::total_cmp);
        let plain = Plain {
            dof: 1,
            contacts: 0,
            accel: &|at, _, a| {
                let angle = self.angle(at.t);
                let [push, stiffness] = [0, 1].map(|i| curves[i](angle));
                a[0] = push - self.damping * at.v[0] - stiffness * at.q[0];
            },
            distances: &|_, _| [0.0; 2],
            jump: &|t| {
                let next = jumps.partition_point(|jump| *jump <= t);
                jumps.get(next).copied().unwrap_or(f64::INFINITY)
            },
            impact: None,
        };
        let mut y = self.start.to_vec();
        let mut states = vec![y.clone()];
        for pair in times.windows(2) {
            y = plain.run(pair[0], &y, pair[1], h, &mut |_| {}).0;
            states.push(y.clone());
        }
        let windows = times.chunks_exact(window).zip(states.chunks_exact(window));
        windows
            .map(|(times, states)| {
                let span = times[window - 1] - times[0];
                Line {
                    t: 0.5 * (times[0] + times[window - 1]),
                    speed: TAU * (window - 1) as f64 / self.samples as f64 / span,
                    amplitudes: [0, 1]
                        .map(|i| amplitudes(&states.iter().map(|y| y[i]).collect::<Vec<f64>>())),
                }
            })
            .collect()
    }
}

/// Amplitudes under the weights w_m = 1 - cos(2π m/n), by the definition: s |Σ w x e^(-2πi k m/n)|/Σ w, with
/// s = 1 for the mean and for n/2, and 2 for all other lines.
fn amplitudes(x: &[f64]) -> Vec<f64> {
    let n = x.len();
    let turn = TAU / n as f64;
    let weight = |m: usize| 1.0 - (turn * m as f64).cos();
    let total: f64 = (0..n).map(weight).sum();
    let line = |k: usize| {
        let [mut real, mut imaginary] = [0.0; 2];
        for (m, x) in x.iter().enumerate() {
            let (sine, cosine) = (turn * (k * m % n) as f64).sin_cos();
            real += weight(m) * x * cosine;
            imaginary += weight(m) * x * sine;
        }
        let sides = if k == 0 || 2 * k == n { 1.0 } else { 2.0 };
        sides * f64::hypot(real, imaginary) / total
    };
    (0..=n / 2).map(line).collect()
}

fn waterfalls(draw: &mut Draw) -> Result<Outcome, String> {
    let run_up = RunUp::draw(draw);
    draw.note(|| format!("{run_up:?}"));
    compare(draw, &run_up).map_err(|error| format!("{error}; {run_up:?}"))
}

fn compare(draw: &mut Draw, run_up: &RunUp) -> Result<Outcome, String> {
    let waves = [run_up.curves[0].wave().map_err(told)?, run_up.curves[1].wave().map_err(told)?];
    let machine = Driven { waves }.at(1.0, 0.0, run_up.damping).map_err(told)?;
    let law = SpeedLaw::table(&run_up.times, &run_up.speeds).map_err(told)?;
    let model = VaryingSpeed::new(machine, law);
    let h = TAU / STEPS;
    let [coarse, fine] = [h, 0.5 * h].map(|h| run_up.reference(h));
    // Half a turn beyond the last window, which has no line of its own.
    let end = run_up.time(TAU * ((run_up.turns * run_up.windows) as f64 + 0.5));
    let start = State::new(0.0, &[run_up.start[0]], &[run_up.start[1]]);
    let waterfall = Waterfall::new(run_up.turns, run_up.samples).map_err(told)?;
    // `Taylor` refuses tables over an angle of varying speed.
    let (dop853, rk45) = (Dop853::new().rtol(1e-12).atol(1e-14), Rk45::new().rtol(1e-12).atol(1e-14));
    for (i, channel) in ["q0", "v0"].into_iter().enumerate() {
        let runs = [
            ("Dop853", waterfall.run(&dop853, &model, &start, end, channel)),
            ("Rk45", waterfall.run(&rk45, &model, &start, end, channel)),
        ];
        for (name, lines) in runs {
            let lines = lines.map_err(|error| format!("{name}: {error}"))?;
            if lines.len() != fine.len() {
                return Err(format!("{name}: {} lines, {}", lines.len(), fine.len()));
            }
            for (k, (found, exact)) in lines.iter().zip(&fine).enumerate() {
                let expected = &exact.amplitudes[i];
                let before = &coarse[k].amplitudes[i];
                let size = expected.iter().fold(0.0, |size: f64, x| size.max(*x));
                let apart = |other: &[f64]| {
                    expected.iter().zip(other).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
                };
                let (off, allowed) = (apart(&found.amplitudes), 2.0 * apart(before) + OF_KNOTS * size);
                draw.note(|| format!("{name}: window {k} of {channel} off by {off:e}, allowed {allowed:e}"));
                if off.is_nan() || off > allowed || found.amplitudes.len() != expected.len() {
                    return Err(format!(
                        "{name}: window {k} of {channel} off by {off:e}, allowed {allowed:e}"
                    ));
                }
                let orders = found.orders.iter().enumerate();
                let order = |(j, order): (usize, &f64)| (order - j as f64 / run_up.turns as f64).abs();
                if found.orders.len() != expected.len() || orders.map(order).fold(0.0, f64::max) > 1e-12 {
                    return Err(format!("{name}: the orders are {:?}", found.orders));
                }
                let [off_time, off_speed] = [(found.t - exact.t) / exact.t, found.speed / exact.speed - 1.0];
                if exceeds(off_time.abs(), 1e-12) || exceeds(off_speed.abs(), 1e-12) {
                    return Err(format!("{name}: window {k} at {:?}, speed {:?}", found.t, found.speed));
                }
            }
        }
    }
    Ok(Outcome::Agrees)
}
