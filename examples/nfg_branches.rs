//! Branches of the noncircular face gear pair of Liu 2021 over the speed, 100 to 250 rad/s.
//!
//! - *P*: the balance of Liu 2021 with 15 unknowns and the force truncated to the kept orders before it is
//!   multiplied by the stiffness, by exact integrals: the folds belong to the balance and not to its samples.
//! - *equation*: the same equations by shooting, on the base radius. The motion without rattle and with
//!   unilateral rattle is followed from 100 to 138 rad/s; beyond, it grazes its edges at ever closer speeds
//!   until its first folds at 148.9 rad/s. The motion with bilateral rattle is followed from
//!   the settled motion at 180 rad/s in both directions, downwards as an unstable orbit through the speeds at
//!   which runs in time are chaotic.
//!
//! `cargo run --release -p examples --example nfg_branches`, with `-- --coarse` for a part of the branches;
//! tables and the picture are written to target/gallery/nfg_branches/.

mod support;

use gear_dynamics::branches::{Branch, BranchPoint, Continuation, Family};
use gear_dynamics::contact::Piece;
use gear_dynamics::models::nfg::NfgReading;
use gear_dynamics::ode::uniform_times;
use gear_dynamics::{
    Balance, Dop853, Harmonics, Integrator, NfgPair, NfgParams, Periodic, Settle, Shooting, State,
};
use gear_dynamics_plots::{Picture, branch};
use std::time::Instant;
use support::{Csv, Outcome, coarse, csv_file, gallery};

fn pair(speed: f64, reading: NfgReading) -> Result<NfgPair, gear_dynamics::ParameterError> {
    NfgPair::of_reading(&NfgParams { speed, ..NfgParams::table1() }, reading)
}

/// One turn of the settled motion at a speed, as states at equal times.
fn settled(pair: &NfgPair, nodes: usize) -> Outcome<Vec<State>> {
    let solver = Dop853::new().rtol(1e-9).atol(1e-14);
    let steady = Settle::new().tolerance(1e-7).run(&solver, pair, &pair.on_drive_flank()?)?;
    let start = State { t: 0.0, ..steady.state };
    let times = uniform_times(0.0, pair.period(), nodes)?;
    let turn = solver.sample(pair, &start, &times)?;
    Ok((0..nodes).map(|i| State::new(times[i], turn.q(i), turn.v(i))).collect())
}

fn report<O>(
    name: &str,
    branch: &Branch<O>,
    begun: Instant,
    (folds, points): (&mut Csv, &mut Csv),
) -> Outcome<()> {
    println!("{name}, {:.1} s: {branch}\n", begun.elapsed().as_secs_f64());
    for (kind, point) in branch.located() {
        folds.row(&[&name, &kind.kind(), &point.parameter, &point.peak_to_peak()])?;
    }
    for point in branch.points() {
        let stability = point.stability();
        let largest = point.multipliers.largest();
        points.row(&[
            &name,
            &point.parameter,
            &point.peak_to_peak(),
            &largest,
            &stability,
            &point.rattle[0],
        ])?;
    }
    Ok(())
}

pub(crate) fn main() -> Outcome<()> {
    let folder = gallery("nfg_branches")?;
    let mut folds = csv_file(folder.join("folds.csv"), "problem,kind,parameter,amplitude")?;
    let header = "problem,speed,amplitude,largest_multiplier,stability,rattle";
    let mut points = csv_file(folder.join("points.csv"), header)?;

    let published = |speed| pair(speed, NfgReading::published());
    let family = Family::of([("speed", "rad/s")], |[p]| published(p));
    let balance = Balance::new(Harmonics::bands(63, 1, 2)?).truncated_forces();
    let begun = Instant::now();
    let flank = balance.linearised(&published(100.0)?, Piece::Lower)?;
    let continuation = Continuation::new(100.0, 250.0).max_points(if coarse() { 90 } else { 2000 });
    let p = continuation.balance(balance).run(&family, &flank)?;
    report("P", &p, begun, (&mut folds, &mut points))?;

    let on_base = |speed| pair(speed, NfgReading::published_on_base_radius());
    let slow = on_base(100.0)?;
    let family = Family::over(&slow, ["speed"])?;
    let begun = Instant::now();
    let to = if coarse() { 120.0 } else { 138.0 };
    let none = Continuation::new(100.0, to).run(&family, &[slow.on_drive_flank()?])?;
    report("equation, from rest", &none, begun, (&mut folds, &mut points))?;

    let fast = on_base(180.0)?;
    let family = Family::over(&fast, ["speed"])?;
    let turn = settled(&fast, 63)?;
    let begun = Instant::now();
    let down =
        Continuation::new(180.0, 130.0).bounds(130.0, 181.0).max_points(if coarse() { 12 } else { 250 });
    // 252 crossings of edges: beside grazings the corrections of the unstable orbits end near 1e-7.
    let down = down.shooting(Shooting::new().tolerance(1e-6)).run(&family, &turn)?;
    report("equation, bilateral, down", &down, begun, (&mut folds, &mut points))?;
    let begun = Instant::now();
    let up = Continuation::new(180.0, if coarse() { 185.0 } else { 250.0 }).run(&family, &turn)?;
    report("equation, bilateral, up", &up, begun, (&mut folds, &mut points))?;

    let axes = ["speed [rad/s]", "peak-to-peak of q [rad]"];
    let of_p = branch(&[&p], axes, BranchPoint::peak_to_peak)?.title("P: 15 unknowns, exact integrals");
    let of_equation = branch(&[&none, &down, &up], axes, BranchPoint::peak_to_peak)?;
    let panels = [of_p, of_equation.title("equation, by shooting")];
    Picture::new(panels).panel_size(640.0, 400.0).save(folder.join("branches.svg"))?;
    println!("pictures and tables: {}", folder.display());
    Ok(())
}
