//! Random processes: moments over many paths, statistics that agree with one another, the same bits in any order and
//! on finer grids, solvers under each of them, refused input.

use crate::api::*;
use crate::common::bands::normal_quantile;
use crate::common::family::oscillator;
use rand_distr::{Exp, StandardNormal};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

const NAMES: [&str; 8] = [
    "held",
    "Ornstein-Uhlenbeck",
    "filtered, resonant",
    "filtered, critical",
    "filtered, overdamped",
    "prescribed density",
    "shot noise",
    "jittered order",
];

/// The process with this name, of a member; times of order 1.
fn process(name: &str, member: u64) -> Box<dyn Process> {
    let sizes = Exp::new(0.5).unwrap();
    let filtered = |zeta| FilteredNoise::new(3.0, 2.0, zeta, 0.0625).unwrap().member(member);
    let density = |f: f64| 4.0 / (1.0 + (9.0 * f).powi(2));
    match name {
        "held" => Box::new(HeldProcess::new(0.8, sizes).unwrap().moments(2.0, 2.0).unwrap().member(member)),
        "Ornstein-Uhlenbeck" => Box::new(OrnsteinUhlenbeck::new(2.0, 1.0, 0.0625).unwrap().member(member)),
        "filtered, resonant" => Box::new(filtered(0.1)),
        "filtered, critical" => Box::new(filtered(1.0)),
        "filtered, overdamped" => Box::new(filtered(3.0)),
        "prescribed density" => {
            Box::new(SpectralProcess::new(density, [0.0, 1.0], 60).unwrap().member(member))
        }
        "shot noise" => {
            Box::new(ShotNoise::new(2.0, 1.0, sizes).unwrap().moments(2.0, 2.0).unwrap().member(member))
        }
        _ => Box::new(JitteredOrder::new(2.0, 5.0, 0.5, 0.0625).unwrap().member(member)),
    }
}

/// Mean, variance and correlations over 4000 members inside intervals that hold together with a probability of 99 %.
/// The instants lie on the grids, on both sides of an end of a block (t = 64 of the Ornstein-Uhlenbeck process), and
/// before 0. Standard errors are those of the samples.
#[test]
fn moments_over_members() {
    let lags = [0.0625, 0.5, 1.5, 3.0];
    let starts = [63.5, 5.25, -7.0];
    let members = 4000;
    let quantities = starts.len() * (2 + lags.len());
    for name in NAMES {
        let exact_of = process(name, 0);
        let z = normal_quantile(1.0 - 0.005 / quantities as f64);
        let [mean, variance] = [exact_of.mean(), exact_of.variance()].map(Option::unwrap);
        for start in starts.into_iter().filter(|start| name != "held" || *start > 0.0) {
            let mut samples = vec![Vec::new(); 2 + lags.len()];
            for member in 0..members {
                let path = process(name, member).path(1);
                // Statistics of a held process are means over the positions of its grid.
                let start = if name == "held" { start + (0.618 * member as f64) % 1.0 * 0.8 } else { start };
                let x = path.at(start, Side::After) - mean;
                samples[0].push(x + mean);
                samples[1].push(x * x);
                for (lag, samples) in lags.iter().zip(&mut samples[2..]) {
                    samples.push(x * (path.at(start + lag, Side::After) - mean));
                }
            }
            let exact = lags.iter().map(|lag| variance * exact_of.correlation(*lag).unwrap());
            let exact = [mean, variance].into_iter().chain(exact);
            for (k, (samples, exact)) in samples.iter().zip(exact).enumerate() {
                let seen = Summary::of_samples(samples).unwrap();
                let error = seen.deviation / (members as f64).sqrt();
                println!("{name}, {start}, {k}: {} ± {error:.1e} against {exact}", seen.mean);
                assert!((seen.mean - exact).abs() < z * error, "{name}, quantity {k} at {start}");
            }
        }
    }
}

/// S(f) = 4 σ² ∫ ρ(s) cos(2πfs) ds from 0 to infinity (Wiener and Khinchin), by Simpson's rule; ∫ S df = σ² for the
/// density by lines.
#[test]
fn densities_are_transforms_of_correlations() {
    for (name, process) in NAMES.map(|name| (name, process(name, 0))) {
        let variance = process.variance().unwrap();
        if name == "prescribed density" {
            let lines = (0..60).map(|j| process.density((f64::from(j) + 0.5) / 60.0).unwrap() / 60.0);
            assert!((lines.sum::<f64>() / variance - 1.0).abs() < 1e-13);
            assert_eq!([process.density(1.01), process.density(-0.01)], [Some(0.0); 2]);
            continue;
        }
        let (end, n) = (if name == "held" { 0.8 } else { 240.0 }, 48_000);
        let step = end / f64::from(n);
        for f in [0.0, 0.05, 0.3, 0.8, 1.7] {
            let sum: f64 = (0..=n)
                .map(|k| {
                    let s = f64::from(k) * step;
                    let weight = if k == 0 || k == n { 1.0 } else { 2.0 + 2.0 * f64::from(k % 2) };
                    weight * process.correlation(s).unwrap() * (TAU * f * s).cos()
                })
                .sum();
            let expected = 4.0 * variance * sum * step / 3.0;
            let density = process.density(f).unwrap();
            // Simpson's rule: the rest is of order step⁴ times the fourth derivative.
            assert!(
                (density - expected).abs() < 1e-7 * process.density(0.0).unwrap().max(density),
                "{name}, {f}"
            );
        }
    }
}

/// A value is a function of process, stream and time alone, although a path keeps what it drew last.
#[test]
fn any_order_of_calls_gives_the_same_bits() {
    // Many instants of a cell, in many cells.
    let times: Vec<f64> = (0..600).map(|k| -20.0 + 0.07 * f64::from(k)).collect();
    for name in NAMES {
        let one = process(name, 3);
        let path = one.path(7);
        let bits = |path: &dyn Path, t: f64| path.at(t, Side::After).to_bits();
        let fresh: Vec<u64> = times.iter().map(|t| bits(&*one.path(7), *t)).collect();
        let forward: Vec<u64> = times.iter().map(|t| bits(&*path, *t)).collect();
        assert_eq!(fresh, forward, "{name}");
        let far_and_near = (0..times.len()).map(|k| (7 * k) % times.len());
        far_and_near.for_each(|k| assert_eq!(bits(&*path, times[k]), fresh[k], "{name}"));
        // Threads that read one path at different instants.
        std::thread::scope(|scope| {
            for thread in 0..4 {
                let (path, times, fresh) = (&path, &times, &fresh);
                scope.spawn(move || {
                    for k in (0..times.len()).map(|k| (k + 150 * thread) % times.len()) {
                        assert_eq!(bits(&**path, times[k]), fresh[k], "{name}");
                    }
                });
            }
        });
        let other = one.path(8);
        assert!(times.iter().any(|t| other.at(*t, Side::After) != path.at(*t, Side::After)), "{name}");
        let neighbour = process(name, 4).path(7);
        assert!(times.iter().any(|t| neighbour.at(*t, Side::After) != path.at(*t, Side::After)), "{name}");
    }
}

/// Values at the nodes of a grid remain when the spacing is divided by 2, 4, 8: bit for bit.
#[test]
fn finer_grids_keep_the_values_at_nodes() {
    for part in [2.0, 4.0, 8.0] {
        let h = 0.1;
        let grids: [(Box<dyn Process>, Box<dyn Process>); 3] = [
            (
                Box::new(OrnsteinUhlenbeck::new(2.0, 1.0, h).unwrap()),
                Box::new(OrnsteinUhlenbeck::new(2.0, 1.0, h / part).unwrap()),
            ),
            (
                Box::new(FilteredNoise::new(3.0, 2.0, 0.1, h).unwrap()),
                Box::new(FilteredNoise::new(3.0, 2.0, 0.1, h / part).unwrap()),
            ),
            (
                Box::new(JitteredOrder::new(2.0, 5.0, 0.5, h).unwrap()),
                Box::new(JitteredOrder::new(2.0, 5.0, 0.5, h / part).unwrap()),
            ),
        ];
        for (coarse, fine) in grids.map(|(coarse, fine)| (coarse.path(2), fine.path(2))) {
            for k in -700..1500 {
                let t = f64::from(k) * h;
                assert_eq!(coarse.at(t, Side::After), fine.at(t, Side::After), "1/{part}, node {k}");
            }
            let between: f64 = (0..100)
                .map(|k| 0.05 + 0.1 * f64::from(k))
                .map(|t| (coarse.at(t, Side::After) - fine.at(t, Side::After)).abs())
                .sum();
            assert!(between > 1e-3);
        }
    }
}

/// Two solvers, one by series of the paths, agree under each process; the dead zone is crossed.
#[test]
fn taylor_and_dop853_agree() {
    let bare =
        oscillator(&[("damping", 0.1), ("mesh stiffness", 4.0), ("mean force", 0.5), ("half backlash", 0.2)]);
    let slot = bare.slot("mean force").unwrap();
    let start = State::new(0.0, &[0.3], &[0.0]);
    let mut go_on = |_: &mut Step<'_>| ControlFlow::Continue(());
    for name in NAMES {
        let noisy = Noisy::new(bare.clone()).add(&[(slot, 0.3)], &*process(name, 1)).unwrap();
        let dop853 = Dop853::new().rtol(1e-12).atol(1e-14).run(&noisy, &start, 12.0, &mut go_on).unwrap();
        let taylor = Taylor::new().rtol(1e-13).atol(1e-15).run(&noisy, &start, 12.0, &mut go_on).unwrap();
        println!("{name}: {} crossings, {:e}", taylor.stats.crossings, dop853.state.q[0] - taylor.state.q[0]);
        assert!(taylor.stats.crossings > 2 && dop853.stats.crossings == taylor.stats.crossings, "{name}");
        assert!((dop853.state.q[0] - taylor.state.q[0]).abs() < 1e-9, "{name}");
        assert!((dop853.state.v[0] - taylor.state.v[0]).abs() < 1e-9, "{name}");
    }
}

/// Each refusal says which value, what it was and what is allowed.
#[test]
fn refused_processes() {
    let text = |error: ParameterError| error.to_string();
    let coarse = text(OrnsteinUhlenbeck::new(1.0, 0.1, 0.2).unwrap_err());
    assert!(
        coarse.starts_with("spacing of the grid has the bounds 1e-13 .. 0.1 and the value 0.2"),
        "{coarse}"
    );
    for spacing in [0.0, -1.0, 1e-20, f64::NAN, f64::INFINITY] {
        assert!(OrnsteinUhlenbeck::new(1.0, 0.1, spacing).is_err(), "{spacing}");
        assert!(FilteredNoise::new(1.0, 1.0, 0.1, spacing).is_err(), "{spacing}");
        assert!(JitteredOrder::new(1.0, 1.0, 0.1, spacing).is_err(), "{spacing}");
    }
    for wrong in [-1.0, f64::NAN, 1e60] {
        assert!(
            OrnsteinUhlenbeck::new(wrong, 1.0, 0.1).is_err()
                && OrnsteinUhlenbeck::new(1.0, wrong, 0.1).is_err()
        );
        assert!(
            FilteredNoise::new(wrong, 1.0, 0.1, 0.1).is_err()
                && FilteredNoise::new(1.0, wrong, 0.1, 0.1).is_err()
        );
        assert!(
            FilteredNoise::new(1.0, 1.0, wrong, 0.1).is_err()
                && JitteredOrder::new(1.0, 1.0, wrong, 0.1).is_err()
        );
        assert!(
            ShotNoise::new(wrong, 1.0, StandardNormal).is_err()
                && ShotNoise::new(1.0, wrong, StandardNormal).is_err()
        );
        assert!(SpectralProcess::new(|_| wrong, [0.0, 1.0], 4).is_err());
    }
    // The grid has to resolve the faster of the two times of an overdamped filter.
    assert!(
        FilteredNoise::new(1.0, 1.0, 5.0, 0.2).is_err() && FilteredNoise::new(1.0, 1.0, 5.0, 0.1).is_ok()
    );
    let negative = text(SpectralProcess::new(|f| 0.5 - f, [0.0, 1.0], 4).unwrap_err());
    assert!(
        negative.starts_with("density at 0.5") && negative.ends_with("it must not be negative"),
        "{negative}"
    );
    assert!(
        SpectralProcess::new(|_| 1.0, [1.0, 1.0], 4).is_err()
            && SpectralProcess::new(|_| 1.0, [-1.0, 1.0], 4).is_err()
    );
    assert!(SpectralProcess::new(|_| 1.0, [0.0, 1.0], 0).is_err());
    assert!(SpectralProcess::of_table(&[[0.0, 1.0], [0.0, 2.0]], 4).is_err());
    assert!(SpectralProcess::of_table(&[[0.0, 1.0]], 4).is_err());
    assert!(SpectralProcess::of_table(&[[0.0, 1.0], [1.0, -2.0]], 4).is_err());
    let table = SpectralProcess::of_table(&[[0.0, 0.0], [1.0, 2.0], [2.0, 0.0]], 10).unwrap();
    assert!((table.variance().unwrap() - 2.0).abs() < 1e-14);
    let often = text(ShotNoise::new(1e6, 1.0, StandardNormal).unwrap_err());
    assert_eq!(often, "pulses in a decay time is 1000000.0: it must lie in [0, 1e4]");
    // What is not known is not invented.
    let held = HeldProcess::new(1.0, StandardNormal).unwrap();
    assert_eq!([held.mean(), held.variance(), held.correlation(0.0), held.density(0.0)], [None; 4]);
    assert!(held.moments(0.0, -1.0).is_err());
}

/// The fastest paths that are allowed have finite series of every order, and faster ones are refused: the
/// series of a sine of 1e50 rad/s overflows, although its values are finite.
#[test]
fn paths_too_fast_for_series_are_refused() {
    let jittered = |fast: f64, spacing: f64| JitteredOrder::new(1e50, fast, 1.0, spacing);
    let spectral = |end: f64| SpectralProcess::new(|_| 1e50, [0.0, end], 3);
    let shots = |decay: f64| ShotNoise::new(9.9e8, decay, Exp::new(1e-50).unwrap());
    let paths = [
        jittered(9.9e8, 1e-4).unwrap().path(0),
        spectral(1.5e8).unwrap().path(0),
        shots(1.01e-9).unwrap().path(0),
    ];
    for path in paths {
        for t in [0.0, 0.3, -1e9, 1e20] {
            let series = path.series(t, 32);
            assert!(series.coefficients().iter().all(|c| c.is_finite()), "{t}");
            assert!((series.at(0.0) - path.at(t, Side::After)).abs() <= 1e-9 * 1e50);
        }
    }
    assert_eq!(
        shots(9e-10).unwrap_err().to_string(),
        "1/decay time is 1111111111.1111112: it must lie in [-1e9, 1e9]"
    );
    let fast = ShotNoise::new(1.0, 1e-50, Exp::new(1.0).unwrap()).err();
    assert!(fast.unwrap().to_string().contains("1/decay time is 1e50"));
    let text = |error: Option<ParameterError>| error.unwrap().to_string();
    assert_eq!(text(jittered(1e50, 0.1).err()), "angular frequency is 1e50: it must lie in [-1e9, 1e9]");
    let walk = JitteredOrder::new(1.0, 1.0, 1e20, 1e-20).err();
    assert!(text(walk).contains("of the walk over a spacing"));
    assert!(text(spectral(1e50).err()).contains("end of the band"));
}
