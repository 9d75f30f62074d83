//! Frequency responses by continuation: a Duffing oscillator, a dead zone and a spur pair of varying mesh
//! stiffness.
//!
//! The table lists the folds, bifurcations and grazings of each curve. The picture shows the peak-to-peak
//! value over the speed, stable orbits solid and all others dashed, with the located points. At the period
//! doublings of the spur pair the orbits of twice the period are followed as well. `folds.csv` contains the
//! located points, and each curve has a file of its own.
//!
//! `cargo run --release -p examples --example frequency_response`; everything is written to
//! target/gallery/frequency_response/.

mod support;

use gear_dynamics::branches::{Branch, BranchEnd, BranchPoint, Continuation, Family, PointKind, Switch};
use gear_dynamics::models::Oscillator;
use gear_dynamics::{ParameterError, State};
use gear_dynamics_plots::{Picture, branch};
use std::fs::File;
use std::path::Path;
use std::time::Instant;
use support::{Csv, Outcome, csv_file, gallery};

/// An oscillator whose orbits are followed over the speed.
struct Problem {
    name: &'static str,
    title: &'static str,
    model: Oscillator,
    start: State,
    /// The first and the last speed `[1]`.
    speeds: [f64; 2],
    /// Lowest and highest speed at which the curve ends `[1]`.
    bounds: [f64; 2],
}

fn problems() -> Result<[Problem; 3], ParameterError> {
    let from =
        |speeds: [f64; 2], rest: &[(&str, f64)]| Oscillator::new(&[&[("speed", speeds[0])], rest].concat());
    let duffing = [("damping", 0.05), ("linear stiffness", 1.0), ("cubic stiffness", 0.1), ("force", 0.18)];
    let dead_zone = [
        ("damping", 0.1),
        ("mesh stiffness", 1.0),
        ("mean force", 0.25),
        ("force", 0.25),
        ("half backlash", 1.0),
    ];
    let gear_pair = [
        ("damping", 0.1),
        ("mesh stiffness", 1.0),
        ("stiffness variation", -0.2),
        ("mean force", 0.1),
        ("half backlash", 1.0),
    ];
    Ok([
        Problem {
            name: "duffing",
            title: "q'' + 0.05 q' + q + 0.1 q³ = 0.18 cos Ωt",
            model: from([0.5, 1.6], &duffing)?,
            start: State::at_rest(1),
            speeds: [0.5, 1.6],
            bounds: [0.5, 1.6],
        },
        Problem {
            name: "dead_zone",
            title: "x'' + 0.1 x' + g(x) = 0.25 + 0.25 cos Ωt",
            model: from([2.5, 0.4], &dead_zone)?,
            start: State::new(0.0, &[1.25], &[0.0]),
            speeds: [2.5, 0.4],
            bounds: [0.35, 2.6],
        },
        Problem {
            name: "gear_pair",
            title: "x'' + 0.1 x' + (1 − 0.2 cos Ωt) g(x) = 0.1",
            model: from([0.5, 2.2], &gear_pair)?,
            start: State::new(0.0, &[1.1], &[0.0]),
            speeds: [0.5, 2.2],
            bounds: [0.5, 2.2],
        },
    ])
}

/// The orbits of twice the period from a period doubling to the next crossing with the simple orbits. Beyond
/// it the branch repeats the same orbits, half a period apart.
fn doubled(continuation: &Continuation, family: &Family<'_>, point: &BranchPoint) -> Outcome<Branch> {
    let mut following = continuation.begin(family, Switch::of_point(point))?;
    let crosses = |point: &BranchPoint| point.kind() == Some(PointKind::Branch);
    let _ = following.by_ref().find(crosses);
    Ok(following.into_line())
}

/// Whether a branch of twice the period ends at this period doubling.
fn leaves_at(doubled: &Branch, point: &BranchPoint) -> bool {
    doubled.of_kind(PointKind::Branch).iter().any(|end| (end.parameter - point.parameter).abs() < 1e-9)
}

/// Writes a branch and its located points, and prints them.
fn report(folder: &Path, folds: &mut Csv, name: &str, branch: &Branch, seconds: f64) -> Outcome<()> {
    let end = match branch.end() {
        BranchEnd::Open => "the next period doubling is reached".to_owned(),
        end => end.to_string(),
    };
    println!("\n{name}: {} points in {seconds:.1} s; {end}", branch.points().len());
    branch.table()?.write_csv(File::create(folder.join(format!("{name}.csv")))?)?;
    for (kind, point) in branch.located() {
        println!("{:16.10}  {:10.6}  {kind}", point.parameter, point.peak_to_peak());
        folds.row(&[&name, &kind.kind(), &point.parameter, &point.peak_to_peak()])?;
    }
    for note in branch.notes() {
        println!("  {note}");
    }
    Ok(())
}

pub(crate) fn main() -> Outcome<()> {
    let folder = gallery("frequency_response")?;
    let mut folds = csv_file(folder.join("folds.csv"), "problem,kind,parameter,amplitude")?;
    let mut panels = Vec::new();
    println!("           speed  peak-to-peak  kind");
    for Problem { name, title, model, start, speeds, bounds: [low, high] } in problems()? {
        let family = Family::over(&model, ["speed"])?;
        let channel = if name == "duffing" { "q0" } else { "deflection" };
        let continuation =
            Continuation::new(speeds[0], speeds[1]).bounds(low, high).max_step(0.01).channels(&[channel]);
        let began = Instant::now();
        let simple = continuation.run(&family, &[start])?;
        report(&folder, &mut folds, name, &simple, began.elapsed().as_secs_f64())?;
        let mut branches = Vec::new();
        if name == "gear_pair" {
            for point in simple.of_kind(PointKind::PeriodDoubling) {
                if branches.iter().any(|doubled| leaves_at(doubled, point)) {
                    continue;
                }
                let began = Instant::now();
                let doubled = doubled(&continuation, &family, point)?;
                let name = format!("gear_pair_doubled_{}", branches.len() + 1);
                report(&folder, &mut folds, &name, &doubled, began.elapsed().as_secs_f64())?;
                branches.push(doubled);
            }
        }
        branches.insert(0, simple);
        let all: Vec<&Branch> = branches.iter().collect();
        panels.push(
            branch(&all, ["speed Ω [1]", "peak-to-peak value [1]"], BranchPoint::peak_to_peak)?.title(title),
        );
    }
    folds.finish()?;
    Picture::new(panels).panel_size(560.0, 320.0).save(folder.join("response.svg"))?;
    println!("\npicture and tables: {}", folder.display());
    Ok(())
}
