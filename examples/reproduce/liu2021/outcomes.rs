//! Which motions exist beside those of the sweeps: the face gear pair of Liu 2021 from random starts.

use super::super::report::{Kind, Report};
use super::super::support::{Outcome, coarse, progress};
use super::motions::{Motion, Point, converged, on_cycle, settled};
use gear_dynamics::models::nfg::NfgReading;
use gear_dynamics::processes::HeldProcess;
use gear_dynamics::{NfgPair, NfgParams, RattleState, State};
use rand_distr::Uniform;
use rayon::prelude::*;
use std::collections::BTreeMap;

type Reading = (&'static str, fn() -> NfgReading);
const READINGS: [Reading; 2] = [("published", NfgReading::published), ("exact", NfgReading::exact)];

/// Eccentric ratio, speed [rad/s], random starts in a full run.
const CASES: [(f64, f64, u64); 7] = [
    (0.2, 140.0, 20),
    (0.2, 160.0, 20),
    (0.2, 180.0, 20),
    (0.0, 160.0, 60),
    (0.0, 200.0, 60),
    (0.0, 205.0, 60),
    (0.0, 207.5, 60),
];

fn pair(reading: Reading, speed: f64, eccentric_ratio: f64) -> Outcome<NfgPair> {
    Ok(NfgPair::of_reading(&NfgParams { speed, eccentric_ratio, ..NfgParams::table1() }, reading.1())?)
}

/// Start `k`: the deflection within the gap and half of it more on each side, the velocity up to half the gap per
/// unit of dimensionless time.
fn start(pair: &NfgPair, draws: &HeldProcess, k: u64) -> State {
    let b = pair.half_backlash_angle();
    State::new(0.0, &[2.0 * b * draws.held(0, k)], &[b * draws.held(1, k)])
}

/// The motion from a start: its state, number of turns and peak-to-peak values.
fn motion(pair: &NfgPair, start: &State) -> Outcome<String> {
    let (_, cycle) = settled(pair, start)?;
    let Some(cycle) = cycle else { return Ok("no period".into()) };
    let point = on_cycle(pair, &cycle)?;
    Ok(format!("{} {}, {:.3e} / {:.3e}", point.state, turns(cycle.turns()), point.ppv, point.elastic))
}

fn turns(count: usize) -> String {
    if count == 1 { "of 1 turn".into() } else { format!("of {count} turns") }
}

/// Motions from random starts, and the large unilateral motion of the circular gear over the speed.
pub fn figures(report: &mut Report) -> Outcome<()> {
    let draws = HeldProcess::new(1.0, Uniform::new(-1.0, 1.0)?)?.seed(2021);
    let shown = if coarse() { &CASES[3..4] } else { &CASES[..] };
    let cases: Vec<_> = shown
        .iter()
        .flat_map(|case| READINGS.iter().map(move |reading| (*case, *reading)))
        .map(|((eps, speed, starts), reading)| (eps, speed, if coarse() { 4 } else { starts }, reading))
        .collect();
    let bar = progress("random starts", cases.iter().map(|case| case.2 as usize).sum());
    let mut rows = Vec::new();
    for (eps, speed, starts, reading) in cases {
        let pair = pair(reading, speed, eps)?;
        let found: Result<Vec<String>, String> = (0..starts)
            .into_par_iter()
            .map(|k| {
                let found = motion(&pair, &start(&pair, &draws, k));
                bar.inc(1);
                found.map_err(|e| format!("{} rad/s, start {k}: {e}", pair.speed()))
            })
            .collect();
        let mut counts = BTreeMap::new();
        found?.into_iter().for_each(|name| *counts.entry(name).or_insert(0) += 1);
        let mut counts: Vec<(String, u64)> = counts.into_iter().collect();
        counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let list: Vec<String> = counts.iter().map(|(name, count)| format!("{name}: {count}")).collect();
        rows.push(vec![
            eps.to_string(),
            format!("{speed} rad/s"),
            reading.0.into(),
            starts.to_string(),
            list.join("; "),
        ]);
    }
    bar.finish_and_clear();
    let header =
        ["ε", "speed", "reading", "starts", "stable orbits, ppv of q / of f(q) [rad]: starts that end there"];
    report.table("motions_from_random_starts", Kind::Full, &header, &rows);
    if coarse() {
        return Ok(());
    }

    let rows: Result<Vec<_>, String> = READINGS
        .par_iter()
        .map(|reading| {
            large_motion(*reading, &draws).map_err(|e| format!("large motion, {}: {e}", reading.0))
        })
        .collect();
    let header = ["reading", "large unilateral motion between", "ppv of q", "ppv of f(q)"];
    report.table("large_motion_of_the_circular_gear", Kind::Full, &header, &rows?);
    Ok(())
}

/// Follows the large unilateral motion of the circular gear from 205 rad/s in steps of 2.5 rad/s both ways, until a run
/// leaves it.
fn large_motion(reading: Reading, draws: &HeldProcess) -> Outcome<Vec<String>> {
    const FROM: f64 = 205.0;
    const STEP: f64 = 2.5;
    let is_large = |pair: &NfgPair, p: &Point| {
        p.state == RattleState::Unilateral && p.stable == "stable" && p.ppv > 0.5 * pair.half_backlash_angle()
    };
    let at = pair(reading, FROM, 0.0)?;
    let mut first = None;
    for k in 0..60 {
        let (_, Some(cycle)) = settled(&at, &start(&at, draws, k))? else { continue };
        let point = on_cycle(&at, &cycle)?;
        if is_large(&at, &point) {
            first = Some((Motion { start: cycle.start().clone(), cycle: Some(cycle), speed: FROM }, point));
            break;
        }
    }
    let Some((from, point)) = first else {
        return Ok([reading.0, "not found", "-", "-"].map(str::to_owned).into());
    };
    let mut ends = Vec::new();
    for step in [-STEP, STEP] {
        let (mut last, mut carried) = ((FROM, point), None);
        for i in 1.. {
            let speed = FROM + step * f64::from(i);
            if !(100.0..=250.0).contains(&speed) {
                break;
            }
            let pair = pair(reading, speed, 0.0)?;
            let (next, point) = converged(&pair, Some(carried.as_ref().unwrap_or(&from)))?;
            if !is_large(&pair, &point) {
                break;
            }
            (last, carried) = ((speed, point), Some(next));
        }
        ends.push(last);
    }
    let ([(a, low), (b, high)], name) = (<[_; 2]>::try_from(ends).map_err(|_| "two ends")?, reading.0);
    Ok(vec![
        name.into(),
        format!("{a} and {b} rad/s"),
        format!("{:.3e} to {:.3e}", low.ppv, high.ppv),
        format!("{:.3e} to {:.3e}", low.elastic, high.elastic),
    ])
}
