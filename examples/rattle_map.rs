//! Rattle map of the face gear pair of Liu 2021 over speed and load by both engines in lanes, each point with 60
//! turns settled and 40 measured: fixed steps (`LaneRk4`) on 50 x 50 points, located edges (`LaneTaylor`) on the
//! same points.
//!
//! The output states the shares of the rattle states, the run times, the time per evaluation compared with
//! a single run, and at how many points the plain map was wrong. The pictures show rattle state, peak-to-peak value
//! of the deflection, the points at which the engines differ, and sensitivity over speed and load, with the onset of
//! contact loss as located by continuations over the load; `map.csv` and `onset.csv` contain the numbers.
//!
//! `cargo run --release -p examples --example rattle_map`, with `-- --coarse` for fewer points; everything is written
//! to target/gallery/rattle_map/.

mod support;

use gear_dynamics::branches::{BranchPoint, Continuation, Family};
use gear_dynamics::sweep::Watch;
use gear_dynamics::sweep::{Axis, LaneRk4, LaneTaylor, Point, Points, Row, Rows, bounds::SweepEngine};
use gear_dynamics::{
    Integrator, NfgPair, NfgParams, ParameterError, Periodic, RattleState, Rk4, Shooting, State, Statistics,
    Sweep, Taylor,
};
use gear_dynamics_plots::{Mark, Picture, category_map, map};
use std::time::Instant;
use support::{Outcome, coarse, csv_file, gallery, progress};

/// Steps per turn: 64 per mesh period.
const STEPS: usize = 63 * 64;
const SETTLE: usize = 60;
const MEASURE: usize = 40;
/// Speeds [rad/s] and loads [N m] of the map.
const SPEEDS: [f64; 2] = [100.0, 250.0];
const LOADS: [f64; 2] = [2.0, 50.0];
/// A peak-to-peak value that is off by more than this share is wrong.
const WRONG: f64 = 0.05;

fn pair(p: &Point<'_>) -> Result<NfgPair, ParameterError> {
    NfgPair::new(&NfgParams { speed: p["omega_1"], load_torque: p["load"], ..NfgParams::table1() })
}

fn start(_: &Point<'_>, pair: &NfgPair) -> Result<State, ParameterError> {
    pair.on_drive_flank()
}

/// Seconds per evaluation of a single run without lanes and table, with statistics of the last periods.
fn scalar_run(pair: &NfgPair) -> Outcome<f64> {
    const PERIODS: usize = 10;
    let began = Instant::now();
    let solver = Rk4::new(pair.period() / STEPS as f64).plain();
    let settled = solver.end(pair, &pair.on_drive_flank()?, PERIODS as f64 * pair.period())?;
    let mut statistics = Statistics::new(pair, &["q0"])?;
    let share = PERIODS * MEASURE / SETTLE;
    solver.run(pair, &settled, settled.t + share as f64 * pair.period(), &mut statistics)?;
    Ok(began.elapsed().as_secs_f64() / (4 * STEPS * (PERIODS + share)) as f64)
}

/// The rows of a sweep by an engine, and the time that they took [s].
fn timed(what: &str, sweep: &Sweep, engine: &impl SweepEngine<NfgPair>) -> Outcome<(Rows, f64)> {
    let bar = progress(what, sweep.points().len());
    let advance = |done: usize, _: usize| bar.set_position(done as u64);
    let began = Instant::now();
    let rows = sweep.of(engine, pair).start(start).watch(Watch::new().progress(advance)).run()?;
    let seconds = began.elapsed().as_secs_f64();
    bar.finish_and_clear();
    println!(
        "{what}: {} points in {seconds:.1} s on {} threads, {} errors",
        rows.iter().count(),
        rayon::current_num_threads(),
        rows.errors().len()
    );
    Ok((rows, seconds))
}

/// The load below which teeth separate, at the speeds of the map: between the last point of a speed with contact loss
/// and the next one without, the grazing of the orbit of one turn is located by a continuation over the load.
fn onsets(rows: &Rows, side: usize) -> Outcome<Vec<(f64, f64)>> {
    let quiet = |index: usize| -> Outcome<bool> {
        Ok(rows.get(index)?.contacts()[0].rattle_state() == RattleState::None)
    };
    let shooting = Shooting::new().segments(1).tolerance(1e-9).flow_tolerance(1e-11);
    let mut onsets = Vec::new();
    for speed in 0..side {
        let at = |load: usize| speed * side + load;
        let mut first = side;
        while first > 0 && quiet(at(first - 1))? {
            first -= 1;
        }
        if first == 0 || first == side {
            continue;
        }
        let point = rows.points().point(at(first));
        let [above, below] = [point["load"], rows.points().point(at(first - 1))["load"]];
        let pair = pair(&point)?;
        let family = Family::over(&pair, ["load torque"])?;
        let range = Continuation::new(above, below).first_step(0.1).max_step(0.3).shooting(shooting.clone());
        let mut following = range.begin(&family, &[pair.on_drive_flank()?])?;
        let separates = |point: &BranchPoint| point.located.is_some_and(|what| what.changes_rattle());
        // Beside a jump both motions exist: the one without contact loss goes on to lower loads.
        if let Some(onset) = following.find(separates) {
            onsets.push((point["omega_1"], onset.parameter));
        }
    }
    Ok(onsets)
}

/// Whether the rattle state or a peak-to-peak value of the plain map is wrong.
fn is_wrong(plain: &Row<'_>, located: &Row<'_>) -> Outcome<bool> {
    let [a, b] = [plain.channel("q0")?.peak_to_peak(), located.channel("q0")?.peak_to_peak()];
    let [x, y] = [plain, located].map(|row| row.contacts()[0].rattle_state());
    Ok(x != y || (a - b).abs() > WRONG * b)
}

pub(crate) fn main() -> Outcome<()> {
    let folder = gallery("rattle_map")?;
    let side = if coarse() { 8 } else { 50 };
    let points = Points::grid(vec![
        Axis::linear("omega_1", SPEEDS[0], SPEEDS[1], side)?,
        Axis::linear("load", LOADS[0], LOADS[1], side)?,
    ])?;
    // Fixed steps across edges keep weakly stable motions from repeating to less than some per mille. Their
    // results are accurate nevertheless.
    let sweep = Sweep::new(points)
        .periodic_tolerance(5e-3)
        .settle(SETTLE)
        .measure(MEASURE)
        .channels(&["q0", "deflection"])
        .rattle();
    let (rows, seconds) = timed("fixed steps", &sweep, &LaneRk4::new(STEPS))?;
    let engine = LaneTaylor::new(Taylor::new().rtol(1e-8).atol(1e-13));
    let (located, slower) = timed("located edges", &sweep, &engine)?;

    let evaluations = (side * side * 4 * STEPS * (SETTLE + MEASURE)) as f64;
    let mut alone = f64::INFINITY;
    for _ in 0..3 {
        alone = alone.min(scalar_run(&pair(&rows.points().point(side * side / 2))?)?);
    }
    let each = seconds / evaluations;
    println!(
        "fixed steps: {:.3} ns per evaluation, {:.1} times as fast as a single run",
        1e9 * each,
        alone / each
    );
    println!("located edges take {:.1} times the time of fixed steps", slower / seconds);

    let mut csv = csv_file(folder.join("map.csv"), "omega_1,load,state,ppv,located_state,located_ppv,wrong")?;
    let mut wrong = vec![false; side * side];
    for (plain, row) in rows.iter().zip(located.iter()) {
        wrong[row.index()] = is_wrong(&plain, &row)?;
        csv.row(&[
            &row.point()["omega_1"],
            &row.point()["load"],
            &plain.contacts()[0].rattle_state().rsv(),
            &plain.channel("q0")?.peak_to_peak(),
            &row.contacts()[0].rattle_state().rsv(),
            &row.channel("q0")?.peak_to_peak(),
            &u8::from(wrong[row.index()]),
        ])?;
    }
    csv.finish()?;
    let count = |of: &dyn Fn(&Row<'_>) -> bool| rows.iter().filter(|row| of(row)).count();
    let share = |count: usize| 100.0 * count as f64 / (side * side) as f64;
    for state in [RattleState::None, RattleState::Unilateral, RattleState::Bilateral, RattleState::Floating] {
        println!(
            "{state:10} {:5.1}% of the points",
            share(count(&|row| row.contacts()[0].rattle_state() == state))
        );
    }
    let flagged = count(&|row| row.is_sensitive());
    let missed = count(&|row| wrong[row.index()] && !row.is_sensitive());
    println!("sensitive  {:5.1}% of the points: chaotic or grazing", share(flagged));
    println!(
        "the plain map is wrong at {} points, {missed} of them are not flagged as sensitive",
        wrong.iter().filter(|wrong| **wrong).count()
    );

    let began = Instant::now();
    let onsets = onsets(&located, side)?;
    println!(
        "onset of contact loss located at {} speeds, {:.1} s",
        onsets.len(),
        began.elapsed().as_secs_f64()
    );
    let mut csv = csv_file(folder.join("onset.csv"), "omega_1,load")?;
    for (speed, load) in &onsets {
        csv.row(&[speed, load])?;
    }
    csv.finish()?;

    let axes = ["pinion speed [rad/s]", "load torque [N m]"];
    let swing = |row: &Row<'_>| row.channel("deflection").map_or(f64::NAN, |x| x.peak_to_peak());
    let kinds = ["repeats", "sensitive: chaotic or grazing"];
    let differences = ["as with located edges", "wrong, flagged as sensitive", "wrong, not flagged"];
    let difference = |row: &Row<'_>| match (wrong[row.index()], row.is_sensitive()) {
        (false, _) => Some(0),
        (true, true) => Some(1),
        (true, false) => Some(2),
    };
    let panels = [
        gear_dynamics_plots::rattle_map(&located, axes, 0)?.title("rattle state of the only contact"),
        map(&located, axes, "peak-to-peak deflection [m]", swing)?
            .title("deflection")
            .logarithmic_colours()?,
        category_map(&rows, axes, &differences, difference)?.title("fixed steps"),
        category_map(&rows, axes, &kinds, |row| Some(usize::from(row.is_sensitive())))?.title("sensitivity"),
    ];
    let mut shown = Vec::new();
    for panel in panels {
        let panel = panel.x_range(SPEEDS[0], SPEEDS[1])?.y_range(LOADS[0], LOADS[1])?;
        shown.push(panel.series("located onset of contact loss", Mark::Line, onsets.iter().copied())?);
    }
    Ok(Picture::new(shown).columns(2).panel_size(480.0, 380.0).save(folder.join("map.svg"))?)
}
