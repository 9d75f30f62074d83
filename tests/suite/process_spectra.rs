//! Spectra of random processes estimated from their paths, and the limit of held noise.

use crate::api::*;
use crate::common::bands::{mean_square_quantile, normal_quantile};
use crate::common::family::oscillator;
use rand_distr::StandardNormal;
use std::f64::consts::TAU;

/// The exact mean of the density that `Welch` estimates from segments of n samples with a Hann window, for samples i
/// and j of a segment with the covariance c(i, j). It contains what aliasing and the window do.
fn expected(n: usize, spacing: f64, c: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let w = Window::Hann.coefficients(n).unwrap();
    let lagged = |k: usize| (0..n - k).map(|i| w[i] * w[i + k] * c(i, i + k)).sum::<f64>();
    let lagged: Vec<f64> = (0..n).map(lagged).collect();
    let square: f64 = w.iter().map(|w| w * w).sum();
    let cosines: Vec<f64> = (0..n).map(|k| (TAU * k as f64 / n as f64).cos()).collect();
    let line = |line: usize| {
        let sum: f64 = (1..n).map(|k| 2.0 * lagged[k] * cosines[k * line % n]).sum();
        let sided = if line == 0 || 2 * line == n { 1.0 } else { 2.0 };
        sided * spacing / square * (lagged[0] + sum)
    };
    (0..=n / 2).map(line).collect()
}

/// All lines lie inside a band that holds for all of them together with a probability of 99 %: an average over
/// independent segments is χ² distributed about its mean, with two degrees of freedom for each segment, one at both
/// ends.
fn inside_bands(name: &str, density: &Density, expected: &[f64]) {
    let lines = expected.len();
    let one = 0.005 / lines as f64;
    for (k, (seen, expected)) in density.values().iter().zip(expected).enumerate() {
        let degrees = density.segments() as f64 * if k == 0 || k == lines - 1 { 1.0 } else { 2.0 };
        let [low, high] = [one, 1.0 - one].map(|p| mean_square_quantile(p, degrees));
        let ratio = seen / expected;
        assert!(low < ratio && ratio < high, "{name}, line {k}: {ratio} outside {low} .. {high}");
    }
}

const SEGMENT: usize = 256;
const SEGMENTS: usize = 400;

/// The density of a path sampled at the distance `spacing`, by segments that are some correlation times apart.
fn estimate(process: &dyn Process, spacing: f64, apart: f64) -> Density {
    let path = process.path(0);
    let segment = |s: usize| {
        let start = (s as f64) * (SEGMENT as f64 * spacing + apart);
        (0..SEGMENT).map(move |i| start + i as f64 * spacing)
    };
    let samples: Vec<f64> = (0..SEGMENTS).flat_map(segment).map(|t| path.at(t, Side::After)).collect();
    Welch::new(SEGMENT).overlap(0.0).density(&samples, spacing).unwrap()
}

#[test]
fn gaussian_processes_sampled_at_nodes() {
    let processes: [(&str, Box<dyn Process>, f64, usize); 4] = [
        ("Ornstein-Uhlenbeck", Box::new(OrnsteinUhlenbeck::new(2.0, 1.0, 0.0625).unwrap()), 0.0625, 10),
        ("filtered, resonant", Box::new(FilteredNoise::new(3.0, 2.0, 0.1, 0.25).unwrap()), 0.5, 10),
        ("filtered, overdamped", Box::new(FilteredNoise::new(3.0, 1.0, 2.0, 0.125).unwrap()), 0.25, 10),
        ("jittered order", Box::new(JitteredOrder::new(2.0, 2.0, 0.1, 0.5).unwrap()), 0.5, 30),
    ];
    for (name, process, spacing, line) in processes {
        let density = estimate(&*process, spacing, 64.0);
        let variance = process.variance().unwrap();
        let exact = expected(SEGMENT, spacing, |i, j| {
            variance * process.correlation((j - i) as f64 * spacing).unwrap()
        });
        inside_bands(name, &density, &exact);
        // Far below the frequency of the samples the density itself is that of the process.
        let ratio = exact[line] / process.density(density.frequencies()[line]).unwrap();
        assert!((ratio - 1.0).abs() < 0.03, "{name}: {ratio}");
    }
}

/// Straight lines between nodes: the covariances of the path are those of the nodes, weighted.
#[test]
fn lines_between_nodes() {
    let (h, sigma) = (0.5, 2.0);
    let process = OrnsteinUhlenbeck::new(sigma, 1.0, h).unwrap();
    let nodes = |apart: usize| sigma * sigma * process.correlation(apart as f64 * h).unwrap();
    let nodes: Vec<f64> = (0..=SEGMENT).map(nodes).collect();
    // With this number of samples in a cell.
    let covariance = |parts: usize, i: usize, j: usize| -> f64 {
        let weights = |i: usize| {
            let share = (i % parts) as f64 / parts as f64;
            [(i / parts, 1.0 - share), (i / parts + 1, share)]
        };
        weights(i).iter().flat_map(|&(a, wa)| weights(j).map(|(b, wb)| wa * wb * nodes[a.abs_diff(b)])).sum()
    };
    let exact = expected(SEGMENT, 0.25 * h, |i, j| covariance(4, i, j));
    inside_bands("lines", &estimate(&process, 0.25 * h, 16.0), &exact);
    // The page: the density of the nodes times (sin(π f h)/(π f h))⁴. Samples that are locked to the grid approach
    // it as they become dense.
    let (a, n, parts) = (libm::exp(-h), 1024, 16);
    let dense = expected(n, h / parts as f64, |i, j| covariance(parts, i, j));
    for k in [4, 12, 20, 40, 50] {
        let f = k as f64 * parts as f64 / (n as f64 * h);
        let nodes = 2.0 * sigma * sigma * h * (1.0 - a * a) / (1.0 - 2.0 * a * (TAU * f * h).cos() + a * a);
        let x = 0.5 * TAU * f * h;
        let ratio = dense[k] / (nodes * (x.sin() / x).powi(4));
        assert!((ratio - 1.0).abs() < 0.03, "line {k}: {ratio}");
    }
    // As a mean over time (2 + e^(-h/τ))/3 of the variance is left.
    let left = (0..4000).map(|k| (f64::from(k) + 0.5) / 4000.0);
    let left = left.map(|s| s * s + (1.0 - s) * (1.0 - s) + 2.0 * a * s * (1.0 - s)).sum::<f64>() / 4000.0;
    assert!((left - (2.0 + a) / 3.0).abs() < 1e-7);
}

/// A peak and a floor. Each segment is a stream of its own and shorter than the recurrence time.
#[test]
fn prescribed_density() {
    let shape = |f: f64| 0.2 + 3.0 / (1.0 + ((f - 0.4) / 0.05).powi(2));
    let process = SpectralProcess::new(shape, [0.0, 1.0], 500).unwrap();
    let spacing = 0.4;
    assert!(process.recurrence_time() > 4.0 * SEGMENT as f64 * spacing);
    let segment = |stream: usize| {
        let path = process.path(stream as u64);
        (0..SEGMENT).map(move |i| path.at(i as f64 * spacing, Side::After))
    };
    let samples: Vec<f64> = (0..SEGMENTS).flat_map(segment).collect();
    let density = Welch::new(SEGMENT).overlap(0.0).density(&samples, spacing).unwrap();
    let variance = process.variance().unwrap();
    let correlations: Vec<f64> =
        (0..SEGMENT).map(|k| process.correlation(k as f64 * spacing).unwrap()).collect();
    let exact = expected(SEGMENT, spacing, |i, j| variance * correlations[j - i]);
    // Beyond the band only what leaks through the window is left: sums of few lines, no χ² distribution.
    let inner = density.frequencies().iter().filter(|f| **f < 0.97).count();
    let band: Vec<f64> = exact[..inner].to_vec();
    let one = 0.005 / inner as f64;
    for (k, (seen, exact)) in density.values().iter().zip(&band).enumerate() {
        let degrees = SEGMENTS as f64 * if k == 0 { 1.0 } else { 2.0 };
        let [low, high] = [one, 1.0 - one].map(|p| mean_square_quantile(p, degrees));
        assert!((low..high).contains(&(seen / exact)), "line {k}: {} outside {low} .. {high}", seen / exact);
        let f = density.frequencies()[k];
        // The peak is 2.5 lines wide at half its height: the Hann window flattens it.
        assert!((f - 0.4).abs() < 0.1 || k < 3 || (exact / shape(f) - 1.0).abs() < 0.05, "line {k}");
    }
    assert!(density.values()[inner + 6..].iter().all(|s| *s < 0.01 * 0.2));
}

/// x'' + 2 ζ x' + x = held noise of variance D/h: the variance of x is that under white noise, D/(4ζ), less a relative
/// (ω h)²/12 as a mean over the positions of the grid. It is the sum of the squares of the responses to the held
/// values, all of which are shifts of the response to one value: no sampling.
#[test]
fn held_noise_tends_to_white_noise() {
    let zeta = 0.1;
    let bare = oscillator(&[("damping", 2.0 * zeta), ("linear stiffness", 1.0)]);
    let slot = bare.slot("mean force").unwrap();
    let solver = Dop853::new().rtol(1e-11).atol(1e-14);
    let white = 1.0 / (4.0 * zeta);
    let parts = 8u32; // positions within a hold time
    let mut errors = Vec::new();
    for h in [0.8, 0.4, 0.2] {
        let pulse = HeldProcess::of_values(h, &[1.0, 0.0]).unwrap();
        let noisy = Noisy::new(bare.clone()).add(&[(slot, 1.0)], &pulse).unwrap();
        let (mut state, mut squares, mut k) = (State::at_rest(1), 0.0, 0u32);
        while f64::from(k) * h < 20.0 / zeta {
            for part in 1..=parts {
                let t = (f64::from(k) + f64::from(part) / f64::from(parts)) * h;
                state = solver.end(&noisy, &state, t).unwrap();
                squares += state.q[0] * state.q[0];
            }
            k += 1;
        }
        errors.push(1.0 - squares / (f64::from(parts) * h) / white);
    }
    println!("{errors:?}");
    for (h, error) in [0.8, 0.4, 0.2].into_iter().zip(&errors) {
        assert!((error / (h * h / 12.0) - 1.0).abs() < 0.1 * h, "h = {h}: {error}");
    }
    let orders = [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2);
    assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.1), "{orders:?}");
}

/// The same with random values: 1000 members, the interval of 99 %.
#[test]
fn members_under_held_noise() {
    let (zeta, h, end) = (0.25, 0.25, 30.0);
    let bare = oscillator(&[("damping", 2.0 * zeta), ("linear stiffness", 1.0)]);
    let slot = bare.slot("mean force").unwrap();
    let normal = HeldProcess::new(h, StandardNormal).unwrap().moments(0.0, 1.0).unwrap();
    // The variance of a value is 1/h, the intensity 1.
    let end_of = |member: u64| {
        let noisy =
            Noisy::new(bare.clone()).add(&[(slot, h.powf(-0.5))], &normal.clone().member(member)).unwrap();
        Dop853::new().rtol(1e-6).atol(1e-8).end(&noisy, &State::at_rest(1), end).unwrap().q[0]
    };
    let squares: Vec<f64> = (0..1000).map(|member| end_of(member).powi(2)).collect();
    let seen = Summary::of_samples(&squares).unwrap();
    let error = seen.deviation / (squares.len() as f64).sqrt();
    let exact = (1.0 - h * h / 12.0) / (4.0 * zeta);
    println!("{} ± {error} against {exact}", seen.mean);
    assert!((seen.mean - exact).abs() < normal_quantile(0.995) * error);
}
