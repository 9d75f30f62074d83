//! Stationary and periodic densities by path integration: closed forms, moments, Monte Carlo, bad input.

use crate::api::*;
use gear_dynamics::models::Oscillator;
use gear_dynamics::random::{DensityError, PathIntegration, StateDensity};
use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// ∫∫ |p - r/∫∫ r| dx dv by the midpoint rule on 300 × 300 cells.
fn distance(density: &StateDensity, r: impl Fn(f64, f64) -> f64) -> f64 {
    let ends = |nodes: &[f64]| [nodes[0], nodes[nodes.len() - 1]];
    let cells =
        |[low, high]: [f64; 2]| (0..300).map(move |k| low + (high - low) * (f64::from(k) + 0.5) / 300.0);
    let (x, v) = (ends(density.deflections()), ends(density.velocities()));
    let all: Vec<_> = cells(x).flat_map(|x| cells(v).map(move |v| (x, v))).collect();
    let mass: f64 = all.iter().map(|(x, v)| r(*x, *v)).sum();
    let area = (x[1] - x[0]) * (v[1] - v[0]) / 9e4;
    all.iter().map(|(x, v)| (density.at(*x, *v) * area - r(*x, *v) / mass).abs()).sum()
}

fn oscillator(constants: &[(&str, f64)]) -> Oscillator {
    Oscillator::new(&[&[("speed", 1.0)], constants].concat()).unwrap()
}

/// Name, density and its distance from exp(-β (v²/2 + G(x))), β = 2c/D, of a linear oscillator, Duffing's
/// with one well and with two, and a dead zone.
fn conservative(panels: usize) -> Vec<(&'static str, StateDensity, f64)> {
    let springs =
        |k: f64, cubic: f64| [("damping", 0.2), ("linear stiffness", k), ("cubic stiffness", cubic)];
    let mesh = [("damping", 0.2), ("mesh stiffness", 1.0), ("half backlash", 1.0)];
    let quartic = |k: f64, cubic: f64| move |x: f64| 0.5 * k * x * x + 0.25 * cubic * x.powi(4);
    type Potential = Box<dyn Fn(f64) -> f64>;
    let cases: [(&str, Oscillator, f64, [f64; 2], Potential); 4] = [
        ("linear", oscillator(&springs(1.0, 0.0)), 0.4, [6.0, 6.0], Box::new(quartic(1.0, 0.0))),
        ("one well", oscillator(&springs(1.0, 1.0)), 0.4, [3.5, 6.0], Box::new(quartic(1.0, 1.0))),
        ("two wells", oscillator(&springs(-1.0, 1.0)), 0.2, [3.0, 4.2], Box::new(quartic(-1.0, 1.0))),
        (
            "dead zone",
            oscillator(&mesh),
            0.4,
            [7.0, 6.0],
            Box::new(|x| 0.5 * (x.abs() - 1.0).max(0.0).powi(2)),
        ),
    ];
    let solve = |(name, model, intensity, [x, v], potential): (_, Oscillator, f64, [f64; 2], Potential)| {
        let method = PathIntegration::new(intensity, [-x, x], [-v, v]).unwrap().panels(panels);
        let density = method.stationary(&model).unwrap();
        let beta = 0.4 / intensity;
        let from_exact = distance(&density, |x, v| (-beta * (0.5 * v * v + potential(x))).exp());
        println!("{name}: {from_exact:.1e}, estimate {:.1e}", density.total_error());
        (name, density, from_exact)
    };
    cases.into_iter().map(solve).collect()
}

#[test]
fn stationary_densities_are_within_their_errors_of_the_closed_forms() {
    for (name, density, from_exact) in conservative(4) {
        assert!(from_exact < density.total_error(), "{name}: {from_exact:.2e} {:.2e}", density.total_error());
        assert!(from_exact < 0.01, "{name}: {from_exact:.2e}");
        assert!(density.values().iter().all(|p| *p >= 0.0) && (density.mean(|_, _| 1.0) - 1.0).abs() < 1e-12);
    }
}

#[test]
#[ignore = "half a minute with optimisation: cargo test --release --test suite random_densities -- --ignored"]
fn stationary_densities_to_1e_4() {
    for (name, density, from_exact) in conservative(10) {
        assert!(from_exact < density.total_error(), "{name}: {from_exact:.2e} {:.2e}", density.total_error());
        assert!(
            from_exact < 1e-5 && density.total_error() < 1e-4,
            "{name}: {from_exact:.2e} {:.2e}",
            density.total_error()
        );
    }
}

/// P(gap) = 2b/Z, Z = 2b + √(2π/(βk)); rate of crossings 1/(√(2πβ) Z); mean square of v 1/β.
#[test]
fn shares_and_crossings_of_a_dead_zone() {
    let model = oscillator(&[("damping", 0.2), ("mesh stiffness", 1.0), ("half backlash", 0.5)]);
    let method = PathIntegration::new(0.4, [-6.5, 6.5], [-6.0, 6.0]).unwrap().panels(5);
    let density = method.stationary(&model).unwrap();
    let z = 1.0 + TAU.sqrt();
    let rate = 1.0 / (TAU.sqrt() * z);
    assert!(density.deflections().contains(&-0.5) && density.deflections().contains(&0.5));
    for (value, exact) in [
        (density.share(-0.5, 0.5), 1.0 / z),
        (density.share(f64::NEG_INFINITY, f64::INFINITY), 1.0),
        (density.upward_crossing_rate(0.5), rate),
        (density.downward_crossing_rate(0.5), rate),
        (density.upward_crossing_rate(-0.5), rate),
        (density.mean(|_, v| v * v), 1.0),
        (density.deflection_density(0.2), 1.0 / z),
        (density.velocity_density(1.0), (-0.5f64).exp() / TAU.sqrt()),
    ] {
        assert!((value - exact).abs() < 1e-3, "{value} {exact}");
    }
    assert_eq!(
        [density.at(7.0, 0.0), density.deflection_density(-7.0), density.velocity_density(7.0)],
        [0.0; 3]
    );
}

/// x'' + H x' + x = √D ξ with H = (x² + v²)/2: p ∝ exp(-H²/D). The damping is not constant: the splitting
/// has an error.
#[test]
fn damping_that_grows_with_the_energy() {
    let model = from_fn(1, |_, q, v, a| a[0] = -0.5 * (q[0] * q[0] + v[0] * v[0]) * v[0] - q[0]).unwrap();
    let exact = |x: f64, v: f64| (-0.25 * (x * x + v * v).powi(2)).exp();
    let method = PathIntegration::new(1.0, [-2.9, 2.9], [-2.9, 2.9]).unwrap().panels(4);
    let density = method.time_step(0.1).stationary(&model).unwrap();
    let from_exact = distance(&density, exact);
    println!("{from_exact:.1e} {:.1e}", density.total_error());
    assert!(
        from_exact < density.total_error() && from_exact < 0.005,
        "{from_exact:.2e} {:.2e}",
        density.total_error()
    );
}

/// Mean and covariance of a linear oscillator under white noise and a force of a period T: the response
/// without noise, and D/(2 c k), D/(2 c), 0.
fn moments_are_those_of_fokker_planck(model: &(dyn Periodic + Sync), step: f64) {
    let method = PathIntegration::new(1.0, [-6.0, 6.0], [-6.0, 6.0]).unwrap().panels(4).time_step(step);
    let density = method.run(model).unwrap();
    let steady = Settle::new().run(&Dop853::new().rtol(1e-9), model, &State::at_rest(1)).unwrap();
    let start = State::new(0.0, &steady.state.q, &steady.state.v); // settled at whole periods
    let orbit = Dop853::new().rtol(1e-9).sample(model, &start, density.times()).unwrap();
    for i in 0..density.times().len() {
        let (p, x, v) = (density.at(i), orbit.q(i)[0], orbit.v(i)[0]);
        let moments = [
            (p.mean(|x, _| x), x),
            (p.mean(|_, v| v), v),
            (p.mean(|at, _| (at - x) * (at - x)), 1.0),
            (p.mean(|at, rate| (at - x) * (rate - v)), 0.0),
            (p.mean(|_, rate| (rate - v) * (rate - v)), 1.0),
        ];
        for (moment, exact) in moments {
            assert!((moment - exact).abs() < 5e-3, "instant {i}: {moments:?}");
        }
    }
}

#[test]
fn moments_under_a_sine() {
    let constants = [("speed", 1.5), ("damping", 0.5), ("linear stiffness", 1.0), ("force", 0.5)];
    moments_are_those_of_fokker_planck(&Oscillator::new(&constants).unwrap(), 0.3);
}

/// x'' + 0.5 x' + x = ±0.5, the sign changes at 0.3 T and T, T = 4.
struct Switched;

impl Model for Switched {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = u[0] - 0.5 * v[0] - q[0];
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        let before = if side == Side::Before { 1e-9 } else { -1e-9 };
        u[0] = if (t - before).rem_euclid(4.0) < 1.2 { 0.5 } else { -0.5 };
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        let (period, phase) = ((t + 1e-9).div_euclid(4.0), (t + 1e-9).rem_euclid(4.0));
        Some(4.0 * period + if phase < 1.2 { 1.2 } else { 4.0 })
    }
}

impl Periodic for Switched {
    fn period(&self) -> f64 {
        4.0
    }
}

#[test]
fn moments_under_a_force_that_jumps() {
    moments_are_those_of_fokker_planck(&Switched, 0.4);
}

/// Random numbers of the Monte Carlo runs: SplitMix64 and the method of Box and Muller.
struct Normal {
    state: u64,
    spare: Option<f64>,
}

impl Normal {
    fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.state ^ (self.state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    fn next(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let (radius, angle) = ((-2.0 * (1.0 - self.uniform()).ln()).sqrt(), TAU * self.uniform());
        self.spare = Some(radius * angle.sin());
        radius * angle.cos()
    }
}

/// x'' + 0.2 x' + (1 + 0.2 cos Ωt) g(x) = 0.2 + 0.3 cos Ωt + √0.2 ξ, g the dead zone of half width 0.5, Ω =
/// 0.8, against 10⁸ steps of a splitting of weak order 2 written here: half of an Ornstein-Uhlenbeck step, a
/// Verlet step, the other half.
#[test]
#[ignore = "a minute with optimisation: cargo test --release --test suite random_densities -- --ignored"]
fn a_forced_dead_zone_against_monte_carlo() {
    let (c, omega, intensity, b) = (0.2, 0.8, 0.2, 0.5);
    let constants = [
        ("speed", omega),
        ("damping", c),
        ("mesh stiffness", 1.0),
        ("stiffness variation", 0.2),
        ("mean force", 0.2),
        ("force", 0.3),
        ("half backlash", b),
    ];
    let model = Oscillator::new(&constants).unwrap();
    let method = PathIntegration::new(intensity, [-5.5, 6.5], [-5.5, 5.5]).unwrap().panels(10).time_step(0.1);
    let density = method.run(&model).unwrap();
    let (mean, start) = (density.mean(), density.at(0));
    println!("errors of the mean {:.1e} and at 0 {:.1e}", mean.total_error(), start.total_error());
    let computed = [
        mean.share(-b, b),
        mean.upward_crossing_rate(b),
        mean.mean(|_, v| v * v),
        start.mean(|x, _| x),
        start.share(b, f64::INFINITY),
    ];

    let steps = 800; // in a period; 125 000 periods in 100 batches
    let h = TAU / omega / f64::from(steps);
    let (decay, kick) = ((-0.5 * c * h).exp(), (intensity * (1.0 - (-c * h).exp()) / (2.0 * c)).sqrt());
    let waves: Vec<f64> = (0..=steps).map(|k| (TAU * f64::from(k) / f64::from(steps)).cos()).collect();
    let force = |x: f64, wave: f64| 0.2 + 0.3 * wave - (1.0 + 0.2 * wave) * (x - x.clamp(-b, b));
    let mut normal = Normal { state: 34, spare: None };
    let (mut x, mut v) = (0.7, 0.0);
    let mut batches = Vec::new();
    for _ in 0..100 {
        let mut sums = [0.0; 5];
        for _ in 0..1250 {
            sums[3] += x;
            sums[4] += f64::from(u8::from(x > b));
            for k in 0..steps as usize {
                let before = x;
                v = decay * v + kick * normal.next();
                v += 0.5 * h * force(x, waves[k]);
                x += h * v;
                v += 0.5 * h * force(x, waves[k + 1]);
                v = decay * v + kick * normal.next();
                sums[0] += f64::from(u8::from(x.abs() < b)) * h;
                sums[1] += f64::from(u8::from(before <= b && x > b));
                sums[2] += v * v * h;
            }
        }
        let time = 1250.0 * TAU / omega;
        batches.push([sums[0] / time, sums[1] / time, sums[2] / time, sums[3] / 1250.0, sums[4] / 1250.0]);
    }
    for (i, computed) in computed.iter().enumerate() {
        let values: Vec<f64> = batches.iter().map(|batch| batch[i]).collect();
        let sampled = Summary::of_samples(&values).unwrap();
        let error = sampled.deviation / 10.0;
        println!("{computed:.6} against {:.6} ± {error:.6}", sampled.mean);
        // Three standard errors: 1.3 % of five values lie outside in correct runs. Below them lies the error
        // of the density.
        assert!((computed - sampled.mean).abs() < 3.0 * error, "{i}");
    }
}

#[test]
fn the_same_bits_with_any_number_of_threads() {
    let model = oscillator(&[("damping", 0.5), ("linear stiffness", 1.0)]);
    let method = PathIntegration::new(1.0, [-5.0, 5.0], [-5.0, 5.0]).unwrap().panels(2);
    let values = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| method.stationary(&model)).unwrap()
    };
    assert_eq!(values(1), values(3));
}

#[test]
fn bad_input_gives_typed_errors() {
    let unit = [-1.0, 1.0];
    for intensity in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e60] {
        assert!(PathIntegration::new(intensity, unit, unit).is_err(), "{intensity}");
    }
    for range in [[1.0, -1.0], [1.0, 1.0], [f64::NAN, 1.0], [0.0, f64::INFINITY], [-1e60, 1.0]] {
        assert!(
            PathIntegration::new(1.0, range, unit).is_err()
                && PathIntegration::new(1.0, unit, range).is_err()
        );
    }
    assert!(matches!(PathIntegration::new(1.0, unit, [1.0, 2.0]), Err(ParameterError::Bounds { .. })));

    let model = oscillator(&[("damping", 0.5), ("linear stiffness", 1.0), ("force", 1.0)]);
    let method = PathIntegration::new(1.0, [-5.0, 5.0], [-5.0, 5.0]).unwrap().panels(2);
    for wrong in [method.clone().panels(1), method.clone().panels(1000), method.clone().tolerance(0.0)] {
        assert!(matches!(wrong.run(&model), Err(DensityError::Parameter(_))));
    }
    for step in [0.0, -1.0, f64::NAN, 1e-40] {
        assert!(
            matches!(method.clone().time_step(step).run(&model), Err(DensityError::Parameter(_))),
            "{step}"
        );
    }
    assert!(matches!(method.stationary(&model), Err(DensityError::Varies { .. })));
    let two = from_fn(2, |_, q, _, a| a.copy_from_slice(q)).unwrap();
    assert_eq!(method.stationary(&two), Err(DensityError::Dof { dof: 2 }));
    let wrong = from_fn(1, |_, _, _, a| a[0] = f64::NAN).unwrap();
    assert!(method.stationary(&wrong).is_err());
    // Damping so strong that its differences are rounding: the motions never end their step.
    let stiff = method.stationary(&oscillator(&[("damping", 9e15), ("linear stiffness", 1.0)]));
    assert!(matches!(stiff, Err(DensityError::Integrate(_) | DensityError::Parameter(_))), "{stiff:?}");
    // A range that the motion leaves: x'' = 1 - 0.1 v.
    let driven = from_fn(1, |_, _, v, a| a[0] = 1.0 - 0.1 * v[0]).unwrap();
    assert!(matches!(method.stationary(&driven), Err(DensityError::Leaves { .. })));
}

#[test]
fn calls_report_and_are_cancelled() {
    let model = oscillator(&[("damping", 0.5), ("linear stiffness", 1.0)]);
    let method = PathIntegration::new(1.0, [-5.0, 5.0], [-5.0, 5.0]).unwrap().panels(2);
    let few = method.clone().budget(Budget::new().steps(10)).stationary(&model);
    assert!(matches!(few, Err(DensityError::Exhausted { exhausted: Exhausted::Steps { limit: 10 } })));
    let (flag, calls) = (Arc::new(AtomicBool::new(false)), AtomicUsize::new(0));
    let report = |repetitions: usize, change: f64| {
        assert!(repetitions > 0 && change >= 0.0);
        calls.fetch_add(1, Ordering::Relaxed);
        flag.store(true, Ordering::Relaxed);
    };
    let cancelled =
        method.repetition_callback(report).budget(Budget::new().cancel(flag.clone())).stationary(&model);
    assert!(matches!(cancelled, Err(DensityError::Exhausted { exhausted: Exhausted::Cancelled })));
    assert_eq!(calls.load(Ordering::Relaxed), 1);
}
