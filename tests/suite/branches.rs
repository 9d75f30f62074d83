//! Branches of periodic orbits: located points against the reference, and against closed forms.

use crate::common::family::{Oscillator, oscillator};
use crate::common::oscillators::CubicChain;
use crate::data::read;
use gear_dynamics::Shooting;
use gear_dynamics::branches::{Branch, BranchEnd, BranchPoint, ByConstant, ByFunction, Continuation};
use gear_dynamics::model::{Machine, State};
use gear_dynamics::periodic::Stability;

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

/// A model without named constants: the derivative with respect to the parameter is computed by differences.
#[test]
fn chain_with_cubic_springs() {
    let family = ByFunction::new("speed", "1", |omega| Ok(CubicChain { omega }));
    let branch = Continuation::new(0.9, 1.4).bounds(0.6, 1.5).run(&family, &[State::at_rest(2)]).unwrap();
    compare(&branch, &reference("nlvib02_2dof_cubic"), 1e-10);
}

/// Folds and period doublings of the classics, and the grazings in closed form.
#[test]
fn spur_pairs_of_the_classics() {
    let file = read("classic_orbits.json");
    for (name, case) in file["sdof_spur_pair"].as_object().unwrap() {
        let number = |key: &str| case["equation"][key].as_f64().unwrap();
        let depth = case["equation"]["a"][0].as_f64().unwrap_or(0.0);
        let model = oscillator(&[
            ("gap stiffness", 1.0),
            ("depth", depth),
            ("mean force", number("Fm")),
            ("inertia force", number("Fah")),
            ("damping", 2.0 * number("zeta")),
        ]);
        let branch = follow(&model, &Continuation::new(0.5, 2.2));
        let of = |key: &str, kind: &str| -> Vec<(String, f64)> {
            let mut list: Vec<f64> =
                case[key].as_array().unwrap().iter().map(|point| point["W"].as_f64().unwrap()).collect();
            list.sort_by(f64::total_cmp);
            list.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
            list.into_iter().map(|w| (kind.to_owned(), w)).collect()
        };
        println!("{name}");
        let mut all = [of("folds", "fold"), of("period_doublings", "period-doubling")].concat();
        if depth != 0.0 {
            // The reference holds one end of the window of instability near speed 2. The other end is checked
            // by orbits on both of its sides.
            let window = branch.of_kind("period-doubling");
            let other = window[0].parameter;
            let stability = |speed: f64| {
                let model = model.with("speed", speed).unwrap();
                Shooting::new().run(&model, window[0].orbit.states()).unwrap().stability()
            };
            let sides = [stability(other - 1e-5), stability(other + 1e-5)];
            assert_eq!(sides, [Stability::Stable, Stability::Unstable]);
            all.push(("period-doubling".into(), other));
        }
        compare(&branch, &all, 1e-10);
        if let Some(exact) = case["exact_grazing_W"].as_array() {
            for exact in exact {
                let exact = exact.as_f64().unwrap();
                let found = branch.of_kind("grazing");
                let nearest = found.iter().map(|p| (p.parameter - exact).abs()).fold(f64::INFINITY, f64::min);
                println!("grazing {exact} {nearest:.1e}");
                assert!(nearest < 1e-10);
            }
        }
    }
}

/// While the teeth stay in contact the pair is linear: the doubled orbits exist at the parameter of the
/// doubling alone, with any amplitude up to the contact loss.
#[test]
fn doubled_orbits_branch_off_at_a_period_doubling() {
    let model = oscillator(&[("gap stiffness", 0.8), ("depth", 0.5), ("mean force", 0.5), ("damping", 0.05)]);
    let continuation = Continuation::new(2.4, 1.5).both_ways().bounds(1.2, 2.6);
    let branch = follow(&model, &continuation);
    println!("{branch}");
    let family = ByConstant::new(&model, "speed").unwrap();
    let doublings = branch.of_kind("period-doubling");
    assert!(!doublings.is_empty());
    for point in doublings {
        let doubled = continuation.clone().max_points(30).switch(&family, point, 1.0).unwrap();
        println!("{doubled}");
        let first = &doubled.points()[0];
        assert_eq!(first.orbit.period_multiple(), 2);
        assert!((first.parameter - point.parameter).abs() < 1e-10);
        assert!(doubled.of_kind("fold").is_empty());
        let state = &first.orbit.states()[0];
        let half = first.orbit.at(&model.with("speed", first.parameter).unwrap(), 0.5 * first.orbit.period());
        assert!((half.unwrap().q[0] - state.q[0]).abs() > 1e-3);
    }
}

/// With a cubic spring the amplitude of the half order grows like the root of the distance from the doubling.
#[test]
fn amplitude_of_doubled_orbits() {
    let given =
        [("gap stiffness", 0.8), ("depth", 0.5), ("mean force", 0.5), ("damping", 0.05), ("cubic", 0.3)];
    let model = oscillator(&given);
    let family = ByConstant::new(&model, "speed").unwrap();
    let continuation = Continuation::new(3.4, 2.0);
    let single = follow(&model.with("speed", 3.4).unwrap(), &continuation);
    println!("{single}");
    let point = single.of_kind("period-doubling")[0];
    let doubled = continuation.clone().max_step(0.01).max_points(12).switch(&family, point, 1.0).unwrap();
    println!("{doubled}");
    let share = |at: &BranchPoint| {
        let model = model.with("speed", at.parameter).unwrap();
        let half = at.orbit.at(&model, 0.5 * at.orbit.period()).unwrap().q[0] - at.orbit.states()[0].q[0];
        (at.parameter - point.parameter) / half.powi(2)
    };
    let shares: Vec<f64> = doubled.points()[..4].iter().map(share).collect();
    println!("{shares:?}");
    assert!(shares.iter().all(|s| (s / shares[0] - 1.0).abs() < 0.02));
}
