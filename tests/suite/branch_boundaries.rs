//! Boundaries of folds, doublings and contact loss over two parameters.

use crate::common::family::{Oscillator, oscillator};
use gear_dynamics::branches::{BoundaryLine, Branch, BranchEnd, ByConstant, ByConstants, Continuation, Turn};
use gear_dynamics::model::{Machine, State};

fn pair() -> Machine<Oscillator> {
    oscillator(&[("gap stiffness", 1.0), ("mean force", 0.1), ("inertia force", 0.05), ("damping", 0.1)])
}

fn over_speed(model: &Machine<Oscillator>) -> Branch {
    let family = ByConstant::new(model, "speed").unwrap();
    let start = State::new(0.0, &[1.0 + model.constant("mean force").unwrap()], &[0.0]);
    Continuation::new(0.5, 1.1).bounds(0.2, 2.0).run(&family, &[start]).unwrap()
}

fn print(line: &BoundaryLine) {
    println!("{} points, {}", line.points().len(), line.end());
    for (turn, point) in line.turns() {
        println!("   {turn} at {:?}", point.parameters);
    }
    for point in line.points().iter().step_by(10) {
        println!("   {:?} {:?}", point.parameters, point.multipliers.values()[0]);
    }
}

/// The teeth of a pair of constant stiffness separate where A Ω² = F √((1 - Ω²)² + (c Ω)²).
#[test]
fn onset_of_contact_loss_in_closed_form() {
    let (model, branch) = (pair(), over_speed(&pair()));
    let plane = ByConstants::new(&model, ["speed", "mean force"]).unwrap();
    let onset = branch.of_kind("grazing")[0];
    let range = Continuation::new(0.1, 0.3).both_ways().bounds(0.01, 0.6).bounds_across(0.2, 3.0);
    let line = range.boundary(&plane, onset).unwrap();
    print(&line);
    assert!(line.points().len() > 20 && line.notes().is_empty());
    for point in line.points() {
        let [speed, force] = point.parameters;
        let w = speed * speed;
        let exact = 0.05 * w / ((1.0 - w).powi(2) + 0.01 * w).sqrt();
        assert!((force - exact).abs() < 1e-10, "{speed} {force} {exact}");
    }
    // The largest mean force at which teeth separate belongs to the resonance.
    let top = line.turns().map(|(_, point)| point.parameters[1]).fold(0.0, f64::max);
    assert!((top - 0.05 / (1.0 - (1.0 - 0.005f64).powi(2)).sqrt()).abs() < 1e-10, "{top}");
}

/// The folds of the pair over speed and mean force meet in a cusp. Each point is compared with the fold that
/// a continuation over the speed locates.
#[test]
fn folds_meet_in_a_cusp() {
    let (model, branch) = (pair(), over_speed(&pair()));
    let plane = ByConstants::new(&model, ["speed", "mean force"]).unwrap();
    let fold = branch.of_kind("fold")[0];
    let line = Continuation::new(0.1, 0.3).both_ways().bounds(0.02, 1.0).boundary(&plane, fold).unwrap();
    print(&line);
    let cusps: Vec<_> = line.turns().filter(|(turn, _)| *turn == Turn::Cusp).collect();
    assert_eq!(cusps.len(), 1);
    let highest = cusps[0].1.parameters[1];
    for point in line.points().iter().step_by(7) {
        let [speed, force] = point.parameters;
        let folds = over_speed(&model.with("mean force", force).unwrap());
        let near =
            folds.of_kind("fold").iter().map(|f| (f.parameter - speed).abs()).fold(f64::INFINITY, f64::min);
        println!("{speed:.9} {force:.9} {near:.1e}");
        assert!(near < 1e-9);
    }
    // On both sides of the cusp: two folds below it, none above.
    assert_eq!(over_speed(&model.with("mean force", 0.999 * highest).unwrap()).of_kind("fold").len(), 2);
    assert_eq!(over_speed(&model.with("mean force", 1.001 * highest).unwrap()).of_kind("fold").len(), 0);
    assert_eq!(line.end(), &BranchEnd::Bound);
}
