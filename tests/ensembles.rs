//! Ensembles and uncertain parameters against exact values.

use gear_dynamics::*;
use rand_distr::Uniform;

/// x'' + c x' + x = 0, c a drive; its energy is a channel.
struct Oscillator;

impl Model for Oscillator {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = -q[0] - u[0] * v[0];
    }
    fn drive(&self, _: f64, _: Side, u: &mut [f64]) {
        u[0] = 0.0;
    }
    fn channels(&self) -> Vec<Channel> {
        vec![Channel::new("energy", "1")]
    }
    fn observe(&self, _: &[f64], q: &[f64], v: &[f64], _: &[Contact], out: &mut [f64]) {
        out[0] = 0.5 * (q[0] * q[0] + v[0] * v[0]);
    }
}

fn member(hold: f64) -> impl Fn(u64) -> Result<(Held<Oscillator>, State), ParameterError> + Sync {
    let uniform = Uniform::new(0.0, 1.0).unwrap();
    move |member| {
        let process = HeldProcess::new(hold, uniform)?.with_seed(11).with_member(member);
        Ok((Held::new(Oscillator).shared(&[0], 0.2, process)?, State::new(0.0, &[1.0], &[0.0])))
    }
}

/// E[energy](40) of x'' + 0.2 U x' + x = 0, U uniform on (0, 1) and held: the exact values, of the mean damping as h -> 0.
#[test]
fn random_damping_has_its_exact_energies() {
    for (hold, exact) in [(0.5, 0.009_330), (5.0, 0.012_403), (40.0, 0.061_732)] {
        let ensemble = Ensemble::new(100_000, 40.0, 1).unwrap().channels(&["energy"]);
        let bands = ensemble.run(&Rk4::new(0.25), member(hold)).unwrap();
        let energy = bands.at("energy", 1).unwrap();
        println!("{hold}: {} +- {} against {exact}", energy.mean(), energy.standard_error());
        let rounding = 5e-7; // of the exact values
        assert!((energy.mean() - exact).abs() < 3.0 * energy.standard_error() + rounding, "{hold}: {}", energy.mean());
        assert_eq!(energy.count(), 100_000);
    }
}

/// The same members at half the step: the ensemble does not hang on the integration.
#[test]
fn random_damping_does_not_depend_on_the_time_step() {
    let ensemble = Ensemble::new(500, 40.0, 1).unwrap().channels(&["energy"]);
    let mean = |step: f64| ensemble.run(&Rk4::new(step), member(0.5)).unwrap().at("energy", 1).unwrap().mean();
    let (coarse, fine) = (mean(0.25), mean(0.125));
    // RK4 multiplies by e^z (1 - z^5/120 + ..), z = (-c/2 + i) h: the energy is off by 2 t (c h^4/48 - h^5/144) (1 + O(h)), c = 0.1 in the mean.
    let off = |h: f64| 2.0 * 40.0 * (0.1 * h.powi(4) / 48.0 - h.powi(5) / 144.0);
    println!("{} against {}", coarse / fine - 1.0, off(0.25) - off(0.125));
    assert!((coarse / fine - 1.0 - (off(0.25) - off(0.125))).abs() < 0.25 * off(0.25), "{coarse} {fine}");
    let located = ensemble.run(&Dop853::new().rtol(1e-10), member(0.5)).unwrap().at("energy", 1).unwrap().mean();
    println!("{} against {}", fine / located - 1.0, off(0.125));
    assert!((fine / located - 1.0 - off(0.125)).abs() < 0.125 * off(0.125), "{located} {fine}");
}

#[test]
fn ensembles_do_not_depend_on_threads() {
    let run = || Ensemble::new(1000, 5.0, 4).unwrap().channels(&["q1", "energy"]).run(&Rk4::new(0.25), member(0.5)).unwrap();
    let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
    assert_eq!(pool(1).install(run), pool(3).install(run));
}

#[test]
fn members_that_fail_are_counted_and_the_others_stand() {
    let some = |m: u64| if m.is_multiple_of(4) { Err("bad".to_owned()) } else { member(0.5)(m).map_err(|e| e.to_string()) };
    let bands = Ensemble::new(20, 1.0, 1).unwrap().channels(&["q1"]).run(&Rk4::new(0.25), some).unwrap();
    assert_eq!((bands.members(), bands.failed().0), (15, 5));
    assert_eq!(bands.failed().1, Some(&(0, PointError::Model("bad".into()))));
    let none = Ensemble::new(3, 1.0, 1).unwrap().run(&Rk4::new(0.25), |_| Err::<(Oscillator, State), _>("no"));
    assert_eq!(none.unwrap_err(), EnsembleError::AllFailed { members: 3 });
    assert!(Ensemble::new(0, 1.0, 1).is_err() && Ensemble::new(1, f64::NAN, 1).is_err() && Ensemble::new(1, 1.0, 0).is_err());
}

/// Quantiles from bins against sorted values.
#[test]
fn quantiles_are_off_by_a_bin_at_most() {
    let values: Vec<f64> = (0..20_000u64).map(|k| Uncertain::new(3).with("x", rand_distr::StandardNormal).sample(k)[0]).collect();
    let all = Distribution::of(values.iter().copied());
    let mut sorted = values.clone();
    sorted.sort_by(f64::total_cmp);
    for p in [0.001, 0.05, 0.5, 0.95, 0.999] {
        // Between the neighbours of the sorted value, which lie far apart in the tails, to a bin.
        let place = (p * 20_000.0) as usize;
        let (below, above) = (sorted[place - 1] - all.resolution(), sorted[place + 1] + all.resolution());
        let found = all.quantile(p).unwrap();
        assert!((below..=above).contains(&found), "{p}: {found} of {below} .. {above}");
    }
    let mean = values.iter().sum::<f64>() / 20_000.0;
    assert!((all.mean() - mean).abs() < 1e-12);
    assert!((all.variance() - values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 19_999.0).abs() < 1e-10);
    assert_eq!(all.histogram(50).iter().map(|(_, n)| n).sum::<u64>(), 20_000);
    assert!(all.quantile(1.5).is_err() && Distribution::new().quantile(0.5).is_err());
}

/// Ishigami's function: y = sin x1 + 7 sin² x2 + 0.1 x3⁴ sin x1, x uniform on (-π, π).   Source: Saltelli et al. 2010, Table 5.
#[test]
fn sobol_indices_of_ishigami() {
    let pi = std::f64::consts::PI;
    let x = || Uniform::new(-pi, pi).unwrap();
    let design = Uncertain::new(5).with("x1", x()).with("x2", x()).with("x3", x()).sobol(20_000).unwrap();
    let f = |p: Point<'_>| p["x1"].sin() + 7.0 * p["x2"].sin().powi(2) + 0.1 * p["x3"].powi(4) * p["x1"].sin();
    let values: Vec<f64> = (0..design.points().len()).map(|i| f(design.points().point(i))).collect();
    let variance = 49.0 / 8.0 + pi.powi(4) / 50.0 + pi.powi(8) / 1800.0 + 0.5;
    let first = [0.5 * (1.0 + pi.powi(4) / 50.0).powi(2) / variance, 49.0 / 8.0 / variance, 0.0];
    let shared = pi.powi(8) * (1.0 / 18.0 - 1.0 / 50.0) / 100.0 / variance;
    let total = [first[0] + shared, first[1], shared];
    for (i, index) in design.indices(&values).unwrap().iter().enumerate() {
        println!("{index:?} against {} {}", first[i], total[i]);
        assert!((index.first - first[i]).abs() < 3.0 * index.first_error && index.first_error < 0.02);
        assert!((index.total - total[i]).abs() < 3.0 * index.total_error && index.total_error < 0.02);
    }
    assert!(design.indices(&[1.0]).is_err());
    assert!(design.indices(&vec![1.0; values.len()]).is_err());
    assert!(Uncertain::new(1).sobol(100).is_err());
}
