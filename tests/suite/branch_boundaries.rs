//! Boundaries of folds, doublings and contact loss over two parameters.

use crate::common::family::oscillator;
use crate::common::stored;
use gear_dynamics::branches::{
    BoundaryLine, Branch, BranchEnd, BranchError, Continuation, Family, PointKind, StabilityMethod, Turn,
};
use gear_dynamics::model::State;
use gear_dynamics::models::Oscillator;
use gear_dynamics::{Balance, Harmonics, ParameterError, Shooting};

fn pair() -> Oscillator {
    oscillator(&[("mesh stiffness", 1.0), ("mean force", 0.1), ("inertia force", 0.05), ("damping", 0.1)])
}

fn over_speed(model: &Oscillator) -> Branch {
    let family = Family::over(model, ["speed"]).unwrap();
    let start = State::new(0.0, &[1.0 + model.constant("mean force").unwrap()], &[0.0]);
    Continuation::new(0.5, 1.1).bounds(0.2, 2.0).run(&family, &[start]).unwrap()
}

fn print(line: &BoundaryLine) {
    println!("{} points, {}", line.points().len(), line.end());
    for point in line.turns() {
        println!("   {:?} at {:?}", point.turn, point.parameters);
    }
    for point in line.points().iter().step_by(10) {
        println!("   {:?} {:?}", point.parameters, point.multipliers.values()[0]);
    }
}

/// The teeth of a pair of constant stiffness separate where A Ω² = F √((1 - Ω²)² + (c Ω)²).
#[test]
fn onset_of_contact_loss_in_closed_form() {
    let (model, branch) = (pair(), over_speed(&pair()));
    let plane = Family::over(&model, ["speed", "mean force"]).unwrap();
    let onset = branch.of_kind(PointKind::Grazing)[0];
    let range = Continuation::new(0.1, 0.3).both_ways().bounds(0.01, 0.6).bounds_across(0.2, 3.0);
    let line = range.run(&plane, onset).unwrap();
    print(&line);
    assert!(line.points().len() > 20 && line.notes().is_empty());
    for point in line.points() {
        let [speed, force] = point.parameters;
        let w = speed * speed;
        let exact = 0.05 * w / ((1.0 - w).powi(2) + 0.01 * w).sqrt();
        assert!((force - exact).abs() < 1e-10, "{speed} {force} {exact}");
    }
    // The largest mean force at which teeth separate belongs to the resonance.
    let top = line.turns().map(|point| point.parameters[1]).fold(0.0, f64::max);
    assert!((top - 0.05 / (1.0 - (1.0 - 0.005f64).powi(2)).sqrt()).abs() < 1e-10, "{top}");
}

/// The folds of the pair over speed and mean force meet in a cusp. Each point is compared with the fold that
/// a continuation over the speed locates.
#[test]
fn folds_meet_in_a_cusp() {
    cusp(20);
}

#[test]
#[ignore = "half a minute without optimisation: cargo test --release --test suite branch_boundaries -- --ignored"]
fn folds_that_meet_in_a_cusp_at_more_points() {
    cusp(7);
}

/// Every `stride`-th point is compared.
fn cusp(stride: usize) {
    let (model, branch) = (pair(), over_speed(&pair()));
    let plane = Family::over(&model, ["speed", "mean force"]).unwrap();
    let fold = branch.of_kind(PointKind::Fold)[0];
    let line = Continuation::new(0.1, 0.3).both_ways().bounds(0.02, 1.0).run(&plane, fold).unwrap();
    print(&line);
    let cusps: Vec<_> = line.turns().filter(|point| point.turn == Some(Turn::Cusp)).collect();
    assert_eq!(cusps.len(), 1);
    let highest = cusps[0].parameters[1];
    for point in line.points().iter().step_by(stride) {
        let [speed, force] = point.parameters;
        let folds = over_speed(&model.with("mean force", force).unwrap());
        let near = folds
            .of_kind(PointKind::Fold)
            .iter()
            .map(|f| (f.parameter - speed).abs())
            .fold(f64::INFINITY, f64::min);
        println!("{speed:.9} {force:.9} {near:.1e}");
        assert!(near < 1e-9);
    }
    // On both sides of the cusp: two folds below it, none above.
    assert_eq!(
        over_speed(&model.with("mean force", 0.999 * highest).unwrap()).of_kind(PointKind::Fold).len(),
        2
    );
    assert_eq!(
        over_speed(&model.with("mean force", 1.001 * highest).unwrap()).of_kind(PointKind::Fold).len(),
        0
    );
    assert_eq!(line.end(), &BranchEnd::Bound);
}

/// A boundary is stopped, stored, read and resumed: the points are those of one run. Its table and its text.
#[test]
fn a_boundary_is_stored_and_resumed() {
    let (model, branch) = (pair(), over_speed(&pair()));
    let plane = Family::over(&model, ["speed", "mean force"]).unwrap();
    let onset = branch.of_kind(PointKind::Grazing)[0];
    let range = Continuation::new(0.1, 0.3);
    let whole = range.run(&plane, onset).unwrap();
    let mut following = range.begin(&plane, onset).unwrap();
    assert_eq!(following.by_ref().take(6).count(), 6);
    assert_eq!(following.line().points().len(), 6);
    let stopped: BoundaryLine = stored(&following.into_line());
    assert_eq!(stopped.end(), &BranchEnd::Open);
    let last = &stopped.points()[5];
    let rest = range.resume(&plane, &stopped).unwrap().finish();
    assert_eq!((rest.points()[0].parameters, rest.points()[0].arclength), (last.parameters, last.arclength));
    let ends = [&whole, &rest].map(|line| line.points().last().unwrap().parameters);
    assert_eq!([ends[0][1], ends[1][1]], [0.3; 2]);
    assert!((ends[0][0] - ends[1][0]).abs() < 1e-11);
    let read: BoundaryLine = stored(&whole);
    assert_eq!(read, whole);
    let table = whole.table().unwrap();
    assert_eq!(table.len(), whole.points().len());
    assert_eq!(table.column("mean force").unwrap()[3], whole.points()[3].parameters[1]);
    assert!(whole.to_string().ends_with("end: a bound of the parameter is reached"), "{whole}");
    // A boundary without points; a kind without a boundary.
    let empty = range.begin(&plane, onset).unwrap();
    let none = BoundaryLine::clone(empty.line());
    assert_eq!(range.resume(&plane, &none).err(), Some(BranchError::NoPoints));
}

/// A closed boundary that crosses p = 0: with the inertia force A (p² + λ²)/R², the teeth separate on the circle of
/// radius R.
#[test]
fn a_closed_boundary_ends_at_its_start() {
    const R: f64 = 0.5;
    let w = 0.49;
    let onset = 0.1 * ((1.0f64 - w).powi(2) + 0.01 * w).sqrt() / w;
    let at = move |[p, other]: [f64; 2]| {
        let force = onset * (p * p + other * other) / (R * R);
        pair().with("speed", 0.7)?.with("inertia force", force)
    };
    let family = Family::of([("p", "1")], move |[p]| at([p, 0.0]));
    let branch = Continuation::new(0.4, 0.6).run(&family, &State::new(0.0, &[1.1], &[0.0])).unwrap();
    let plane = Family::of([("p", "1"), ("λ", "1")], at);
    assert_eq!(plane.parameters()[1].name, "λ");
    let range = Continuation::new(0.0, 1.0).bounds(-1.0, 1.0).bounds_across(-1.0, 1.0).max_step(0.1);
    let line = range.run(&plane, branch.of_kind(PointKind::Grazing)[0]).unwrap();
    println!("{line}");
    assert_eq!(line.end(), &BranchEnd::Closed);
    for point in line.points() {
        let [p, other] = point.parameters;
        assert!((p.hypot(other) - R).abs() < 1e-10, "{p} {other}");
    }
    assert!(line.points().iter().any(|point| point.parameters[0] < -0.4));
    assert_eq!(line.turns().count(), 2);
    // Settings that a boundary does not read.
    let onset = branch.of_kind(PointKind::Grazing)[0];
    let refused = |range: Continuation| match range.run(&plane, onset) {
        Err(BranchError::Parameter(ParameterError::Unread { name, by: "a boundary" })) => name,
        other => panic!("{:?}", other.map(|line| line.points().len())),
    };
    assert_eq!(refused(range.clone().stability(StabilityMethod::Skipped)), "stability");
    assert_eq!(refused(range.clone().channels(&["q0"])), "channels");
    assert_eq!(refused(range.balance(Balance::new(Harmonics::up_to(1)))), "balance");
    // Without bounds of p its unit is not known at p = 0.
    let refused = Continuation::new(0.0, 1.0).bounds(-1.0, 1.0);
    let mut at_zero = branch.of_kind(PointKind::Grazing)[0].clone();
    at_zero.parameter = 0.0;
    assert!(matches!(
        refused.run(&plane, &at_zero),
        Err(BranchError::Parameter(ParameterError::Bounds { value: 0.0, .. }))
    ));
}

/// The symmetry breaking of a Duffing oscillator over speed and force, against the points that branches over the speed
/// locate.
#[test]
fn symmetry_breaking_over_two_parameters() {
    let given = [
        ("cubic stiffness", 1.0),
        ("linear stiffness", 1.0),
        ("damping", 0.2),
        ("half backlash", 99.0),
        ("force", 10.0),
    ];
    let model = oscillator(&given);
    let breaking = |force: f64, from: f64, to: f64| {
        let model = model.with("force", force).unwrap();
        let at = model.with("speed", from).unwrap();
        let start = Shooting::new().solve(&at, &State::new(0.0, &[2.8], &[0.0])).unwrap();
        let family = Family::over(&model, ["speed"]).unwrap();
        let branch = Continuation::new(from, to).run(&family, start.states()).unwrap();
        branch.of_kind(PointKind::SymmetryBreaking)[0].clone()
    };
    let first = breaking(10.0, 2.2, 1.4);
    let plane = Family::over(&model, ["speed", "force"]).unwrap();
    let line = Continuation::new(10.0, 14.0).run(&plane, &first).unwrap();
    println!("{line}");
    assert_eq!((line.end(), line.notes().len()), (&BranchEnd::Bound, 0));
    let last = line.points().last().unwrap();
    let theirs = breaking(14.0, last.parameters[0] + 0.1, last.parameters[0] - 0.1).parameter;
    println!("{} {theirs}", last.parameters[0]);
    assert!((last.parameters[0] - theirs).abs() < 1e-8);
    for point in line.points() {
        let orbit = &point.orbit;
        let at =
            model.with("speed", point.parameters[0]).unwrap().with("force", point.parameters[1]).unwrap();
        let half = orbit.at(&at, orbit.states()[0].t + 0.5 * orbit.period()).unwrap();
        assert!((half.q[0] + orbit.states()[0].q[0]).abs() < 1e-9);
        let nearest =
            point.multipliers.values().iter().map(|m| (m - 1.0).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-8, "{nearest}");
    }
}
