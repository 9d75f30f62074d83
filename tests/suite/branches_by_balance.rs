//! Branches of the harmonic balance: folds against the reference and against shooting, the readings of the
//! face gear pair, families by closures, resuming, refusals.

use crate::api::*;
use crate::common::family::oscillator;
use crate::common::stored;
use crate::data::read;
use gear_dynamics::branches::{Branch, BranchEnd, BranchError, Continuation, Family, PointKind, Switch};
use gear_dynamics::models::Oscillator;
use gear_dynamics::models::ring::RingSet;
use std::f64::consts::TAU;

/// Folds of the balance in periodic_orbits.json: frequency and amplitude of the first order.
fn reference(case: &str) -> Vec<[f64; 2]> {
    let file = read("periodic_orbits.json");
    let number = |fold: &serde_json::Value, name: &str| fold[name].as_f64().unwrap();
    let folds = file["hbm"][case].as_array().unwrap();
    folds.iter().map(|fold| [number(fold, "Omega"), number(fold, "amp1")]).collect()
}

fn guess(model: &Oscillator, coefficients: [f64; 3]) -> FourierOrbit {
    FourierOrbit::new(&Harmonics::up_to(1), model.period(), &[coefficients.to_vec()]).unwrap()
}

fn duffing() -> Oscillator {
    let model = [
        ("cubic stiffness", 0.1),
        ("linear stiffness", 1.0),
        ("force", 0.18),
        ("damping", 0.05),
        ("speed", 0.5),
    ];
    oscillator(&model)
}

/// The spur pair of Kahraman & Singh 1990.
fn spur_pair() -> Oscillator {
    let constants = [("mesh stiffness", 1.0), ("mean force", 0.1), ("inertia force", 0.05), ("damping", 0.1)];
    oscillator(&constants).with("speed", 0.5).unwrap()
}

/// Every fold of the reference is found once to 1e-8, and no other.
fn compare(branch: &Branch<FourierOrbit>, case: &str) {
    println!("{case}: {branch}");
    let mut found = branch.of_kind(PointKind::Fold);
    for [omega, amplitude] in reference(case) {
        let nearest = (0..found.len()).min_by(|&i, &j| {
            (found[i].parameter - omega).abs().total_cmp(&(found[j].parameter - omega).abs())
        });
        let point = found.swap_remove(nearest.unwrap());
        println!("{case} {omega:.12} {:.1e}", point.parameter - omega);
        assert!((point.parameter - omega).abs() < 1e-8);
        assert!((point.orbit.amplitude(0, 1) - amplitude).abs() < 1e-6);
        assert!(point.orbit.residual() < 1e-9);
    }
    assert!(found.is_empty(), "not in the reference: {found:?}");
    assert_eq!(branch.end(), &BranchEnd::Bound);
}

#[test]
fn folds_of_duffing() {
    let model = duffing();
    let family = Family::over(&model, ["speed"]).unwrap();
    for (highest, case) in
        [(1, "duffing_H1_N64"), (5, "duffing_H5_N64"), (7, "duffing_H7_N29"), (10, "duffing_H10_N128")]
    {
        let balance = Balance::new(Harmonics::up_to(highest));
        let continuation = Continuation::new(0.5, 1.6);
        compare(
            &continuation
                .clone()
                .balance(balance.clone())
                .run(&family, &guess(&model, [0.0, 0.2, 0.0]))
                .unwrap(),
            case,
        );
    }
}

#[test]
fn folds_of_the_spur_pair() {
    let model = spur_pair();
    let family = Family::over(&model, ["speed"]).unwrap();
    for (highest, case) in [(5, "dz_KS90_H5_exact"), (10, "dz_KS90_H10_exact"), (20, "dz_KS90_H20_exact")] {
        let balance = Balance::new(Harmonics::up_to(highest));
        for integrals in [Integrals::Exact, Integrals::Kinks] {
            let balance = balance.clone().integrals(integrals);
            let start = guess(&model, [1.1, 0.0, 0.0]);
            let branch = Continuation::new(0.5, 1.1).balance(balance.clone()).run(&family, &start).unwrap();
            compare(&branch, case);
            assert_eq!(branch.of_kind(PointKind::Grazing).len(), 1);
        }
    }
}

/// With many orders the located points are those of shooting.
#[test]
fn many_orders_give_the_points_of_shooting() {
    let model =
        oscillator(&[("mesh stiffness", 1.0), ("mean force", 0.25), ("force", 0.25), ("damping", 0.1)]);
    let family = Family::over(&model, ["speed"]).unwrap();
    let continuation = Continuation::new(2.5, 0.5);
    let balance = Balance::new(Harmonics::up_to(60));
    let branch =
        continuation.clone().balance(balance.clone()).run(&family, &guess(&model, [1.2, 0.1, 0.1])).unwrap();
    let shot = continuation.run(&family, &State::new(0.0, &[1.25], &[0.0])).unwrap();
    println!("{branch}\n{shot}");
    fn located<O>(branch: &Branch<O>) -> Vec<(PointKind, f64, f64)> {
        branch.located().map(|(what, point)| (what.kind(), point.parameter, point.peak_to_peak())).collect()
    }
    let (a, b) = (located(&branch), located(&shot));
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(&b) {
        assert_eq!(a.0, b.0);
        assert!((a.1 - b.1).abs() < 2e-5 && (a.2 - b.2).abs() < 2e-3, "{a:?} {b:?}");
    }
    // Stability and rattle agree along the branch.
    let last = |branch: &Branch<FourierOrbit>| branch.points().last().unwrap().rattle.clone();
    assert_eq!(last(&branch), shot.points().last().unwrap().rattle);
}

/// A closure has no exact derivative: the points are the same.
#[test]
fn closures_give_the_same_folds() {
    let model = duffing();
    let family = Family::of([("speed", "1")], |[speed]| duffing().with("speed", speed));
    let balance = Balance::new(Harmonics::up_to(10));
    let start = guess(&model, [0.0, 0.2, 0.0]);
    compare(
        &Continuation::new(0.5, 1.6).balance(balance.clone()).run(&family, &start).unwrap(),
        "duffing_H10_N128",
    );
}

/// Another parameter than the frequency: the force of the Duffing oscillator at a fixed frequency, first in
/// closed form. A = Q of the one-term balance: F² = A² ((1 - Ω² + 0.075 A²)² + (0.05 Ω)²).
#[test]
fn force_of_the_one_term_balance() {
    let model = duffing().with("speed", 1.3).unwrap().with("force", 0.01).unwrap();
    let family = Family::over(&model, ["force"]).unwrap();
    let balance = Balance::new(Harmonics::of_orders(&[1]).unwrap());
    let start =
        FourierOrbit::new(&Harmonics::of_orders(&[1]).unwrap(), model.period(), &[vec![0.0, 0.0]]).unwrap();
    let branch = Continuation::new(0.01, 1.5).balance(balance.clone()).run(&family, &start).unwrap();
    assert_eq!(branch.of_kind(PointKind::Fold).len(), 2);
    for point in branch.points() {
        let a = point.orbit.amplitude(0, 1);
        let force = a * (1.0 - 1.69 + 0.075 * a * a).hypot(0.05 * 1.3);
        assert!((force - point.parameter).abs() < 1e-9, "{force} {}", point.parameter);
    }
}

/// A branch that is stopped, stored, read and resumed has the folds of one that is not; a branch both ways
/// contains the same folds.
#[test]
fn stopped_stored_and_resumed() {
    let model = duffing();
    let family = Family::over(&model, ["speed"]).unwrap();
    let balance = Balance::new(Harmonics::up_to(5));
    let continuation = Continuation::new(0.5, 1.6).balance(balance.clone());
    let start = guess(&model, [0.0, 0.2, 0.0]);
    let mut following = continuation.begin(&family, &start).unwrap();
    following.by_ref().take_while(|point| point.parameter < 1.2).for_each(drop);
    let first = stored(&following.into_line());
    let rest = continuation.resume(&family, &first).unwrap().finish();
    compare(&rest, "duffing_H5_N64");
    assert_eq!(rest.points()[0].arclength, first.points().last().unwrap().arclength);

    let model = model.with("speed", 1.2).unwrap();
    let both = Continuation::new(1.2, 1.6).bounds(0.5, 1.6).both_ways();
    let both = both.balance(balance).run(&family, &guess(&model, [0.0, -0.4, 0.0])).unwrap();
    compare(&both, "duffing_H5_N64");
}

/// The rigid motion of a ring, blocks of the Jacobian: the error amplitude as the parameter.
#[test]
fn error_of_a_ring() {
    let set = RingSet { error: 1e-6, ..RingSet::set_a(3, 5000.0) };
    let make = |error| Ring::as_printed(&RingSet { error, ..set.clone() }.params()?);
    let family = Family::of([("error", "m")], |[p]| make(p));
    let ring = make(1e-6).unwrap();
    let moving = Ring::as_printed(&set.params().unwrap())
        .unwrap()
        .with_frame(gear_dynamics::models::ring::Frame::Rigid);
    let solver = Dop853::new().rtol(1e-9).atol(1e-15);
    let later = solver.end(&moving, &State::at_rest(7), 40.0 * moving.period()).unwrap();
    let balance = Balance::new(Harmonics::up_to(4));
    let start = FourierOrbit::project(&solver, &moving, &later, balance.harmonics()).unwrap();
    let continuation = Continuation::new(1e-6, 2e-6).first_step(0.1).max_step(0.3).max_points(6);
    let branch = continuation.clone().balance(balance.clone()).run(&family, &start).unwrap();
    println!("{branch}");
    let last = branch.points().last().unwrap();
    let alone = balance.solve(&make(last.parameter).unwrap(), &last.orbit).unwrap();
    assert!(branch.points().len() > 2 && last.orbit.residual() < 1e-6 * (TAU / ring.period()).powi(2));
    // The last corrections of both are of this size.
    assert!(alone.distance(&last.orbit) < 1e-7, "{}", alone.distance(&last.orbit));
    for (ours, theirs) in last.orbit.mean_acceleration().iter().zip(alone.mean_acceleration()) {
        assert!((ours - theirs).abs() < 1e-6 * theirs.abs());
    }
}

#[test]
fn starts_without_an_orbit_are_refused() {
    let model = spur_pair();
    let family = Family::over(&model, ["speed"]).unwrap();
    let balance = Balance::new(Harmonics::up_to(5));
    let continuation = Continuation::new(0.5, 1.1).balance(balance);
    let error = continuation.run(&family, &guess(&model, [0.0, 0.0, 0.0])).unwrap_err();
    assert!(matches!(error, BranchError::Balance(BalanceError::StartInGap { contact: 0 })), "{error}");
    let start = guess(&model, [1.1, 0.0, 0.0]);
    let error = Continuation::new(0.5, 0.5).run(&family, &start).unwrap_err();
    assert!(matches!(error, BranchError::Parameter(ParameterError::Bounds { .. })));
    let few = continuation.clone().budget(Budget::new().steps(100));
    let branch = few.run(&family, &start).unwrap();
    assert!(matches!(branch.end(), BranchEnd::Exhausted(_)) && !branch.points().is_empty());
    // Other channels, and one that does not exist.
    let forces = continuation.clone().channels(&["mesh force", "q0"]);
    let branch = forces.run(&family, &start).unwrap();
    let point = &branch.points()[0];
    assert!((point.summaries[0].mean - 0.1).abs() < 1e-6, "the mean force balances the load");
    let error = continuation.clone().channels(&["force"]).run(&family, &start).unwrap_err();
    assert!(error.to_string().contains("force"), "{error}");
}

/// Settings of one kind of line are refused by the starts of another, before anything is solved.
#[test]
fn settings_that_a_start_does_not_read_are_refused() {
    let model = spur_pair();
    let family = Family::over(&model, ["speed"]).unwrap();
    let (range, by) = (Continuation::new(0.5, 1.1), ["a branch by shooting", "a branch by balance"]);
    let unread = |error: Option<BranchError>| match error {
        Some(BranchError::Parameter(ParameterError::Unread { name, by })) => (name, by),
        other => panic!("{other:?}"),
    };
    let with_balance = range.clone().balance(Balance::new(Harmonics::up_to(5)));
    let (across, shooting) = (range.clone().bounds_across(0.1, 2.0), range.shooting(Shooting::new()));
    let (state, series) = (State::new(0.0, &[1.1], &[0.0]), guess(&model, [1.1, 0.0, 0.0]));
    assert_eq!(unread(with_balance.run(&family, &state).err()), ("balance", by[0]));
    assert_eq!(unread(across.run(&family, &state).err()), ("bounds_across", by[0]));
    assert_eq!(unread(shooting.run(&family, &series).err()), ("shooting", by[1]));
    assert_eq!(unread(across.run(&family, &series).err()), ("bounds_across", by[1]));
    // Lines that are resumed.
    let branch = shooting.clone().max_points(2).run(&family, &state).unwrap();
    assert_eq!(unread(with_balance.resume(&family, &branch).err()), ("balance", by[0]));
    let branch = with_balance.clone().max_points(2).run(&family, &series).unwrap();
    assert_eq!(unread(shooting.resume(&family, &branch).err()), ("shooting", by[1]));
}

/// The states of the last iterate of a balance determine its series.
#[test]
fn an_error_of_a_branch_has_the_states_of_its_balance() {
    let model = spur_pair();
    let family = Family::over(&model, ["speed"]).unwrap();
    let balance = Balance::new(Harmonics::up_to(5));
    let spent = Continuation::new(0.5, 1.1).balance(balance.budget(Budget::new().steps(1)));
    let error = spent.run(&family, &guess(&model, [1.3, 0.4, 0.0])).unwrap_err();
    let states = error.last().unwrap();
    let BranchError::Balance(BalanceError::Exhausted { last, .. }) = &error else { panic!("{error}") };
    assert_eq!(states.len(), 11);
    let mean = states.iter().map(|state| state.q[0]).sum::<f64>() / 11.0;
    assert!((mean - last.coefficients(0)[0]).abs() < 1e-13, "{mean}");
}

/// The balance with truncated forces and 15 unknowns of the published face gear pair, by exact integrals.
/// Reference: the folds of an independent prototype.
#[test]
#[ignore = "more than six minutes without optimisation: cargo test --release --test suite branches_by_balance -- --ignored"]
fn folds_of_reading_p() {
    const FOLDS: [f64; 6] = [179.9259, 142.8263, 175.2485, 159.9188, 230.1309, 166.1109];
    let branch = reading_p(100.0, 250.0, Integrals::Exact);
    println!("{branch}");
    let folds: Vec<f64> = branch.of_kind(PointKind::Fold).iter().map(|point| point.parameter).collect();
    for (fold, expected) in folds.iter().zip(FOLDS) {
        println!("{fold:.6} {:.1e}", fold - expected);
        assert!((fold - expected).abs() < 1e-3, "{fold} {expected}");
    }
    assert_eq!(folds.len(), FOLDS.len(), "{folds:?}");
    // Many samples approach the exact integrals.
    let first = |integrals| reading_p(178.0, 180.5, integrals).of_kind(PointKind::Fold)[0].parameter;
    let errors = [4096, 16_384, 65_536].map(|samples| first(Integrals::Sampled { samples }) - folds[0]);
    println!("first fold by 4096, 16384, 65536 samples: {errors:?}");
    assert!(errors[2].abs() < 1e-4);
}

fn reading_p(from: f64, to: f64, integrals: Integrals) -> Branch<FourierOrbit> {
    let at =
        |speed| NfgPair::of_reading(&NfgParams { speed, ..NfgParams::table1() }, NfgReading::published());
    let family = Family::of([("speed", "rad/s")], |[p]| at(p));
    let balance = Balance::new(Harmonics::bands(63, 1, 2).unwrap()).integrals(integrals);
    let balance = balance.truncated_forces();
    let start = balance.linearised(&at(from).unwrap(), Piece::Lower).unwrap();
    let continuation = Continuation::new(from, to).max_points(if to < 200.0 { 120 } else { 2000 });
    continuation.balance(balance).run(&family, &start).unwrap()
}

/// Reading A of the face gear pair by shooting: the orbit with bilateral rattle and 252 crossings, settled at
/// 180 rad/s, continues downwards as an unstable orbit.
fn bilateral_branch() -> Branch<ShootingOrbit> {
    let pair = NfgPair::of_reading(
        &NfgParams { speed: 180.0, ..NfgParams::table1() },
        NfgReading::published_on_base_radius(),
    )
    .unwrap();
    let solver = Dop853::new().rtol(1e-9).atol(1e-14);
    let steady = Settle::new().tolerance(1e-7).run(&solver, &pair, &pair.on_drive_flank().unwrap()).unwrap();
    let start = State { t: 0.0, ..steady.state };
    let times = uniform_times(0.0, pair.period(), 63).unwrap();
    let turn = solver.sample(&pair, &start, &times).unwrap();
    let nodes: Vec<State> = (0..63).map(|i| State::new(times[i], turn.q(i), turn.v(i))).collect();
    let family = Family::over(&pair, ["speed"]).unwrap();
    // 252 crossings of edges: beside grazings the corrections of the unstable orbits end near 1e-7.
    let continuation = Continuation::new(180.0, 130.0).bounds(130.0, 181.0).max_points(250);
    let continuation = continuation.shooting(Shooting::new().tolerance(1e-6));
    let branch = continuation.run(&family, &nodes).unwrap();
    println!("{branch}");
    branch
}

/// Reference of the period doubling: multiple shooting of an independent prototype.
#[test]
#[ignore = "minutes without optimisation: cargo test --release --test suite branches_by_balance -- --ignored"]
fn bilateral_branch_by_shooting() {
    let branch = bilateral_branch();
    let doublings = branch.of_kind(PointKind::PeriodDoubling);
    assert!((doublings[0].parameter - 163.5279).abs() < 1e-3);
}

/// A multiplier passes 1 without a fold: the two arms come closer than the tolerance. The branch is to say so; it lists a
/// crossing at 161.853, which its tolerance does not tell from one.
#[test]
#[ignore = "open: fails, since arms closer than the tolerance are listed as a crossing"]
fn open_arms_of_the_bilateral_branch() {
    let branch = bilateral_branch();
    let note = branch.notes().iter().find(|note| note.what.contains("the determinant changed its sign"));
    let [low, high] = note.unwrap().parameters;
    assert!(161.8 < high && low < 161.9, "{low} .. {high}");
    assert!(branch.of_kind(PointKind::Branch).is_empty());
}

/// The prototype also gives a fold at 154.88116 rad/s, but steps over the places where two arms come closer than
/// the tolerance. The branch follows one of the arms and does not reach this fold.
#[test]
#[ignore = "open: fails, since the branch does not reach the fold"]
fn open_fold_of_the_bilateral_branch() {
    let branch = bilateral_branch();
    assert!((branch.of_kind(PointKind::Fold)[0].parameter - 154.881_16).abs() < 1e-4);
}

/// Doubled orbits by balance are those of shooting; a balance over one period is refused at a doubling.
#[test]
fn doubled_orbits_of_a_balance() {
    let given = [
        ("mesh stiffness", 0.8),
        ("stiffness variation", 0.5),
        ("mean force", 0.5),
        ("damping", 0.05),
        ("cubic stiffness", 0.3),
    ];
    let model = oscillator(&given).with("speed", 3.0).unwrap();
    let family = Family::over(&model, ["speed"]).unwrap();
    let balance = Balance::new(Harmonics::up_to(16)).integrals(Integrals::Exact);
    let range = Continuation::new(3.0, 2.0).max_step(0.02);
    let single =
        range.clone().balance(balance.clone()).run(&family, &guess(&model, [1.1, 0.1, 0.0])).unwrap();
    println!("{single}");
    let point = single.of_kind(PointKind::PeriodDoubling)[0];
    let twice =
        Balance::new(Harmonics::up_to(32).with_period_multiple(2).unwrap()).integrals(Integrals::Exact);
    let few = range.clone().max_points(12);
    let doubled = few.clone().balance(twice.clone()).run(&family, Switch::of_point(point)).unwrap();
    println!("{doubled}");
    for point in &doubled.points()[4..] {
        let model = model.with("speed", point.parameter).unwrap();
        let states = point.orbit.states(8).unwrap();
        let orbit = Shooting::new().period_multiple(2).solve(&model, &states).unwrap();
        let off = (orbit.states()[0].q[0] - point.orbit.at(orbit.states()[0].t).q[0]).abs();
        println!("{} half order {:.4} {off:.1e}", point.parameter, point.orbit.amplitude(0, 1));
        assert!(point.orbit.amplitude(0, 1) > 1e-3 && off < 1e-8);
    }
    let refused = few.clone().balance(balance.clone()).run(&family, Switch::of_point(point)).unwrap_err();
    assert!(refused.to_string().contains("twice those of the orbit"), "{refused}");
    let regular = few.clone().balance(twice.clone()).run(&family, Switch::of_point(&single.points()[0]));
    assert!(matches!(regular, Err(BranchError::Kind { kind: None, .. })));
}

/// The orbits without symmetry that branch off at a symmetry breaking.
#[test]
fn broken_symmetry_of_a_balance() {
    let given = [
        ("cubic stiffness", 1.0),
        ("linear stiffness", 1.0),
        ("force", 10.0),
        ("damping", 0.2),
        ("speed", 2.2),
    ];
    let model = oscillator(&[&given[..], &[("half backlash", 99.0)]].concat());
    let family = Family::over(&model, ["speed"]).unwrap();
    let balance = Balance::new(Harmonics::up_to(24));
    let range = Continuation::new(2.2, 1.6).max_step(0.02).balance(balance);
    let branch = range.run(&family, &guess(&model, [0.0, 2.8, 0.0])).unwrap();
    println!("{branch}");
    let point = branch.of_kind(PointKind::SymmetryBreaking)[0];
    let switch = Switch::of_point(point);
    for way in [switch.clone(), switch.reversed()] {
        let other = range.clone().max_points(8).run(&family, way).unwrap();
        let last = other.points().last().unwrap();
        println!("{} mean {}", last.parameter, last.orbit.mean(0));
        assert!(last.orbit.mean(0).abs() > 1e-2);
        let at = model.with("speed", last.parameter).unwrap();
        let orbit = Shooting::new().solve(&at, &last.orbit.states(1).unwrap()).unwrap();
        assert!((orbit.states()[0].q[0] - last.orbit.at(0.0).q[0]).abs() < 1e-7);
    }
}

/// A branch of a sampled balance has corners, and folds at them: they are located, near those of exact integrals.
#[test]
fn folds_of_sampled_balances_are_located() {
    let model = spur_pair();
    let family = Family::over(&model, ["speed"]).unwrap();
    let folds = |integrals| {
        let balance = Balance::new(Harmonics::up_to(5)).integrals(integrals);
        let start = guess(&model, [1.1, 0.0, 0.0]);
        let branch =
            Continuation::new(0.5, 1.1).max_points(400).balance(balance).run(&family, &start).unwrap();
        println!("{branch}");
        branch.of_kind(PointKind::Fold).iter().map(|point| point.parameter).collect::<Vec<f64>>()
    };
    let exact = folds(Integrals::Exact);
    assert!(exact.len() >= 2, "{exact:?}");
    let sampled = folds(Integrals::Sampled { samples: 2048 });
    for fold in &exact {
        assert!(sampled.iter().any(|found| (found - fold).abs() < 1e-3), "{fold}: {sampled:?}");
    }
}
