//! Figs. 8-10 and 13b of Liu 2021: time history, phase portrait and spectrum of one turn, by the balance P and
//! converged.

use super::super::report::{Kind, Report};
use super::super::support::{Outcome, coarse};
use super::motions::{
    Cycle, Point, at_rest, broyden, converged, on_cycle, pair, paper, paper_orbit, paper_point, run, solver,
    turns,
};
use gear_dynamics::contact::Piece;
use gear_dynamics::models::nfg::NfgReading;
use gear_dynamics::periodic::{BalanceError, FourierOrbit};
use gear_dynamics::{Balance, Harmonics, NfgPair, NfgParams};
use gear_dynamics_plots::{Mark, Panel};

/// Time history, phase portrait and order spectrum of one turn, as in Figs. 8-10.
fn portrait(title: &str, orbits: &[(&str, &FourierOrbit)]) -> Outcome<[Panel; 3]> {
    const SAMPLES: usize = 8192;
    let mut history = Panel::new(title, "turns of the face gear [1]", "q [rad]")?;
    let mut phase = Panel::new("phase portrait", "q [rad]", "dq/dτ [rad]")?;
    let mut spectrum = Panel::new("spectrum", "order of the face gear [1]", "amplitude of q [rad]")?;
    for (name, orbit) in orbits {
        let turn = orbit.history(SAMPLES)?;
        let points = (0..SAMPLES).map(|i| (i as f64 / SAMPLES as f64, turn.q(i)[0]));
        history = history.series(name, Mark::Line, points)?;
        phase = phase.series(name, Mark::Line, (0..SAMPLES).map(|i| (turn.q(i)[0], turn.v(i)[0])))?;
        let lines = orbit
            .harmonics()
            .orders()
            .iter()
            .filter(|&&k| k > 0 && k <= 260)
            .map(|&k| (k as f64, orbit.amplitude(0, k)));
        let mark = if name.starts_with('P') { Mark::Dots } else { Mark::Bars };
        spectrum = spectrum.series(name, mark, lines)?;
    }
    Ok([history, phase, spectrum])
}

/// One turn of the converged motion as a series, its point, and how it was found.
fn converged_turn(pair: &NfgPair) -> Outcome<(FourierOrbit, Point, String)> {
    let many = Harmonics::up_to(1000);
    let (motion, point) = converged(pair, None)?;
    let turn = FourierOrbit::project(&solver(), pair, &motion.start, &many)?;
    if motion.cycle.is_none() {
        let [settle, measure] = turns();
        let how = format!("no stable orbit by shooting after {settle} turns: run of {measure} more turns");
        return Ok((turn, point, how));
    }
    let balance = Balance::new(Harmonics::up_to(600));
    let proof = balance.solve_to(pair, &turn, 2e-3, 1400)?;
    let Some(cycle) = &proof.polished else {
        return Ok((turn, point, "settled in time".into()));
    };
    let how =
        format!("balance to {:.0e}, first shooting correction {:.0e}", proof.truncation, proof.shooting);
    Ok((
        FourierOrbit::project(&solver(), pair, &cycle.states()[0], &many)?,
        on_cycle(pair, &Cycle::Orbit(Box::new(cycle.clone())))?,
        how,
    ))
}
/// State and peak-to-peak values of q and f(q).
fn show(point: &Point) -> String {
    let state = if point.stable == "aperiodic" {
        format!("{}, no period", point.state)
    } else {
        point.state.to_string()
    };
    format!("{state}, {:.2e} / {:.2e}", point.ppv, point.elastic)
}

/// Figs. 8-10, and the circular gear of Fig. 13b.
pub fn figures(report: &mut Report) -> Outcome<()> {
    let mut panels = Vec::new();
    let mut rows = Vec::new();
    for (name, paper_says, speed, eccentric_ratio) in [
        ("9", "none", 140.0, 0.2),
        ("8", "unilateral", 160.0, 0.2),
        ("10", "bilateral", 180.0, 0.2),
        ("13b", "less vibration than Fig. 8", 160.0, 0.0),
    ]
    .into_iter()
    .step_by(if coarse() { 3 } else { 1 })
    {
        let params = NfgParams { speed, eccentric_ratio, ..NfgParams::table1() };
        let pair = pair(&params)?;
        let (orbit, way) = if eccentric_ratio == 0.0 {
            (paper_orbit(&pair)?.ok_or("no orbit at ε = 0")?, "Newton".to_owned())
        } else {
            broyden_orbit(&pair)?
        };
        let p = paper_point(&pair, &orbit)?;
        let (truth, point, how) = converged_turn(&pair)?;
        let (_, exact) = converged(&NfgPair::of_reading(&params, NfgReading::exact())?, None)?;
        println!("Fig. {name}: P by {way}; published by {how}");
        orbit.notes().iter().for_each(|note| println!("  P: {note}"));
        rows.push(vec![
            format!("{name}: {speed} rad/s, ε = {eccentric_ratio}"),
            paper_says.into(),
            show(&p),
            show(&point),
            show(&exact),
            // A motion that does not repeat is no orbit to compare with.
            if point.stable == "aperiodic" {
                "-".into()
            } else {
                format!("{:.0} %", 100.0 * orbit.distance(&truth) * p.ppv / point.ppv)
            },
            way,
        ]);
        let title = format!("Fig. {name}: {speed} rad/s, ε = {eccentric_ratio}");
        panels.extend(portrait(&title, &[("published", &truth), ("P", &orbit)])?);
    }
    let header = ["figure", "paper", "P", "published", "exact", "P off by", "iterations of P"];
    report.table("figures_8_to_10", Kind::Full, &header, &rows);
    report.picture("fig8_10.svg", 3, panels);
    Ok(())
}

/// The orbit of P by Broyden's method as in Liu 2021, from rest; where this fails, beyond the fold, from a run in
/// time. With it the iterations of Broyden and of Newton from the linear flank.
fn broyden_orbit(pair: &NfgPair) -> Outcome<(FourierOrbit, String)> {
    let flank = paper()?.linearised(pair, Piece::Lower)?;
    let newton = paper()?
        .solve(pair, &flank)
        .map_or("Newton fails".into(), |orbit| format!("Newton {}", orbit.iterations()));
    let (from, orbit) = match broyden()?.solve(pair, &at_rest(pair)?) {
        Ok(orbit) => ("rest", orbit),
        Err(BalanceError::NotConverged { .. }) => ("a run", broyden()?.solve(pair, &run(pair)?)?),
        Err(error) => return Err(error.into()),
    };
    let way = format!("Broyden {} from {from}, {newton}", orbit.iterations());
    Ok((orbit, way))
}
