//! Extremes, means and RMS of channels that jump, at drive edges and where a contact with damping begins or
//! ends: every engine against the one-sided values of an integration that shares nothing with the crate.

use crate::api::*;
use crate::common::random::Random;
use gear_dynamics::branches::{Continuation, Family};
use gear_dynamics::random::{LongRun, NoisySteps, WhiteNoise};
use gear_dynamics::trains::{Body, MeshPart, Parts, Train};
use std::f64::consts::TAU;

/// A spur pair 20/40 with a rectangular mesh stiffness: its relative motion is m d'' = F - W.
#[derive(Clone, Copy)]
struct Spur {
    speed: f64,
    /// Share of the mesh period with the high stiffness.
    duty: f64,
    damping: f64,
    in_contact: bool,
    torque: f64,
}

const STIFFNESS: [f64; 2] = [1.6e8, 2.4e8];
const HALF_BACKLASH: f64 = 5e-5;
/// 1/(r₁²/J₁ + r₂²/J₂).
const MASS: f64 = 1.0 / (0.03 * 0.03 / 1e-3 + 0.06 * 0.06 / 4e-3);

impl Spur {
    fn train(&self) -> Train {
        let mut parts = Parts::new();
        parts.body("pinion", Body::new(1e-3)).body("wheel", Body::new(4e-3));
        let wave = RectangularWave::of_contact_ratio(1.0 + self.duty, STIFFNESS[0], STIFFNESS[1]).unwrap();
        let damping = if self.in_contact { ContactDamping::InContact } else { ContactDamping::Always };
        let mesh = MeshPart::external([20, 40], [0.03, 0.06], Wave::new(wave))
            .half_backlash(HALF_BACKLASH)
            .damping(self.damping)
            .contact_damping(damping);
        parts.mesh("mesh", "pinion", "wheel", mesh);
        parts.torque("drive", "pinion", self.torque).torque("load", "wheel", -2.0 * self.torque);
        parts.build("pinion", self.speed).unwrap()
    }

    /// The force on a piece: 0 the gap, ±1 a flank.
    fn force(&self, k: f64, piece: i32, [d, v]: [f64; 2]) -> f64 {
        let elastic = if piece == 0 { 0.0 } else { k * (d - f64::from(piece) * HALF_BACKLASH) };
        elastic + if piece == 0 && self.in_contact { 0.0 } else { self.damping * v }
    }

    fn step(&self, k: f64, piece: i32, [d, v]: [f64; 2], h: f64) -> [f64; 2] {
        let load = self.torque / 0.03;
        let rate = |[d, v]: [f64; 2]| [v, (load - self.force(k, piece, [d, v])) / MASS];
        let along = |r: [f64; 2], h: f64| [d + h * r[0], v + h * r[1]];
        let a = rate([d, v]);
        let b = rate(along(a, 0.5 * h));
        let c = rate(along(b, 0.5 * h));
        let e = rate(along(c, h));
        [0, 1].map(|i| [d, v][i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + e[i]))
    }

    /// Minimum, maximum, mean and RMS of the force over the last `measure` of some mesh periods: steps of RK4
    /// that end on drive edges and, by bisection, on edges of the gap; every step gives the values at both
    /// ends on its own piece. Simpson's rule for the integrals.
    fn reference(&self, settle: usize, measure: usize, steps: usize) -> [f64; 4] {
        let period = TAU / (20.0 * self.speed);
        // The static state under the mean stiffness at the start, as the engine: motions may coexist.
        let stiffness = (1.0 - self.duty) * STIFFNESS[0] + self.duty * STIFFNESS[1];
        let mut y = [HALF_BACKLASH + self.torque / 0.03 / stiffness, 0.0];
        let mut piece = 1;
        let [mut least, mut most, mut sum, mut square] = [f64::INFINITY, f64::NEG_INFINITY, 0.0, 0.0];
        for cycle in 0..settle + measure {
            // The high part is centred on the start of the cycle.
            for (k, share) in [(1, 0.5 * self.duty), (0, 1.0 - self.duty), (1, 0.5 * self.duty)] {
                let k = STIFFNESS[k];
                let n = (steps as f64 * share).ceil().max(1.0) as usize;
                let h = share * period / n as f64;
                for _ in 0..n {
                    let mut left = h;
                    while left > 1e-14 * h {
                        let out = |y: [f64; 2]| {
                            let low = y[0] < -HALF_BACKLASH;
                            let high = y[0] > HALF_BACKLASH;
                            match piece {
                                0 => low || high,
                                1 => !high,
                                _ => !low,
                            }
                        };
                        let (mut taken, whole) = (left, self.step(k, piece, y, left));
                        let crosses = out(whole) && taken > 1e-9 * h;
                        if crosses {
                            let [mut a, mut b] = [0.0, left];
                            for _ in 0..60 {
                                let middle = 0.5 * (a + b);
                                if out(self.step(k, piece, y, middle)) { b = middle } else { a = middle }
                            }
                            taken = b;
                        }
                        let middle = self.step(k, piece, y, 0.5 * taken);
                        let end = self.step(k, piece, y, taken);
                        if cycle >= settle {
                            let [a, b, c] = [y, middle, end].map(|y| self.force(k, piece, y));
                            // The vertex of the parabola through the three values, if it lies between them.
                            let (slope, bend) = (c - a, a + c - 2.0 * b);
                            let inside = slope.abs() < 2.0 * bend.abs();
                            let vertex = if inside { b - slope * slope / (8.0 * bend) } else { b };
                            for f in [a, b, c, vertex] {
                                (least, most) = (f64::min(least, f), f64::max(most, f));
                            }
                            sum += taken / 6.0 * (a + 4.0 * b + c);
                            square += taken / 6.0 * (a * a + 4.0 * b * b + c * c);
                        }
                        if crosses {
                            piece = if piece != 0 {
                                0
                            } else if end[0] > 0.0 {
                                1
                            } else {
                                -1
                            };
                        }
                        (y, left) = (end, left - taken);
                    }
                }
            }
        }
        let time = measure as f64 * period;
        [least, most, sum / time, (square / time).sqrt()]
    }

    fn row<E: SweepEngine<Train>>(&self, engine: &E, settle: usize, measure: usize) -> Summary {
        let points = Axis::of_values("speed", &[self.speed]).unwrap();
        let sweep = Sweep::new(points).settle(settle).measure(measure).channels(&["mesh force"]);
        let rows = sweep.of(engine, |_| Ok::<_, ParameterError>(self.train())).run().unwrap();
        rows.get(0).unwrap().channel("mesh force").unwrap()
    }
}

/// Compares the figures of a channel with those of the reference, within a share of its range.
fn compare(what: &str, found: &Summary, [min, max, mean, rms]: [f64; 4], within: f64) {
    let range = max - min;
    let pairs = [
        ("min", found.min, min),
        ("max", found.max, max),
        ("mean", found.mean, mean),
        ("rms", found.rms, rms),
    ];
    for (name, x, y) in pairs {
        assert!((x - y).abs() <= within * range, "{what}, {name}: {x} {y}");
    }
}

fn series() -> Taylor {
    Taylor::new().rtol(1e-10).atol(1e-16)
}

/// The pair of three speeds: both engines with located edges. The reference with half as many steps agrees
/// to 1e-7.
#[test]
fn located_engines_show_both_sides_of_a_jump() {
    for speed in [100.0, 200.0, 300.0] {
        let pair = Spur { speed, duty: 0.5, damping: 2000.0, in_contact: false, torque: 60.0 };
        let [exact, coarse] = [3200, 1600].map(|steps| pair.reference(40, 4, steps));
        assert!(
            exact.iter().zip(&coarse).all(|(x, y)| (x - y).abs() < 1e-7 * exact[1]),
            "{exact:?} {coarse:?}"
        );
        // A period of the train may be a mesh cycle or a turn: both settle.
        compare("LaneTaylor", &pair.row(&LaneTaylor::new(series()), 60, 4), exact, 1e-6);
        compare("Located", &pair.row(&Located(Dop853::new().rtol(1e-10).atol(1e-16)), 60, 4), exact, 1e-6);
    }
}

/// Random pairs: speeds, contact ratios, dampings always or in contact only, loads from rattle to full contact.
/// Motions that do not repeat are left out, by the reference with two measured times.
#[test]
fn located_engines_show_both_sides_of_jumps_of_random_pairs() {
    let (mut random, mut compared, mut apart) = (Random(11), 0, 0);
    for _ in 0..18 {
        let pair = Spur {
            speed: 60.0 + 400.0 * random.next(),
            duty: 0.1 + 0.8 * random.next(),
            damping: 40.0 + 800.0 * random.next() * random.next(),
            in_contact: random.next() < 0.7,
            torque: 1.0 + 60.0 * random.next() * random.next(),
        };
        let exact = pair.reference(150, 10, 800);
        let later = pair.reference(170, 20, 400);
        if exact.iter().zip(&later).any(|(x, y)| (x - y).abs() > 1e-5 * exact[1]) {
            continue;
        }
        let found = pair.row(&LaneTaylor::new(series()), 200, 20);
        compare(&format!("{} {}", pair.speed, pair.duty), &found, exact, 2e-5);
        compared += 1;
        apart += usize::from(exact[0] <= 0.0);
    }
    assert!(compared >= 10 && apart >= 1, "{compared} {apart}");
}

/// Fixed steps that end on the drive edges, without contact loss: both sides of each edge. The sums over
/// samples are of second order in the step: with 4 times the steps their error is 16 times smaller.
#[test]
fn lanes_with_fixed_steps_show_both_sides_of_drive_edges() {
    let pair = Spur { speed: 100.0, duty: 0.5, damping: 2000.0, in_contact: false, torque: 60.0 };
    let exact = pair.reference(40, 4, 1600);
    let steps = LaneRk4::of_model(&pair.train()).unwrap().steps().next_multiple_of(80);
    let errors = [1, 4].map(|finer| {
        let [lanes, table] =
            [pair.row(&LaneRk4::new(finer * steps), 60, 4), pair.row(&TableRk4::new(finer * steps), 60, 4)];
        assert_eq!(lanes, table);
        let range = exact[1] - exact[0];
        // A smooth extremum between samples is missed by (ω h)²/8 of its amplitude, half the range, with ω h =
        // 1/2 by `of_model`; a jump is not missed.
        compare("lanes", &lanes, exact, 1.6e-2 / (finer * finer) as f64);
        ((lanes.mean - exact[2]).abs() + (lanes.rms - exact[3]).abs()) / range
    });
    assert!(errors[1] < errors[0] / 8.0 + 1e-9, "{errors:?}");
}

/// White noise of no weight: the largest and the least value are those of the motion without noise, and the
/// mean is of second order.
#[test]
fn runs_under_noise_show_both_sides_of_drive_edges() {
    let pair = Spur { speed: 100.0, duty: 0.5, damping: 2000.0, in_contact: false, torque: 60.0 };
    let exact = pair.reference(40, 4, 1600);
    let steps = LaneRk4::of_model(&pair.train()).unwrap().steps().next_multiple_of(80) * 2;
    let solver = NoisySteps::new(steps, &[WhiteNoise::bath(0, 0.0, 1e-30).unwrap()]);
    let long = LongRun::new(60.0, 2.0).unwrap().members(8).channels(&["mesh force"]);
    let seen = long.run(&solver, &pair.train(), None).unwrap();
    let of = |x: &Distribution| 0.5 * (x.min() + x.max());
    let [least, largest] = [of(seen.least("mesh force").unwrap()), of(seen.largest("mesh force").unwrap())];
    let mean = seen.mean("mesh force").unwrap().mean();
    for (name, x, y) in [("min", least, exact[0]), ("max", largest, exact[1]), ("mean", mean, exact[2])] {
        assert!((x - y).abs() < 1e-3 * (exact[1] - exact[0]), "{name}: {x} {y}");
    }
}

/// Branches by shooting and by balance: one orbit without and one with contact loss. A balance of 60 orders
/// errs by the jumps of the acceleration: its force within 1 %.
#[test]
fn branches_show_both_sides_of_a_jump() {
    for (torque, speed) in [(60.0, 100.0), (60.0, 103.0)] {
        let pair = Spur { speed, duty: 0.5, damping: 2000.0, in_contact: true, torque };
        let exact = pair.reference(40, 4, 1600);
        let (train, dense) = (pair.train(), Dop853::new().rtol(1e-10).atol(1e-16));
        let steady = Settle::new().max_periods(20_000).run(&dense, &train, None).unwrap();
        let family = Family::over(&train, ["speed"]).unwrap();
        let continuation = Continuation::new(speed, speed + 0.1).channels(&["mesh force"]).max_points(2);
        let branch = continuation.run(&family, &steady.state).unwrap();
        compare("shooting", &branch.points()[0].summaries[0], exact, 1e-5);
        let harmonics = Harmonics::up_to(60);
        let guess = FourierOrbit::project(&dense, &train, &steady.state, &harmonics).unwrap();
        let branch = continuation.balance(Balance::new(harmonics)).run(&family, &guess).unwrap();
        compare("balance", &branch.points()[0].summaries[0], exact, 1e-2);
    }
}

/// The channel is 10 (t - floor(t)) + 0.5 q, which jumps by -10 at whole times.
struct Saw;

impl Model for Saw {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = 0.0;
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        let whole = if side == Side::Before { t.ceil() - 1.0 } else { t.floor() };
        u[0] = t - whole;
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        Some(t.floor() + 1.0)
    }
    fn channels(&self) -> Vec<Channel> {
        vec![Channel::new("saw", "1")]
    }
    fn write_channels(&self, u: &[f64], q: &[f64], _: &[f64], _: &[Contact], out: &mut [f64]) {
        out[0] = 10.0 * u[0] + 0.5 * q[0];
    }
}

/// An ensemble at an instant has the values before a jump, at the start those after it; its peaks have both sides.
#[test]
fn an_ensemble_at_a_jump_has_the_values_before_it() {
    let member = |_: u64| Ok::<_, ParameterError>((Saw, State::new(0.0, &[-20.0], &[-1.0])));
    let ensemble = Ensemble::new(3, 2.0, 4).unwrap().channels(&["saw"]).peaks(&["saw"]);
    let bands = ensemble.run(&Dop853::new(), member).unwrap();
    for (i, expected) in [-10.0, -5.25, -0.5, -5.75, -1.0].into_iter().enumerate() {
        let value = bands.at("saw", i).unwrap();
        assert!((value.min() - expected).abs() < 1e-9 && (value.max() - expected).abs() < 1e-9, "{i}");
    }
    // |x| is largest after the jump at t = 1.
    assert!((bands.peak("saw").unwrap().max() - 10.5).abs() < 1e-9);
}
