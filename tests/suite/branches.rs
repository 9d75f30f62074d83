//! Branches of periodic orbits: located points against the reference, and against closed forms.

use crate::common::family::{Oscillator, oscillator};
use crate::data::read;
use gear_dynamics::branches::{Branch, BranchEnd, ByConstant, Continuation};
use gear_dynamics::model::{Machine, State};

/// Bifurcations of a case in periodic_orbits.json: kind and parameter.
fn reference(case: &str) -> Vec<(String, f64)> {
    let file = read("periodic_orbits.json");
    let list = file["time_domain"][case]["bifurcations"].as_array().unwrap();
    let kind = |kind: &str| match kind {
        "LP" => "fold",
        "PD" => "period-doubling",
        _ => "neimark-sacker",
    };
    list.iter().map(|b| (kind(b["type"].as_str().unwrap()).into(), b["Omega"].as_f64().unwrap())).collect()
}

/// Every reference point is found once to `accuracy`, and no other of these kinds.
fn compare(branch: &Branch, reference: &[(String, f64)], accuracy: f64) {
    println!("{branch}");
    let mut found: Vec<(String, f64)> = branch
        .located()
        .filter(|(kind, _)| ["fold", "period-doubling", "neimark-sacker"].contains(&kind.name()))
        .map(|(kind, point)| (kind.name().into(), point.parameter))
        .collect();
    for (kind, at) in reference {
        let nearest = (0..found.len())
            .filter(|&i| found[i].0 == *kind)
            .min_by(|&i, &j| (found[i].1 - at).abs().total_cmp(&(found[j].1 - at).abs()));
        let nearest = nearest.unwrap_or_else(|| panic!("no {kind} at {at}"));
        let (_, parameter) = found.swap_remove(nearest);
        println!("{kind:>16} {at:.12} {:.1e}", parameter - at);
        assert!((parameter - at).abs() < accuracy, "{kind} {parameter} {at}");
    }
    assert!(found.is_empty(), "not in the reference: {found:?}");
}

fn follow(model: &Machine<Oscillator>, continuation: &Continuation) -> Branch {
    let family = ByConstant::new(model, "speed").unwrap();
    let start = State::new(0.0, &[model.constant("mean force").unwrap() + 1.0], &[0.0]);
    continuation.run(&family, &[start]).unwrap()
}

#[test]
fn duffing() {
    let model = oscillator(&[("cubic", 0.1), ("linear", 1.0), ("force", 0.18), ("damping", 0.05)]);
    let branch = follow(&model, &Continuation::new(0.5, 1.6));
    compare(&branch, &reference("duffing_nlvib01"), 1e-10);
    assert_eq!(branch.end(), &BranchEnd::Bound);
}

#[test]
fn spur_pair_of_kahraman_and_singh() {
    let model =
        oscillator(&[("gap stiffness", 1.0), ("mean force", 0.1), ("inertia force", 0.05), ("damping", 0.1)]);
    let branch = follow(&model, &Continuation::new(0.5, 1.1).bounds(0.2, 1.2));
    compare(&branch, &reference("deadzone_KS90"), 1e-10);
}

#[test]
fn dead_zone_under_a_strong_force() {
    let model =
        oscillator(&[("gap stiffness", 1.0), ("mean force", 0.25), ("force", 0.25), ("damping", 0.1)]);
    let branch = follow(&model, &Continuation::new(2.5, 0.4).bounds(0.35, 2.6));
    compare(&branch, &reference("deadzone_Fm25_Fp25"), 1e-10);
}
