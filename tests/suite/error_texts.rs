//! The texts of errors, with their numbers filled in: a range is an interval, a condition begins with a verb,
//! and messages say what happened, the number and the remedy.

use crate::api::*;
use gear_dynamics::branches::{Continuation, CurveError, Family};
use gear_dynamics::certify::{Interval, Unproved};
use gear_dynamics::linear::{Campbell, LinearError};
use gear_dynamics::trains::SpurPair;
use std::path::Path;

/// Whether a text is an interval, with a unit or without: "[0, 1.4] rad".
fn is_interval(text: &str) -> bool {
    let Some(inside) = text.strip_prefix(['[', '(']) else { return false };
    let Some((inside, unit)) = inside.split_once([']', ')']) else { return false };
    inside.split(", ").count() == 2 && unit.len() < 6 && !unit.contains(',')
}

fn sources(folder: &Path, all: &mut Vec<std::path::PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => sources(&path, all),
            false => all.push(path),
        }
    }
}

/// The text of `OutOfRange` is "it must lie in {allowed}": every range in the source is an interval, and every
/// condition of `Wrong` begins with a verb.
#[test]
fn ranges_in_errors_are_intervals() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../src"));
    let mut all = Vec::new();
    sources(root, &mut all);
    let (mut ranges, mut conditions) = (0, 0);
    for path in all {
        let text = std::fs::read_to_string(&path).unwrap();
        let literals = |mark: &str, is_right: &dyn Fn(&str) -> bool| {
            let found = text.split(mark).skip(1).map(|rest| &rest[..rest.find('"').unwrap()]);
            found.inspect(|literal| assert!(is_right(literal), "{path:?}: {literal}")).count()
        };
        for mark in ["allowed: \"", "allowed = \"", "OutOfRange { name, value, allowed: \""] {
            ranges += literals(mark, &is_interval);
        }
        let verb =
            |text: &str| ["be ", "stand ", "belong ", "divide "].iter().any(|verb| text.starts_with(verb));
        for mark in ["must: \"", "must = \"", "must: format!(\"", "must = format!(\""] {
            conditions += literals(mark, &verb);
        }
    }
    assert!(ranges >= 15 && conditions >= 10, "{ranges} {conditions}");
}

/// Every condition that is not an interval, as a user reads it.
#[test]
fn conditions_are_sentences() {
    let pair = SpurPair::of_numbers(0.05, 0.1, &[-0.2], &[]).unwrap().parts().unwrap();
    let pair = pair.build("driver", 0.6).unwrap();
    let state = |t: f64, q: f64| State::new(t, &[q], &[0.0]);
    let torus = Torus::constant(&WaveVectors::within(&[2, 2]).unwrap(), &[1.0, 2.0f64.sqrt()], &[0.0]);
    let linear = |error: LinearError| match error {
        LinearError::Parameter(error) => error,
        other => panic!("{other}"),
    };
    let branch = |range: Continuation| {
        range.run(&Family::over(&pair, ["speed"]).unwrap(), &state(0.0, 1.1)).unwrap_err().to_string()
    };
    let errors = [
        (
            linear(Campbell::of(&pair, &[60.0, 50.0], &[1.0]).unwrap_err()),
            "speeds[1] is 50.0: it must be above 60.0, the speed before it",
        ),
        (
            SpeedLaw::table(&[1.0], &[1.0]).unwrap_err(),
            "times[0] of the speed law is 1.0: it must be 0, where the law starts",
        ),
        (
            ClosedCurve::new(&[0.0, 1.0, 2.0, 3.0].map(|q| state(0.0, q))).unwrap_err(),
            "nodes is 4.0: it must be odd",
        ),
        (
            Matrix::blocks(&[2, 2], &[(0, 2)]).unwrap_err(),
            "column of block 0 of the pattern is 2.0: it must be below 2, the number of block rows",
        ),
        (
            Matrix::blocks(&[2, 2], &[(0, 1), (0, 1)]).unwrap_err(),
            "column of block 1 of the pattern is 1.0: it must stand once in row 0 of the pattern",
        ),
        (
            Harmonics::of_orders(&[2, 1, 2]).unwrap_err(),
            "an order of the list is 2.0: it must be listed once",
        ),
        (
            Interval::new(2.0, 1.0).unwrap_err(),
            "lower end of an interval is 2.0: it must be at most 1.0, its upper end",
        ),
        (
            torus.unwrap().with(0, &[5, 1], [0.0; 2]).unwrap_err(),
            "largest component of the wave vector [5, 1] is 5.0: it must belong to a wave vector that the series keeps \
             (WaveVectors)",
        ),
        (
            NfgPair::new(&NfgParams { ratio: 3.75, ..NfgParams::table1() }).unwrap_err(),
            "face gear teeth is 67.5: it must be a whole number from 1 to 1000000: pinion_teeth times ratio",
        ),
    ];
    for (error, text) in errors {
        assert!(matches!(error, ParameterError::Wrong { .. }), "{error:?}");
        assert_eq!(error.to_string(), text);
    }
    let range = Continuation::new(0.6, 0.65);
    for (range, text) in [
        (range.clone().min_step(0.2).max_step(0.1), "min_step is 0.2: it must be at most 0.1, the max_step"),
        // The user has not set the other one.
        (range.clone().min_step(0.2), "min_step is 0.2: it must be at most 0.05, the max_step"),
        (range.max_step(1e-12), "max_step is 1e-12: it must be at least 1e-9, the default min_step"),
    ] {
        let branch = branch(range);
        assert!(branch.contains(text), "{branch}");
    }
}

/// What an engineer needs of an error: the number, and what to do.
#[test]
fn messages_name_number_and_remedy() {
    let mut root =
        Root::start(&mut Equations::new(2, |_, r| r.fill(2.0)), &[1.0, 0.25], &mut [0.0; 2]).unwrap();
    root.iterations = 3;
    let what = || "a contact force that the rigid motion changes".to_owned();
    let texts = [
        (Unproved::NoEnclosure { what: what() }.to_string(), ["none for a contact force", "`Machine`"]),
        (Unproved::NotContracting { t: 0.5, needed: 1.5 }.to_string(), ["t = 0.5 to 1.5", "flow_tolerance"]),
        (LinearError::Free { residual: 0.25 }.to_string(), ["2.5e-1", "hold a body"]),
        (
            LinearError::NoContactState { tried: 64 }.to_string(),
            ["64 were tried", "give a start of your own"],
        ),
        (LinearError::MeanSquareGrows.to_string(), ["damping takes out", "lower its intensity"]),
        (
            CurveError::Unexplained { what: "a contact grazed an edge" }.to_string(),
            ["the next one a contact grazed an edge, and", "smaller max_step"],
        ),
        (
            RootError::Singular { unknown: 1, last: Box::new(root) }.to_string(),
            ["after 3 iterations, where unknown 1 is 0.25", "start elsewhere"],
        ),
        (ParameterError::Singular { unknown: 1 }.to_string(), ["changes unknown 1", "leave it out"]),
    ];
    for (text, parts) in texts {
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    }
}
