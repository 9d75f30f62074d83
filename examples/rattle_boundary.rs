//! Onset of contact loss of the face gear pair of Liu 2021 over speed and load (reading A of docs/models.md),
//! over a map of rattle states.
//!
//! At the nominal load, a continuation over the speed locates the grazing at which teeth separate first. Over
//! speed and load the onset is then followed as a boundary. The largest deflection within a turn occurs at
//! another tooth from speed to speed: the boundary consists of pieces, one for each tooth. The output compares
//! twenty of its points with integrations in time.
//!
//! The onset of back contact is no such boundary: below the orbits of period one that touch both flanks, the
//! motion is chaotic. The period doubling at which they become unstable is followed instead.
//!
//! The picture shows the onset and the period doubling over rattle states and contact loss;
//! `boundary.csv` and `map.csv` contain the numbers.
//!
//! `cargo run --release -p examples --example rattle_boundary`, with `-- --coarse` for a part of the speeds
//! and fewer points of the map; everything is written to target/gallery/rattle_boundary/.

mod support;

use gear_dynamics::branches::{BranchPoint, Continuation, Family, PointKind};
use gear_dynamics::models::nfg::NfgReading;
use gear_dynamics::sweep::{Axis, LaneRk4, Point, Points, Row, Rows, Watch};
use gear_dynamics::{
    Dop853, Integrator, NfgPair, NfgParams, ParameterError, Periodic, RattleState, Settle, Shooting, State,
    Statistics, Sweep,
};
use gear_dynamics_plots::{Mark, Picture, map};
use std::time::Instant;
use support::{Outcome, coarse, csv_file, gallery, progress};

/// The onset of contact loss at one speed.
struct Onset {
    /// Pinion speed [rad/s].
    speed: f64,
    /// Load torque [N m] below which teeth separate.
    load: f64,
    /// Number of the piece of the boundary, from 1.
    piece: usize,
    /// The grazing orbit.
    point: BranchPoint,
}

/// The pair at 100 rad/s.
fn pair() -> Result<NfgPair, ParameterError> {
    let params = NfgParams { speed: 100.0, ..NfgParams::table1() };
    NfgPair::of_reading(&params, NfgReading::published_on_base_radius())
}

/// Without contact loss the pair is linear and its orbits are stable: one segment is enough. The tolerances
/// are a hundred times smaller than the differences to be shown.
fn shooting() -> Shooting {
    Shooting::new().segments(1).tolerance(1e-9).flow_tolerance(1e-11)
}

/// The first contact loss along a continuation over a constant from the value of `pair` to `to`.
fn first_loss(pair: &NfgPair, constant: &str, to: f64) -> Outcome<BranchPoint> {
    let family = Family::over(pair, [constant])?;
    let continuation =
        Continuation::new(pair.constant(constant)?, to).first_step(0.1).max_step(0.3).shooting(shooting());
    let mut following = continuation.begin(&family, &[pair.on_drive_flank()?])?;
    let loss = |point: &BranchPoint| point.located.is_some_and(|what| what.changes_rattle());
    following.find(loss).ok_or_else(|| format!("no contact loss: {}", following.line()).into())
}

/// The onset at the next speed on the same piece of the boundary. `None`: another tooth separates at a higher
/// load.
fn along(pair: &NfgPair, onset: &Onset, speed: f64) -> Outcome<Option<Onset>> {
    let plane = Family::over(pair, ["load torque", "speed"])?;
    let range = Continuation::new(onset.speed, speed).first_step(2.0).max_step(2.0).max_points(4);
    let line = range.bounds_across(1.0, 200.0).shooting(shooting()).run(&plane, &onset.point)?;
    let Some(last) = line.points().last().filter(|last| (last.parameters[1] - speed).abs() < 1e-9) else {
        return Ok(None);
    };
    let load = last.parameters[0];
    let pair = pair.with("speed", speed)?.with("load torque", load)?;
    let mut statistics = Statistics::new(&pair, &["q0"])?;
    last.orbit.observe(&pair, &mut statistics)?;
    let q = statistics.summary("q0")?;
    let separated = distance(&pair, q.max) > 1e-7 * q.peak_to_peak();
    let point = BranchPoint {
        parameter: load,
        multipliers: last.multipliers.clone(),
        orbit: last.orbit.clone(),
        ..onset.point.clone()
    };
    Ok((!separated).then_some(Onset { speed, load, piece: onset.piece, point }))
}

/// The onset at all speeds. The load at the first speed is at most `load` [N m].
fn boundary(pair: &NfgPair, speeds: &[f64], load: f64) -> Outcome<Vec<Onset>> {
    let bar = progress("boundary", speeds.len());
    let mut onsets: Vec<Onset> = Vec::new();
    for speed in speeds.iter().copied() {
        let next = match onsets.last() {
            Some(onset) => along(pair, onset, speed)?,
            None => None,
        };
        let next = match next {
            Some(next) => next,
            None => {
                // A new piece. At the higher load all teeth stay in contact.
                let (above, piece) =
                    onsets.last().map_or((load, 1), |last| (1.4 * last.load, last.piece + 1));
                let point =
                    first_loss(&pair.with("speed", speed)?.with("load torque", above)?, "load torque", 1.0)?;
                Onset { speed, load: point.parameter, piece, point }
            }
        };
        onsets.push(next);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(onsets)
}

/// Largest distance from the edge [rad] of an orbit with the maximum `max` of q: 0 where a tooth grazes its
/// edge, positive where teeth separate.
fn distance(pair: &NfgPair, max: f64) -> f64 {
    max + pair.half_backlash_angle()
}

/// The onset load at a speed by integration in time: the secant method on the largest q + b/L of a settled
/// turn, from loads at which teeth stay in contact.
fn onset_in_time(pair: &NfgPair, guess: f64) -> Outcome<f64> {
    let solver = Dop853::new().rtol(1e-12).atol_each(&[1e-17, 1e-17]);
    let largest = |load: f64| -> Outcome<f64> {
        let pair = pair.with("load torque", load)?;
        let settled = Settle::new().run(&solver, &pair, &pair.on_drive_flank()?)?.state;
        let mut statistics = Statistics::new(&pair, &["q0"])?;
        solver.run(&pair, &settled, settled.t + pair.period(), &mut statistics)?;
        Ok(distance(&pair, statistics.summary("q0")?.max))
    };
    let (mut a, mut b) = (1.02 * guess, 1.01 * guess);
    let (mut at_a, mut at_b) = (largest(a)?, largest(b)?);
    for _ in 0..20 {
        let c = b - at_b * (b - a) / (at_b - at_a);
        (a, at_a, b) = (b, at_b, c);
        if (b - a).abs() < 1e-9 * b {
            break;
        }
        at_b = largest(b)?;
    }
    Ok(b)
}

/// The speed below which the orbit of one turn that touches both flanks is unstable, over the load.
///
/// Below it the motion is chaotic and touches the back flank in bursts: the onset of back contact is no
/// point of a branch of periodic orbits.
fn end_of_regular_rattle(pair: &NfgPair) -> Outcome<Vec<(f64, f64)>> {
    let fast = pair.with("speed", 175.0)?;
    let settled = Dop853::new().end(&fast, &fast.on_drive_flank()?, 30.0 * fast.period())?;
    let shooting = shooting().segments(8);
    let family = Family::over(&fast, ["speed"])?;
    let range = Continuation::new(175.0, 155.0).shooting(shooting.clone());
    let mut following = range.begin(&family, &[State { t: 0.0, ..settled }])?;
    let Some(doubling) = following.find(|point| point.kind() == Some(PointKind::PeriodDoubling)) else {
        return Err(format!("no period doubling: {}", following.line()).into());
    };
    println!("rattle on both flanks of period one is stable from {:.6} rad/s upwards", doubling.parameter);
    if coarse() {
        return Ok(Vec::new());
    }
    let plane = Family::over(pair, ["speed", "load torque"])?;
    let range = Continuation::new(30.0, 40.0).both_ways().bounds(10.0, 60.0).bounds_across(100.0, 170.0);
    let line =
        range.first_step(0.1).max_step(0.3).max_points(24).shooting(shooting).run(&plane, &doubling)?;
    println!("its boundary has {} points; {}", line.points().len(), line.end());
    Ok(line.points().iter().map(|point| (point.parameters[0], point.parameters[1])).collect())
}

/// Rattle states over speed and load in lanes: 20 turns to settle, 10 turns measured.
fn rattle_map(pair: &NfgPair, speeds: [f64; 2], loads: [f64; 2], side: usize) -> Outcome<Rows> {
    let points = Points::grid(vec![
        Axis::linear("speed", speeds[0], speeds[1], side)?,
        Axis::linear("load", loads[0], loads[1], side)?,
    ])?;
    let sweep = Sweep::new(points).periodic_tolerance(5e-3).settle(20).measure(10).rattle();
    let bar = progress("map", side * side);
    let advance = |done: usize, _: usize| bar.set_position(done as u64);
    let model = |p: &Point<'_>| pair.with("speed", p["speed"])?.with("load torque", p["load"]);
    let start = |_: &Point<'_>, pair: &NfgPair| pair.on_drive_flank();
    // 64 steps per mesh period.
    let engine = LaneRk4::new(63 * 64);
    let rows = sweep.of(&engine, model).start(start).watch(Watch::new().progress(advance)).run()?;
    bar.finish_and_clear();
    Ok(rows)
}

pub(crate) fn main() -> Outcome<()> {
    let folder = gallery("rattle_boundary")?;
    let pair = pair()?;
    let nominal = first_loss(&pair, "speed", 148.0)?.parameter;
    println!("contact is first lost at {nominal:.8} rad/s at the nominal load of 30 N m");

    let began = Instant::now();
    let (ends, step) = if coarse() { ([130.0, 135.0], 0.25) } else { ([100.0, 170.0], 0.5) };
    let count = ((ends[1] - ends[0]) / step) as usize;
    let speeds: Vec<f64> = (0..=count).map(|i| ends[0] + step * i as f64).collect();
    let onsets = boundary(&pair, &speeds, 60.0)?;
    let pieces = onsets.last().map_or(0, |onset| onset.piece);
    let seconds = began.elapsed().as_secs_f64();
    println!(
        "onset from {} to {} rad/s: {} points in {pieces} pieces, {seconds:.1} s",
        ends[0],
        ends[1],
        onsets.len()
    );
    let mut csv = csv_file(folder.join("boundary.csv"), "speed,onset_load,piece")?;
    for onset in &onsets {
        csv.row(&[&onset.speed, &onset.load, &onset.piece])?;
    }
    csv.finish()?;

    let began = Instant::now();
    println!("\n  speed [rad/s]  onset load [N m]  integrated in time  relative difference");
    let mut worst = 0.0f64;
    for k in 0..20 {
        let Onset { speed, load, .. } = &onsets[k * (onsets.len() - 1) / 19];
        let in_time = onset_in_time(&pair.with("speed", *speed)?, *load)?;
        let off = (load / in_time - 1.0).abs();
        worst = worst.max(off);
        println!("{speed:15.2} {load:17.10} {in_time:19.10} {off:20.1e}");
    }
    println!("largest difference {worst:.1e}, {:.1} s\n", began.elapsed().as_secs_f64());

    let began = Instant::now();
    let doubling = end_of_regular_rattle(&pair)?;
    println!("{:.1} s\n", began.elapsed().as_secs_f64());

    let (side, [low, high]) = (if coarse() { 24 } else { 140 }, [10.0, 60.0]);
    let began = Instant::now();
    let rows = rattle_map(&pair, ends, [low, high], side)?;
    println!("{side} x {side} points of the map in {:.1} s", began.elapsed().as_secs_f64());
    let mut csv = csv_file(folder.join("map.csv"), "speed,load,state")?;
    let (mut wrong, mut near) = (0, 0);
    for row in rows.iter() {
        let [speed, load] = [row.point()["speed"], row.point()["load"]];
        csv.row(&[&speed, &load, &row.contacts()[0].rattle_state().rsv()])?;
        let i = (((speed - ends[0]) / step) as usize).min(onsets.len() - 2);
        let [a, b] = [&onsets[i], &onsets[i + 1]];
        let onset = a.load + (speed - a.speed) / (b.speed - a.speed) * (b.load - a.load);
        let differs = (load < onset) != (row.contacts()[0].rattle_state() != RattleState::None);
        if (load / onset - 1.0).abs() < 0.02 {
            near += 1;
        } else if differs {
            wrong += 1;
        }
    }
    csv.finish()?;
    println!("{wrong} of them contradict the onset; {near} points closer than 2 % to it are not compared");
    let axes = ["pinion speed [rad/s]", "load torque [N m]"];
    let loss = |row: &Row<'_>| row.contacts()[0].loss_fraction();
    let mut panels = Vec::new();
    for panel in [
        gear_dynamics_plots::rattle_map(&rows, axes, None)?.title("rattle state"),
        map(&rows, axes, "contact loss, share of the time [1]", loss)?.title("contact loss"),
    ] {
        let mut panel = panel.x_range(ends[0], ends[1])?.y_range(low, high)?;
        for piece in onsets.chunk_by(|a, b| a.piece == b.piece) {
            let line = piece.iter().map(|onset| (onset.speed, onset.load));
            panel = panel.series("onset of contact loss", Mark::Line, line)?;
        }
        if !doubling.is_empty() {
            panel = panel.series("period doubling", Mark::Line, doubling.iter().copied())?;
        }
        panels.push(panel);
    }
    Picture::new(panels).columns(2).panel_size(480.0, 380.0).save(folder.join("boundary.svg"))?;
    println!("picture and tables: {}", folder.display());
    Ok(())
}
