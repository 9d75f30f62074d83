//! Rattle map of the face gear pair of Liu 2021 over speed and load: 100 x 100 points in lanes, each with 60
//! turns settled and 40 measured.
//!
//! The output states the shares of the rattle states, the run time, and the time per evaluation compared with
//! a single run. The pictures show rattle state, peak-to-peak value of the deflection, contact loss and
//! sensitivity over speed and load; `map.csv` contains the points.
//!
//! `cargo run --release -p examples --example rattle_map`; everything is written to
//! target/gallery/rattle_map/.

mod support;

use gear_dynamics::sweep::{Axis, LaneRk4, Point, Points, Row};
use gear_dynamics::{
    Integrator, NfgPair, NfgParams, ParameterError, Periodic, RattleState, Rk4, State, Statistics, Sweep,
};
use gear_dynamics_plots::{Picture, category_map, map};
use std::time::Instant;
use support::{Outcome, csv_file, gallery, progress};

/// Steps per turn: 64 per mesh period.
const STEPS: usize = 63 * 64;
const SETTLE: usize = 60;
const MEASURE: usize = 40;
const SIDE: usize = 100;

fn pair(p: &Point<'_>) -> Result<NfgPair, ParameterError> {
    NfgPair::new(&NfgParams { speed: p["omega_1"], load_torque: p["load"], ..NfgParams::table1() })
}

fn start(_: &Point<'_>, pair: &NfgPair) -> Result<State, ParameterError> {
    pair.static_start()
}

/// Seconds per evaluation of a single run without lanes and table, with statistics of the last periods.
fn scalar_run(pair: &NfgPair) -> Outcome<f64> {
    const PERIODS: usize = 10;
    let began = Instant::now();
    let solver = Rk4::new(pair.period() / STEPS as f64).plain();
    let settled = solver.end(pair, &pair.static_start()?, PERIODS as f64 * pair.period())?;
    let mut statistics = Statistics::new(pair, &["q0"])?;
    let share = PERIODS * MEASURE / SETTLE;
    solver.run(pair, &settled, settled.t + share as f64 * pair.period(), &mut statistics)?;
    Ok(began.elapsed().as_secs_f64() / (4 * STEPS * (PERIODS + share)) as f64)
}

fn main() -> Outcome<()> {
    let folder = gallery("rattle_map")?;
    let points = Points::grid(vec![
        Axis::linear("omega_1", 100.0, 250.0, SIDE)?,
        Axis::linear("load", 2.0, 50.0, SIDE)?,
    ])?;
    // Fixed steps across edges keep weakly stable motions from repeating to less than some per mille. Their
    // results are accurate nevertheless.
    let sweep = Sweep::new(points)
        .periodic_tolerance(5e-3)
        .settle(SETTLE)
        .measure(MEASURE)
        .channels(&["q0", "deflection"])
        .rattle();

    let bar = progress("speed x load", SIDE * SIDE);
    let advance = |done: usize, _: usize| bar.set_position(done as u64);
    let began = Instant::now();
    let rows = sweep.of(&LaneRk4::new(STEPS), pair).start(start).progress(advance).run()?;
    let seconds = began.elapsed().as_secs_f64();
    bar.finish_and_clear();

    let mut csv = csv_file(folder.join("map.csv"), "omega_1,load,state,ppv")?;
    for row in rows.iter() {
        csv.row(&[
            &row.point()["omega_1"],
            &row.point()["load"],
            &(row.contacts()[0].rattle_state().rsv()),
            &row.channel("q0")?.peak_to_peak(),
        ])?;
    }
    let evaluations = (SIDE * SIDE * 4 * STEPS * (SETTLE + MEASURE)) as f64;
    let mut alone = f64::INFINITY;
    for _ in 0..3 {
        alone = alone.min(scalar_run(&pair(&rows.points().point(SIDE * SIDE / 2))?)?);
    }
    let each = seconds / evaluations;
    println!("sweep: {:.3} ns per evaluation, {:.1} times as fast as a single run", 1e9 * each, alone / each);
    println!(
        "{} points in {seconds:.1} s on {} threads, {} errors",
        rows.iter().count(),
        rayon::current_num_threads(),
        rows.errors().len()
    );
    let share = |of: &dyn Fn(&Row<'_>) -> bool| {
        100.0 * rows.iter().filter(|row| of(row)).count() as f64 / (SIDE * SIDE) as f64
    };
    for state in [RattleState::None, RattleState::Unilateral, RattleState::Bilateral, RattleState::Floating] {
        println!("{state:10} {:5.1}% of the points", share(&|row| row.contacts()[0].rattle_state() == state));
    }
    println!("sensitive  {:5.1}% of the points: chaotic or grazing", share(&|row| row.is_sensitive()));

    let axes = ["pinion speed [rad/s]", "load torque [N m]"];
    let swing = |row: &Row<'_>| row.channel("deflection").map_or(f64::NAN, |x| x.peak_to_peak());
    let loss = |row: &Row<'_>| row.contacts()[0].loss_fraction();
    let kinds = ["repeats", "sensitive: chaotic or grazing"];
    let panels = [
        gear_dynamics_plots::rattle_map(&rows, axes, 0)?.title("rattle state of the only contact"),
        map(&rows, axes, "peak-to-peak deflection [m]", swing)?.title("deflection").logarithmic_colours()?,
        map(&rows, axes, "contact loss, share of the time [1]", loss)?.title("contact loss"),
        category_map(&rows, axes, &kinds, |row| Some(usize::from(row.is_sensitive())))?.title("sensitivity"),
    ];
    Ok(Picture::new(panels).columns(2).panel_size(480.0, 380.0).save(folder.join("map.svg"))?)
}
