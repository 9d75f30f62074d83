//! Figs. 11-15 of Liu 2021: rattle state and peak-to-peak values over speed, error, eccentricity, stiffness and
//! load.

use super::super::report::{Kind, Report};
use super::super::support::{Outcome, progress};
use super::motions::Point;
use super::sweeps::{BRANCHES, READINGS, SWEEPS, branches, follow, jumps, misses, onset, spans, trend};
use gear_dynamics_plots::{Mark, Panel};
use rayon::prelude::*;

/// The points of a sweep over its parameter; `None` if no orbit was found.
type Line = Vec<(f64, Option<Point>)>;

/// Indices of sweep, reading and branch.
type Case = (usize, usize, usize);

/// The peak-to-peak values of q and f(q) in the sweep upwards over the eccentricity, and the gap.
fn gap_and_elastic(report: &mut Report, all: &[(Case, Line)], sweep: usize) -> Outcome<()> {
    let mut rows = Vec::new();
    for eps in [0.1, 0.2, 0.3, 0.4] {
        let mut cells =
            vec![eps.to_string(), format!("{:.3e}", 2.0 * SWEEPS[sweep].pair(0, eps)?.half_backlash_angle())];
        for reading in 0..READINGS.len() {
            let of = all.iter().find(|(case, _)| *case == (sweep, reading, 0)).map(|(_, points)| points);
            let point = of.and_then(|points| points.iter().find(|(x, _)| *x == eps)).and_then(|(_, p)| *p);
            cells
                .push(point.map_or("no orbit".into(), |p| {
                    format!("{}, {:.3e} / {:.3e}", p.state, p.ppv, p.elastic)
                }));
        }
        rows.push(cells);
    }
    report.table("figure_13c", Kind::Full, &["ε", "gap 2b/L [rad]", "P", "published", "exact"], &rows);
    Ok(())
}

/// Figs. 11-15.
pub fn figures(report: &mut Report) -> Outcome<()> {
    let runs: Vec<Case> = (0..SWEEPS.len())
        .flat_map(|s| [2, 1, 0].into_iter().flat_map(move |r| (0..branches()).map(move |b| (s, r, b))))
        .collect();
    let bar = progress("sweeps", runs.iter().map(|&(s, r, _)| SWEEPS[s].intervals(r) + 1).sum());
    let points: Result<Vec<_>, String> = runs
        .par_iter()
        .map(|&(s, r, b)| {
            let sweep = &SWEEPS[s];
            let points = follow(sweep, r, b, || bar.inc(1))
                .map_err(|e| format!("{} sweep, {} {}: {e}", sweep.file, READINGS[r], BRANCHES[b]));
            points.map(|points| ((s, r, b), points))
        })
        .collect();
    bar.finish_and_clear();
    let all = points?;
    let of = |s: usize| (0..READINGS.len()).flat_map(move |r| (0..branches()).map(move |b| (s, r, b)));
    let points = |case: Case| all.iter().find(|(other, _)| *other == case).map(|(_, points)| points);
    let (mut states, mut onsets, mut trends, mut misfits) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (s, sweep) in SWEEPS.iter().enumerate() {
        for (s, r, b) in of(s) {
            let Some(points) = points((s, r, b)) else { continue };
            let name = || vec![sweep.title(), READINGS[r].to_owned(), BRANCHES[b].to_owned()];
            let mut row = name();
            row.push(spans(points, |p| p.state.to_string(), 5));
            row.push(if r == 0 { jumps(points) } else { spans(points, |p| p.stable.into(), 5) });
            states.push(row);
            if b == 0 {
                onsets.push([name(), onset(points)].concat());
                for (what, value) in [("q", (|p| p.ppv) as fn(&Point) -> f64), ("f(q)", |p| p.elastic)] {
                    let name = [sweep.title(), READINGS[r].to_owned(), what.to_owned()];
                    trends.push([&name[..], &trend(points, value)].concat());
                }
            }
        }
        if let (Some(p), Some(truth)) = (points((s, 0, 0)), points((s, 1, 0))) {
            misfits.push([vec![sweep.title()], misses(p, truth)].concat());
        }
    }
    let header = ["sweep", "reading", "direction", "rattle states", "jumps of P; stability of the others"];
    report.table("sweep_states", Kind::Full, &header, &states);
    let header = ["sweep", "reading", "direction", "bilateral between", "growth of q", "growth of f(q)"];
    report.table("sweep_onsets", Kind::Full, &header, &onsets);
    let header = ["sweep upwards", "reading", "ppv of", "none", "unilateral", "bilateral"];
    report.table("sweep_trends", Kind::Full, &header, &trends);
    let header =
        ["sweep upwards", "points with one state", "P off where both have one state", "P off at most"];
    report.table("sweep_misfits", Kind::Full, &header, &misfits);
    for file in ["speed", "load", "error", "eccentricity", "stiffness", "circular"] {
        let members = || SWEEPS.iter().enumerate().filter(|(_, sweep)| sweep.file == file);
        let Some((first, sweep)) = members().next() else { continue };
        let header = format!("reading,branch,{},state,ppv,elastic_ppv,stable,omega_1", sweep.parameter);
        report.csv(&format!("{file}.csv"), &header, |csv| {
            for (s, sweep) in members() {
                for (_, r, b) in of(s) {
                    for (x, point) in points((s, r, b)).into_iter().flatten() {
                        let Some(p) = point else { continue };
                        let (state, speed) = (p.state.rsv(), sweep.speed_at(*x));
                        #[rustfmt::skip]
                        csv.row(&[&READINGS[r], &BRANCHES[b], x, &state, &p.ppv, &p.elastic, &p.stable, &speed])?;
                    }
                }
            }
            Ok(())
        });
        if file == "eccentricity" {
            gap_and_elastic(report, &all, first)?;
        }
        let mut panels = Vec::new();
        for (s, sweep) in members() {
            let title = sweep.title();
            for (what, axis, value) in [
                (
                    "0 none, 1 unilateral, 2 bilateral",
                    "rattle state [1]",
                    (|p| f64::from(p.state.rsv())) as fn(&Point) -> f64,
                ),
                ("peak-to-peak of q", "peak-to-peak of q [rad]", |p| p.ppv),
                ("peak-to-peak of f(q)", "peak-to-peak of f(q) [rad]", |p| p.elastic),
            ] {
                let mut panel = Panel::new(format!("{title}: {what}"), sweep.axis, axis)?;
                for (_, r, b) in of(s) {
                    let curve = points((s, r, b)).into_iter().flatten();
                    let curve: Vec<_> =
                        curve.filter_map(|(x, p)| p.as_ref().map(|p| (*x, value(p)))).collect();
                    let mark = if r == 0 { Mark::Line } else { Mark::Dots };
                    if !curve.is_empty() {
                        panel = panel.series(&format!("{} {}", READINGS[r], BRANCHES[b]), mark, curve)?;
                    }
                }
                panels.push(panel);
            }
        }
        let file = format!("{}_{file}.svg", sweep.figure[..7].replace(". ", "").to_lowercase());
        report.picture(&file, 3, panels);
    }
    Ok(())
}
