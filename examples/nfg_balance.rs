//! Figs. 8-15, 17, 18 and Table 2 of Liu 2021: the harmonic balance of Liu 2021 compared with converged
//! motions.
//!
//! - *P*: the balance of Liu 2021, with 15 unknowns, M = 1024 samples, and the force truncated to the kept
//!   orders before it is multiplied by the stiffness;
//! - *published*: converged motions of the same equations;
//! - *exact*: converged motions of the corrected equations.
//!
//! Converged motions are orbits polished by shooting, for Figs. 8-10 after a balance with many orders. If no
//! stable orbit is found, the statistics are those of a run in time, marked `aperiodic`. Sweeps begin each
//! point at the result of the previous one, upwards and downwards. The tables, pictures and CSV files show
//! rattle state and peak-to-peak values of q and of its elastic part f(q), which does not contain the gap.
//!
//! `cargo run --release -p examples --example nfg_balance`, with `-- --coarse` for one sixth of the points;
//! everything is written to target/gallery/nfg_balance/.

mod nfg_balance {
    pub mod motions;
    pub mod sweeps;
}
mod support;

use gear_dynamics::contact::Piece;
use gear_dynamics::drives::HeldProcess;
use gear_dynamics::excitation::Fourier;
use gear_dynamics::models::nfg::NfgReading;
use gear_dynamics::ode::uniform_times;
use gear_dynamics::periodic::{BalanceError, FourierOrbit, Integrals};
use gear_dynamics::{Balance, Harmonics, Integrator, NfgPair, NfgParams, Periodic, RattleState};
use nfg_balance::motions::{
    ELASTIC, MEASURE, MESH, Point, SETTLE, at_rest, broyden, converged, on_cycle, pair, paper, paper_orbit,
    paper_point, run, shooting, solver,
};
use nfg_balance::sweeps::{BRANCHES, READINGS, SWEEPS, follow, jumps, misses, onset, spans, trend};
use plotters::prelude::SeriesLabelPosition;
use rand_distr::Uniform;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::path::Path;
use support::{Mark, Outcome, Panel, coarse, csv_file, figure, gallery, progress};

/// Motor speed [r/min]; A_c, A_e and ξ of the theory; f_c [Hz], f_e [Hz] and ξ of the experiment. The printed
/// headers of A_c and A_e are swapped.   Source: Liu 2021, Table 2.
#[rustfmt::skip]
const TABLE2: [[f64; 7]; 9] = [
    [ 280.0, 0.53,  25.91, 48.6, 1.0,  65.4, 34.2],
    [ 392.0, 0.75,  36.43, 48.8, 1.5,  91.7, 39.7],
    [ 504.0, 0.96,  47.18, 49.1, 1.9, 116.2, 76.3],
    [ 616.0, 1.18,  58.38, 49.7, 2.3, 141.2, 54.0],
    [ 728.0, 1.39,  70.33, 50.5, 2.7, 170.1, 50.3],
    [ 840.0, 1.61,  83.45, 51.8, 3.2, 194.0, 52.7],
    [ 952.0, 1.83,  98.27, 53.6, 3.6, 215.2, 61.3],
    [1064.0, 2.06, 115.4,  56.0, 4.0, 241.0, 50.7],
    [1176.0, 2.29, 135.5,  59.1, 4.4, 267.9, 65.4],
];
/// Ratio of the belt from the motor to the pinion.
const BELT: f64 = 1.3;

/// Time history, phase portrait and order spectrum of one turn, as in Figs. 8-10.
fn portrait(title: &str, orbits: &[(&str, &FourierOrbit)]) -> Outcome<[Panel; 3]> {
    const SAMPLES: usize = 4096;
    let mut history = Panel::new(title, "turns of the face gear", "q [rad]");
    let mut phase = Panel::new("phase portrait", "q [rad]", "dq/dτ [rad]");
    let mut spectrum = Panel::new("spectrum", "order of the face gear", "amplitude [rad]")
        .labels_at(SeriesLabelPosition::UpperRight);
    for (name, orbit) in orbits {
        let turn = orbit.history(SAMPLES)?;
        let points = (0..SAMPLES).map(|i| (i as f64 / SAMPLES as f64, turn.q(i)[0])).collect();
        history = history.with("", Mark::Line, points);
        phase = phase.with("", Mark::Line, (0..SAMPLES).map(|i| (turn.q(i)[0], turn.v(i)[0])).collect());
        let lines = orbit
            .harmonics()
            .orders()
            .iter()
            .filter(|&&k| k > 0 && k <= 260)
            .map(|&k| (k as f64, orbit.amplitude(0, k)));
        spectrum = spectrum.with(
            *name,
            if name.starts_with('P') { Mark::Dots } else { Mark::Bars },
            lines.collect(),
        );
    }
    Ok([history, phase, spectrum])
}

/// One turn of the converged motion as a series, its point, and how it was found.
fn converged_turn(pair: &NfgPair) -> Outcome<(FourierOrbit, Point, String)> {
    let many = Harmonics::up_to(1000);
    let (motion, point) = converged(pair, None)?;
    let turn = FourierOrbit::project(&solver(), pair, &motion.start, &many)?;
    if motion.cycle.is_none() {
        return Ok((
            turn,
            point,
            format!("no stable orbit after {SETTLE} turns: run of {MEASURE} more turns"),
        ));
    }
    let balance = Balance::new(Harmonics::up_to(600));
    let proof = balance.solve_to(pair, &turn, 2e-3, 1400)?;
    let Some(cycle) = &proof.polished else {
        return Ok((turn, point, "settled in time".into()));
    };
    let how =
        format!("balance to {:.0e}, first shooting correction {:.0e}", proof.truncation, proof.shooting);
    Ok((FourierOrbit::project(&solver(), pair, &cycle.states()[0], &many)?, on_cycle(pair, cycle)?, how))
}

fn figures_8_to_10(folder: &Path) -> Outcome<()> {
    println!(
        "Figs. 8-10: 15 unknowns (P) and converged motions; Liu 2021: none, unilateral, bilateral. \
         Peak-to-peak of q, f(q) [rad]\n"
    );
    println!(
        "{:>5}  {:32} {:>13} {:>7}  {:32} {:>8}  {:32}  published by",
        "rad/s", "P", "Broyden from", "Newton", "published", "P is off", "exact"
    );
    let mut panels = Vec::new();
    for speed in [140.0, 160.0, 180.0] {
        let params = NfgParams { speed, ..NfgParams::table1() };
        let pair = pair(&params)?;
        let flank = paper()?.linearised(&pair, Piece::Lower)?;
        let newton = paper()?
            .solve_truncating_forces(&pair, &flank)
            .map_or("fails".into(), |orbit| orbit.iterations().to_string());
        let (from, orbit) = match broyden()?.solve_truncating_forces(&pair, &at_rest(&pair)?) {
            Ok(orbit) => ("rest", orbit),
            // Beyond the fold only the guess from a run in time converges.
            Err(BalanceError::NotConverged { .. }) => {
                ("run", broyden()?.solve_truncating_forces(&pair, &run(&pair)?)?)
            }
            Err(error) => return Err(error.into()),
        };
        let p = paper_point(&pair, &orbit)?;
        let (truth, point, how) = converged_turn(&pair)?;
        let (_, exact) = converged(&NfgPair::with_reading(&params, NfgReading::exact())?, None)?;
        let show = |p: &Point| format!("{:10} {:.4e} {:.3e}", p.state.to_string(), p.ppv, p.elastic);
        println!(
            "{speed:5}  {:32} {:>13} {newton:>7}  {:32} {:7.0}%  {:32}  {how}",
            show(&p),
            format!("{} ({from})", orbit.iterations()),
            show(&point),
            100.0 * orbit.distance(&truth) * p.ppv / point.ppv,
            show(&exact)
        );
        for note in orbit.notes() {
            println!("       P: {note}");
        }
        let title = format!("{speed} rad/s: P {}, published {} ({})", p.state, point.state, point.stable);
        panels.extend(portrait(&title, &[("published", &truth), ("P", &orbit)])?);
    }
    figure(folder.join("fig8_10.svg"), 3, &panels)
}

/// Prints the roots of the balance P at one speed, found from many starts: turns of runs in time at this and
/// higher speeds projected on the 15 unknowns, random coefficients within the half width of the gap, and
/// random changes of the coefficients of the roots already found.
fn roots_of_p(speed: f64) -> Outcome<()> {
    const TURNS: usize = 6;
    const SHIFTED: u64 = 40;
    let starts_drawn: u64 = if coarse() { 60 } else { 600 };
    let pair = pair_at(speed)?;
    let (newton, broyden) = (paper()?, broyden()?);
    let orbit_of =
        |coefficients: Vec<f64>| FourierOrbit::new(newton.harmonics(), pair.period(), &[coefficients]);
    let mut starts = Vec::new();
    for other in [0.0, 10.0, 20.0, 30.0, 40.0, 50.0].map(|more| pair_at(speed + more)) {
        let other = other?;
        let mut state = other.static_start()?;
        for _ in 0..TURNS {
            let seen = FourierOrbit::project(&solver(), &other, &state, newton.harmonics())?;
            starts.push(orbit_of(seen.coefficients(0).to_vec())?);
            state = solver().end(&other, &state, state.t + other.period())?;
        }
    }
    let draws = HeldProcess::new(1.0, Uniform::new(-1.0, 1.0)?)?.seed(2021);
    for k in 0..starts_drawn {
        let drawn = (0..newton.harmonics().unknowns()).map(|i| pair.half_width() * draws.held(i as u64, k));
        starts.push(orbit_of(drawn.collect())?);
    }
    let solved = |start: &FourierOrbit| {
        [&newton, &broyden]
            .into_iter()
            .filter_map(|way| way.solve_truncating_forces(&pair, start).ok())
            .collect()
    };
    let (mut roots, mut count): (Vec<(Point, FourierOrbit)>, usize) = (Vec::new(), 0);
    // New roots give further starts, until no root is new.
    while !starts.is_empty() {
        count += starts.len();
        let found: Vec<Vec<FourierOrbit>> = starts.par_iter().map(solved).collect();
        starts.clear();
        for orbit in found.into_iter().flatten() {
            if roots.iter().any(|(_, known)| known.distance(&orbit) < 1e-3) {
                continue;
            }
            for k in 0..SHIFTED {
                let k = starts_drawn + SHIFTED * roots.len() as u64 + k;
                let shifted = orbit
                    .coefficients(0)
                    .iter()
                    .enumerate()
                    .map(|(i, c)| c * (1.0 + 0.5 * draws.held(i as u64, k)));
                starts.push(orbit_of(shifted.collect())?);
            }
            roots.push((paper_point(&pair, &orbit)?, orbit));
        }
    }
    println!("\nRoots of P at {speed} rad/s by Newton and Broyden from {count} starts:");
    for wanted in [RattleState::None, RattleState::Unilateral, RattleState::Bilateral] {
        let of = |value: fn(&Point) -> f64| {
            let values = roots.iter().filter(|r| r.0.state == wanted).map(|r| value(&r.0));
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], x| [lo.min(x), hi.max(x)])
        };
        let count = roots.iter().filter(|r| r.0.state == wanted).count();
        if count > 0 {
            let ([q0, q1], [f0, f1]) = (of(|p| p.ppv), of(|p| p.elastic));
            println!(
                "  {count:2} {wanted}: peak-to-peak of q {q0:.3e} .. {q1:.3e}, of f(q) {f0:.3e} .. \
                 {f1:.3e} rad"
            );
        }
    }
    Ok(())
}

fn pair_at(speed: f64) -> Outcome<NfgPair> {
    pair(&NfgParams { speed, ..NfgParams::table1() })
}

/// Prints for several numbers of samples at which load P first loses contact, and where the branch ends or
/// touches the back flank: from 25 N m downwards at 125 rad/s.
fn load_limits_of_p() -> Outcome<()> {
    const STEP: f64 = 0.01;
    println!("\nP over the load at 125 rad/s, downwards from 25 N m in steps of {STEP} N m:");
    let lines: Result<Vec<String>, String> = [512, 1024, 2048, 16_384]
        .par_iter()
        .map(|&samples| {
            let limits = || -> Outcome<(f64, f64, &str)> {
                let balance =
                    Balance::new(Harmonics::bands(MESH, 1, 2)?).integrals(Integrals::Sampled { samples });
                let at = |i: u32| {
                    pair(&NfgParams {
                        speed: 125.0,
                        load_torque: 25.0 - STEP * f64::from(i),
                        ..NfgParams::table1()
                    })
                };
                let mut orbit = balance.linearised(&at(0)?, Piece::Lower)?;
                let mut lost = None;
                for i in 0.. {
                    let pair = at(i)?;
                    let load = pair.constant("load torque")?;
                    let Ok(next) = balance.solve_truncating_forces(&pair, &orbit) else {
                        return Ok((lost.unwrap_or(f64::NAN), load + STEP, "ends"));
                    };
                    match next.contacts(&pair)?[0].statistics.rattle_state() {
                        RattleState::Bilateral => {
                            return Ok((lost.unwrap_or(f64::NAN), load + STEP, "reaches the back flank"));
                        }
                        RattleState::None => {}
                        _ => lost = lost.or(Some(load)),
                    }
                    orbit = next;
                }
                Err("the branch does not end".into())
            };
            let (lost, end, how) = limits().map_err(|e| format!("{samples} samples: {e}"))?;
            Ok(format!(
                "  {samples:5} samples: contact lost from {lost:.2} N m on, the branch {how} at {end:.2} N m"
            ))
        })
        .collect();
    lines?.iter().for_each(|line| println!("{line}"));
    Ok(())
}

/// Table 2 at one speed: the orbits of P and of the published equations; amplitudes of f(q) at the centre and
/// the mesh order for P, published and exact.
struct Lines {
    hertz: f64,
    orbits: [FourierOrbit; 2],
    amplitudes: [[f64; 2]; 3],
}

fn table2_lines(rpm: f64) -> Outcome<Lines> {
    const SAMPLES: usize = 8192;
    let params = NfgParams { speed: rpm * TAU / 60.0 / BELT, ..NfgParams::table1() };
    let pair = pair(&params)?;
    let balance = paper()?;
    let p = balance.solve_truncating_forces(&pair, &balance.linearised(&pair, Piece::Lower)?)?;
    let orbit_of = |pair: &NfgPair| -> Outcome<(FourierOrbit, [f64; 2])> {
        let cycle = shooting().solve(pair, &[pair.static_start()?])?;
        let start = &cycle.states()[0];
        let turn = solver().sample(pair, start, &uniform_times(0.0, pair.period(), SAMPLES)?)?;
        let series = Fourier::fit(&turn.channel(pair, ELASTIC)?, MESH)?;
        let amplitude = |order: usize| series.pairs()[order - 1][0].hypot(series.pairs()[order - 1][1]);
        Ok((
            FourierOrbit::project(&solver(), pair, start, &Harmonics::up_to(260))?,
            [amplitude(1), amplitude(MESH)],
        ))
    };
    let (published, of_published) = orbit_of(&pair)?;
    let (_, of_exact) = orbit_of(&NfgPair::with_reading(&params, NfgReading::exact())?)?;
    // Without rattle and with a constant half width q and f(q) differ by a constant only.
    let amplitudes = [[p.amplitude(0, 1), p.amplitude(0, MESH)], of_published, of_exact];
    Ok(Lines { hertz: rpm / 60.0 / BELT / params.ratio, orbits: [p, published], amplitudes })
}

/// The constant C that minimises the mean square of C ours/theirs - 1, and the maximum remaining deviation
/// [%].
fn fit(ours: impl Iterator<Item = f64>, theirs: impl Iterator<Item = f64>) -> (f64, f64) {
    let shares: Vec<f64> = ours.zip(theirs).map(|(x, y)| x / y).collect();
    let c = shares.iter().sum::<f64>() / shares.iter().map(|s| s * s).sum::<f64>();
    (c, 100.0 * shares.iter().fold(0.0f64, |worst, s| worst.max((c * s - 1.0).abs())))
}

/// Table 2, Fig. 17 and Fig. 18.
fn table2(folder: &Path) -> Outcome<()> {
    let lines = TABLE2.iter().map(|row| table2_lines(row[0])).collect::<Outcome<Vec<_>>>()?;
    let ratio = |l: &Lines, r: usize| MESH as f64 * l.amplitudes[r][1] / l.amplitudes[r][0];
    let fitted = |r: usize| fit(lines.iter().map(|l| ratio(l, r)), TABLE2.iter().map(|row| row[3]));
    let (c, _) = fitted(0);
    println!(
        "\nTable 2 and Fig. 18: ξ = C (ω_e |z_e|)/(ω_c |z_c|), T2 = 30 N m, belt {BELT}, z of f(q), \
         C = {c:.4}\n"
    );
    println!(
        "{:>6} {:>8} {:>8} {:>10} {:>8}   {:>10}",
        "r/min", "Liu 2021", READINGS[0], READINGS[1], READINGS[2], "experiment"
    );
    let header = "n_rpm,paper,p,published,exact,experiment,experiment_f_c_hz,experiment_f_e_hz";
    let mut csv = csv_file(folder.join("table2.csv"), header)?;
    let mut curves = vec![Vec::new(); 5];
    for (row, l) in TABLE2.iter().zip(&lines) {
        let [rpm, _, _, paper, f_c, f_e, measured] = *row;
        let values = [paper, c * ratio(l, 0), c * ratio(l, 1), c * ratio(l, 2), measured];
        println!(
            "{rpm:6} {paper:8.1} {:8.2} {:10.2} {:8.2}   {measured:10.1}",
            values[1], values[2], values[3]
        );
        csv.row(&[&rpm, &paper, &values[1], &values[2], &values[3], &measured, &f_c, &f_e])?;
        curves.iter_mut().zip(values).for_each(|(curve, y)| curve.push((rpm, y)));
    }
    for (r, reading) in READINGS.iter().enumerate() {
        let (c, worst) = fitted(r);
        println!("one constant for all nine ξ of {reading:9}: C = {c:.4}, maximum deviation {worst:.2} %");
    }
    println!(
        "columns A_c and A_e as velocity amplitudes C ω |z|, ω = 2π f [rad/s], one constant for a column:"
    );
    for (r, reading) in READINGS.iter().enumerate() {
        let of_centre =
            fit(lines.iter().map(|l| TAU * l.hertz * l.amplitudes[r][0]), TABLE2.iter().map(|row| row[1]));
        let of_mesh = fit(
            lines.iter().map(|l| TAU * MESH as f64 * l.hertz * l.amplitudes[r][1]),
            TABLE2.iter().map(|row| row[2]),
        );
        println!(
            "  {reading:9} A_c: C = {:.4e}, maximum deviation {:.2} %; A_e: C = {:.4e}, maximum deviation \
             {:.2} %; ratio of the constants A_e/A_c {:.4}",
            of_centre.0,
            of_centre.1,
            of_mesh.0,
            of_mesh.1,
            of_mesh.0 / of_centre.0
        );
    }
    let off = TABLE2.iter().fold(0.0f64, |m, row| m.max((row[2] / row[1] / row[3] - 1.0).abs()));
    println!(
        "  the printed A_e/A_c differ from the printed ξ by up to {:.1} %: A_c has two or three digits",
        100.0 * off
    );
    let natural = NfgPair::with_reading(&NfgParams::table1(), NfgReading::published())?.natural_frequency();
    println!("  ω_n of the published equations is {natural:.1} rad/s");

    let mut fig18 = Panel::new("Fig. 18: ratio of amplitudes", "motor [r/min]", "ξ")
        .labels_at(SeriesLabelPosition::LowerRight);
    for (name, curve) in
        ["Liu 2021, theory", READINGS[0], READINGS[1], READINGS[2], "Liu 2021, experiment"].iter().zip(curves)
    {
        fig18 = fig18.with(*name, if name.starts_with("Liu") { Mark::Dots } else { Mark::Line }, curve);
    }
    // The text of Liu 2021 states 864 r/min, but its frequencies are those of the row at 840 r/min.
    let (row, Lines { hertz, orbits: [p, truth], .. }) = (&TABLE2[5], &lines[5]);
    println!(
        "Fig. 17 at {} r/min: centre {hertz:.2} Hz and mesh {:.1} Hz (Liu 2021: 3 and 192, measured 3.2 \
         and 194)",
        row[0],
        MESH as f64 * hertz
    );
    let spectrum = |orbit: &FourierOrbit| {
        let orders = orbit.harmonics().orders().iter().filter(|&&k| k > 0 && k < 130);
        orders.map(|&k| (k as f64 * hertz, 1e6 * orbit.amplitude(0, k))).collect()
    };
    let fig17 =
        Panel::new(format!("Fig. 17: spectrum at {} r/min", row[0]), "f [Hz]", "amplitude of q [μrad]")
            .labels_at(SeriesLabelPosition::UpperRight)
            .with("measured frequencies", Mark::Dots, vec![(row[4], 0.0), (row[5], 0.0)])
            .with("published", Mark::Bars, spectrum(truth))
            .with("P", Mark::Dots, spectrum(p));
    figure(folder.join("fig17_18.svg"), 2, &[fig17, fig18])
}

/// Fig. 13b: the circular face gear, ε = 0.
fn circular() -> Outcome<Panel> {
    let pair = pair(&NfgParams { eccentric_ratio: 0.0, ..NfgParams::table1() })?;
    let p = paper_orbit(&pair)?.ok_or("no orbit at ε = 0")?;
    let (truth, ..) = converged_turn(&pair)?;
    let [history, ..] = portrait(
        "Fig. 13b: ε = 0, 160 rad/s (blue published, orange P)",
        &[("published", &truth), ("P", &p)],
    )?;
    println!(
        "Fig. 13b: at ε = 0 and 160 rad/s the peak-to-peak value is {:.3e} rad in P, {:.3e} published",
        p.peak_to_peak(0),
        truth.peak_to_peak(0)
    );
    Ok(history)
}

/// The points of a sweep over its parameter; `None` if no orbit was found.
type Line = Vec<(f64, Option<Point>)>;

/// Fig. 13c in numbers: the gap, and the peak-to-peak values of q and f(q).
fn gap_and_elastic(points: &[(Case, Line)], sweep: usize) -> Outcome<()> {
    println!("  ε, gap 2b/L, peak-to-peak of q and f(q) upwards [rad]:");
    for eps in [0.1, 0.2, 0.3, 0.4] {
        let gap = 2.0 * SWEEPS[sweep].pair(0, eps)?.half_width();
        let figures = (0..READINGS.len()).map(|reading| {
            let of = points.iter().find(|(case, _)| *case == (sweep, reading, 0)).map(|(_, points)| points);
            let point = of.and_then(|points| points.iter().find(|(x, _)| *x == eps)).and_then(|(_, p)| *p);
            format!(
                "{} {}",
                READINGS[reading],
                point.map_or("no orbit".into(), |p| format!("{} {:.3e} {:.3e}", p.state, p.ppv, p.elastic))
            )
        });
        println!("  {eps}  {gap:.3e}  {}", figures.collect::<Vec<_>>().join("; "));
    }
    Ok(())
}

/// Indices of sweep, reading and branch.
type Case = (usize, usize, usize);

fn main() -> Outcome<()> {
    let folder = gallery("nfg_balance")?;
    figures_8_to_10(&folder)?;
    roots_of_p(180.0)?;
    load_limits_of_p()?;
    table2(&folder)?;

    let runs: Vec<Case> = (0..SWEEPS.len())
        .flat_map(|s| [2, 1, 0].into_iter().flat_map(move |r| (0..2).map(move |b| (s, r, b))))
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

    for file in ["speed", "load", "error", "eccentricity", "stiffness", "circular"] {
        let members = || SWEEPS.iter().enumerate().filter(|(_, sweep)| sweep.file == file);
        let several = members().count() > 1;
        let mut panels = Vec::new();
        let mut csv = None;
        for (s, sweep) in members() {
            let title = if sweep.speed.is_nan() {
                sweep.figure.into()
            } else {
                format!("{} at {} rad/s", sweep.figure, sweep.speed)
            };
            println!("\n{title}: {}", sweep.axis);
            if csv.is_none() {
                let header = format!(
                    "reading,branch,{},state,ppv,elastic_ppv,stable{}",
                    sweep.parameter,
                    if several { ",omega_1" } else { "" }
                );
                csv = Some(csv_file(folder.join(format!("{file}.csv")), &header)?);
            }
            let corner = match file {
                "load" => SeriesLabelPosition::UpperRight,
                "stiffness" => SeriesLabelPosition::UpperLeft,
                _ => SeriesLabelPosition::LowerRight,
            };
            let mut states = Panel::new(
                format!("{title}: rattle state (0 none, 1 unilateral, 2 bilateral)"),
                sweep.axis,
                "state",
            )
            .labels_at(corner.clone());
            let mut ppv = Panel::new(format!("{title}: peak-to-peak of q"), sweep.axis, "ppv [rad]")
                .labels_at(corner.clone());
            let mut elastic = Panel::new(format!("{title}: peak-to-peak of f(q)"), sweep.axis, "ppv [rad]")
                .labels_at(corner);
            for ((_, r, b), points) in all.iter().filter(|((which, ..), _)| *which == s) {
                let (reading, branch) = (READINGS[*r], BRANCHES[*b]);
                for (x, point) in points {
                    if let (Some(point), Some(csv)) = (point, &mut csv) {
                        let state = point.state.rsv();
                        let mut row: Vec<&dyn std::fmt::Display> =
                            vec![&reading, &branch, x, &state, &point.ppv, &point.elastic, &point.stable];
                        if several {
                            row.push(&sweep.speed);
                        }
                        csv.row(&row)?;
                    }
                }
                println!("  {reading:9} {branch:4} {}", spans(points, |p| p.state.to_string(), 6));
                match r {
                    0 => println!("  {:14} jumps: {}", "", jumps(points)),
                    _ => println!("  {:14} {}", "", spans(points, |p| p.stable.into(), 6)),
                }
                if *b == 0 {
                    println!("  {:14} {}", "", onset(points));
                    println!("  {:14} q: {}", "", trend(points, |p| p.ppv));
                    println!("  {:14} f(q): {}", "", trend(points, |p| p.elastic));
                    if *r == 0
                        && let Some((_, truth)) = all.iter().find(|(case, _)| *case == (s, 1, 0))
                    {
                        println!(
                            "  {:14} against the published equations in q: {}",
                            "",
                            misses(points, truth)
                        );
                    }
                }
                let curve = |of: fn(&Point) -> f64| {
                    points.iter().filter_map(|(x, p)| p.as_ref().map(|p| (*x, of(p)))).collect::<Vec<_>>()
                };
                let mark = || if *r == 0 { Mark::Line } else { Mark::Dots };
                let name = format!("{reading} {branch}");
                states = states.with(&name, mark(), curve(|p| f64::from(p.state.rsv())));
                ppv = ppv.with(&name, mark(), curve(|p| p.ppv));
                elastic = elastic.with(&name, mark(), curve(|p| p.elastic));
            }
            panels.extend([states, ppv, elastic]);
            if file == "eccentricity" {
                gap_and_elastic(&all, s)?;
                panels.push(circular()?);
            }
        }
        figure(
            folder.join(format!(
                "{}_{file}.svg",
                SWEEPS[members().next().map_or(0, |m| m.0)].figure[..7].replace(". ", "").to_lowercase()
            )),
            3,
            &panels,
        )?;
    }
    println!("\npictures and tables: {}", folder.display());
    Ok(())
}
