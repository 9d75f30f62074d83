//! Derivatives of orbits, figures and located points with respect to constants, against differences.

use crate::common::family::{Oscillator, oscillator};
use gear_dynamics::branches::{BranchPoint, ByConstant, Continuation, Sensitivity};
use gear_dynamics::model::{Machine, Periodic, State};
use gear_dynamics::periodic::ShootingOrbit;
use gear_dynamics::{NfgPair, NfgParams, Shooting, Statistics};

/// Central difference of fourth order.
fn difference(f: &dyn Fn(f64) -> f64, at: f64, h: f64) -> f64 {
    (8.0 * (f(at + h) - f(at - h)) - (f(at + 2.0 * h) - f(at - 2.0 * h))) / (12.0 * h)
}

fn figures<M: Periodic>(model: &M, orbit: &ShootingOrbit, channel: &str) -> [f64; 4] {
    let mut statistics = Statistics::new(model, &[channel]).unwrap();
    orbit.observe(model, &mut statistics).unwrap();
    let s = statistics.summary(channel).unwrap();
    [s.mean, s.rms, s.peak_to_peak(), orbit.multipliers().largest()]
}

/// All derivatives of one orbit against differences, in units of figure over constant.
fn check(model: &Machine<Oscillator>, start: &State, channel: &str, worst: f64) {
    let orbit = Shooting::new().run(model, std::slice::from_ref(start)).unwrap();
    let slopes = Sensitivity::of(model, &orbit, &[channel]).unwrap();
    let multiplier = Sensitivity::of_largest_multiplier(model, &orbit).unwrap();
    let reference = figures(model, &orbit, channel);
    for (k, constant) in model.names().iter().enumerate() {
        let value = model.constant(&constant.name).unwrap();
        if value == 0.0 {
            continue;
        }
        let figure = |which: usize| {
            move |c: f64| {
                let moved = model.with(&constant.name, c).unwrap();
                let orbit = Shooting::new().run(&moved, std::slice::from_ref(start)).unwrap();
                figures(&moved, &orbit, channel)[which]
            }
        };
        let ours = [
            slopes.mean(channel).unwrap()[k],
            slopes.rms(channel).unwrap()[k],
            slopes.peak_to_peak(channel).unwrap()[k],
            multiplier[k],
        ];
        for (which, ours) in ours.into_iter().enumerate() {
            let theirs = difference(&figure(which), value, 2e-4 * value.abs());
            // The mean of a symmetric orbit is 0: errors are shares of the peak-to-peak value.
            let size = if which == 3 { 1.0 } else { reference[2] };
            let off = (ours - theirs).abs() * value.abs() / size;
            println!("{:>15} {which} {ours:>14.8} {theirs:>14.8} {off:.1e}", constant.name);
            assert!(off < worst, "{} {which}: {ours} {theirs}", constant.name);
        }
    }
}

fn pair() -> Machine<Oscillator> {
    oscillator(&[
        ("speed", 0.8),
        ("gap stiffness", 1.0),
        ("depth", 0.1),
        ("mean force", 0.1),
        ("inertia force", 0.05),
        ("damping", 0.1),
    ])
}

#[test]
fn figures_of_a_pair_that_loses_contact() {
    let start = State::new(0.0, &[1.0], &[0.25]);
    let orbit = Shooting::new().run(&pair(), std::slice::from_ref(&start)).unwrap();
    assert!(orbit.crossings() > 0);
    check(&pair(), &start, "deflection", 1e-7);
    check(&pair(), &start, "mesh force", 1e-7);
}

#[test]
fn figures_of_a_duffing_oscillator() {
    let given = [("speed", 1.2), ("cubic", 0.1), ("linear", 1.0), ("force", 0.18), ("damping", 0.05)];
    let model = oscillator(&[&given[..], &[("half backlash", 9.0)]].concat());
    check(&model, &State::at_rest(1), "q1", 1e-7);
}

/// Every kind of located point, moved by a small change of each constant.
#[test]
fn located_points_of_a_pair() {
    let model =
        oscillator(&[("gap stiffness", 1.0), ("mean force", 0.25), ("force", 0.25), ("damping", 0.1)]);
    let family = ByConstant::new(&model, "speed").unwrap();
    let range = Continuation::new(2.5, 0.4).bounds(0.35, 2.6);
    let branch = range.run(&family, &[State::new(0.0, &[1.0], &[0.0])]).unwrap();
    for (kind, point) in branch.located() {
        let slopes = Sensitivity::of_point(&model, "speed", point).unwrap();
        for name in ["damping", "mean force", "force", "gap stiffness"] {
            let value = model.constant(name).unwrap();
            let place = model.names().iter().position(|channel| channel.name == name).unwrap();
            let at = |c: f64| moved_point(&model.with(name, c).unwrap(), point);
            let theirs = difference(&at, value, 2e-5 * value);
            let off = (slopes[place] - theirs).abs() * value / point.parameter;
            println!(
                "{kind:>16} {:.6} {name:>14} {:>13.8} {theirs:>13.8} {off:.1e}",
                point.parameter, slopes[place]
            );
            assert!(off < 1e-7, "{kind} {name}: {} {theirs}", slopes[place]);
        }
    }
}

/// The parameter of the point of the same kind on the branch of a neighbouring model.
fn moved_point(model: &Machine<Oscillator>, point: &BranchPoint) -> f64 {
    let family = ByConstant::new(model, "speed").unwrap();
    let kind = point.kind.as_ref().unwrap();
    let at = model.with("speed", point.parameter).unwrap();
    let found = [0.02, -0.02, 0.03, -0.03].into_iter().find_map(|shift| {
        let start = model.with("speed", point.parameter + shift).unwrap();
        let _ = &at;
        let orbit = Shooting::new().again(&start, &point.orbit).ok()?;
        let from = point.parameter + shift;
        let range = Continuation::new(from, point.parameter - shift).bounds(from - 0.2, from + 0.2);
        let branch = range.max_points(60).both_ways().run(&family, orbit.states()).ok()?;
        let of_kind = branch.located().filter(|(other, _)| other.name() == kind.name());
        let near = |p: &BranchPoint| (p.parameter - point.parameter).abs();
        let nearest = of_kind.map(|(_, p)| p).min_by(|a, b| near(a).total_cmp(&near(b)))?;
        (near(nearest) < 2e-3).then_some(nearest.parameter)
    });
    found.unwrap_or_else(|| panic!("no {kind} near {}", point.parameter))
}

#[test]
fn the_face_gear_pair() {
    let pair = NfgPair::new(&NfgParams { speed: 110.0, ..NfgParams::table1() }).unwrap();
    let orbit = Shooting::new().run(&pair, &[pair.static_start().unwrap()]).unwrap();
    let slopes = Sensitivity::of(&pair, &orbit, &["deflection"]).unwrap();
    let ours = slopes.peak_to_peak("deflection").unwrap();
    for (k, constant) in pair.names().iter().enumerate() {
        let value = pair.constant(&constant.name).unwrap();
        let unit = if value == 0.0 { continue } else { value.abs() };
        let figure = |c: f64| {
            let moved = pair.with(&constant.name, c).unwrap();
            figures(&moved, &Shooting::new().again(&moved, &orbit).unwrap(), "deflection")[2]
        };
        let theirs = difference(&figure, value, 1e-5 * unit);
        let off = (ours[k] - theirs).abs() * unit / figures(&pair, &orbit, "deflection")[2];
        println!("{:>20} {:>14.6e} {theirs:>14.6e} {off:.1e}", constant.name, ours[k]);
        assert!(off < 1e-7);
    }
}
