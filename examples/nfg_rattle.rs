//! Rattle of the noncircular face gear pair: Figs. 8-11 and 13b of Liu 2021, integrated in time with located
//! edges.
//!
//! The table states rattle state, peak-to-peak values, contact loss and period at three speeds, for the
//! published and the exact reading. The pictures show time histories, phase portraits and spectra at these
//! speeds, and rattle state and peak-to-peak values from 100 to 250 rad/s; `speed_sweep.csv` contains the
//! sweep.
//!
//! `cargo run --release -p examples --example nfg_rattle`; everything is written to
//! target/gallery/nfg_rattle/.

mod support;

use gear_dynamics::analysis::{Spectrum, Summary, Unsettled, Window};
use gear_dynamics::models::nfg::{NfgPair2, NfgReading};
use gear_dynamics::ode::uniform_times;
use gear_dynamics::{
    Dop853, Integrator, NfgPair, NfgParams, Periodic, Rattle, RattleState, Settle, State, Statistics,
};
use rayon::prelude::*;
use support::{Mark, Outcome, Panel, csv_file, figure, gallery, progress};

type Reading = (&'static str, fn() -> NfgReading);
const READINGS: [Reading; 2] = [("published", NfgReading::published), ("exact", NfgReading::exact)];
/// Turns of the face gear for settling, and for measuring if the motion does not repeat.
const SETTLE: usize = 60;
const MEASURE: usize = 40;
/// Resolution of the thresholds [rad/s]; 1 must be a multiple of it.
const FINE: f64 = 0.5;

fn solver() -> Dop853 {
    Dop853::new().rtol(1e-10).atol_each(&[1e-15, 1e-16])
}

/// Results of a settled run, and the state in which its measurement starts.
struct Run {
    state: RattleState,
    q: Summary,
    /// f(q), the elastic part.
    elastic: Summary,
    deflection: Summary,
    loss: f64,
    impacts_per_turn: f64,
    /// Period multiple; 0 if the motion does not repeat.
    multiple: usize,
    on_orbit: State,
}

/// Settles from the static start and measures one period, or `MEASURE` turns if the motion does not repeat.
fn measure(pair: &NfgPair) -> Outcome<Run> {
    let settled =
        Settle::new().tolerance(1e-8).max_periods(SETTLE).run(&solver(), pair, &pair.static_start()?);
    let (on_orbit, multiple) = match settled {
        Ok(steady) => (steady.state, steady.period_multiple),
        Err(Unsettled::Aperiodic { state, .. }) => (state, 0),
        Err(failed) => return Err(failed.into()),
    };
    let turns = if multiple > 0 { multiple } else { MEASURE };
    let mut rattle = Rattle::new(pair);
    let mut statistics = Statistics::new(pair, &["q1", "elastic part", "deflection"])?;
    let mut both = (&mut rattle, &mut statistics);
    solver().run(pair, &on_orbit, on_orbit.t + turns as f64 * pair.period(), &mut both)?;
    let contact = rattle.contact(0);
    Ok(Run {
        state: contact.rattle_state(),
        q: statistics.summary("q1")?,
        elastic: statistics.summary("elastic part")?,
        deflection: statistics.summary("deflection")?,
        loss: contact.loss_fraction(),
        impacts_per_turn: contact.impact_count() as f64 / turns as f64,
        multiple,
        on_orbit,
    })
}

/// Time history, phase portrait and order spectrum of one turn, as in Figs. 8-10.
fn portrait(pair: &NfgPair, run: &Run, title: &str) -> Outcome<[Panel; 3]> {
    const SAMPLES: usize = 4096;
    let t0 = run.on_orbit.t;
    let times = uniform_times(t0, t0 + pair.period(), SAMPLES)?;
    let turn = solver().sample(pair, &run.on_orbit, &times)?;
    let q = turn.channel(pair, "q1")?;
    let history = times.iter().zip(&q).map(|(t, q)| ((t - t0) / pair.period(), *q)).collect();
    let phase = turn.phase_portrait(0);
    let spectrum = Spectrum::new(&q, pair.period() / SAMPLES as f64, Window::Rectangular)?;
    let orders = spectrum.orders(1.0 / pair.period())?;
    let lines = orders.iter().zip(spectrum.amplitudes()).skip(1).take(260).map(|(o, a)| (*o, *a)).collect();
    Ok([
        Panel::new(title, "turns of the face gear", "q [rad]").with("", Mark::Line, history),
        Panel::new("phase portrait", "q [rad]", "dq/dτ [rad]").with("", Mark::Line, phase),
        Panel::new("spectrum", "order of the face gear", "amplitude [rad]").with("", Mark::Bars, lines),
    ])
}

/// Prints how the model of two degrees of freedom tends to that of one with a heavy pinion.
fn two_degrees_of_freedom() -> Outcome<()> {
    println!(
        "\nTwo degrees of freedom against one, third turn from the same start: max|Δx| over the peak-to-peak \
         value of x"
    );
    for speed in [120.0, 140.0] {
        for inertia in [10.0, 1000.0] {
            let params = NfgParams { speed, ..NfgParams::table1() };
            let (one, two) = (NfgPair::new(&params)?, NfgPair2::new(&params, inertia)?);
            let times = uniform_times(0.0, 3.0 * two.period(), 30_000)?;
            let taus: Vec<f64> = times.iter().map(|t| t * one.natural_frequency()).collect();
            let x1 = solver().sample(&one, &one.static_start()?, &taus)?.channel(&one, "deflection")?;
            let two_solver = Dop853::new().rtol(1e-10).atol(1e-16);
            let x2 = two_solver.sample(&two, &two.static_start()?, &times)?.channel(&two, "deflection")?;
            // The drive flank is the lower one in the first model and the upper one in the second, so that
            // the deflections have opposite signs.
            let worst = x1.iter().zip(&x2).fold(0.0, |m: f64, (a, b)| m.max((a + b).abs()));
            let share = worst / Summary::from_samples(&x1[20_000..])?.peak_to_peak();
            println!("{speed} rad/s, I1 = {inertia:4} kg m²: {share:.1e}");
        }
    }
    Ok(())
}

fn main() -> Outcome<()> {
    let folder = gallery("nfg_rattle")?;

    println!("Figs. 8-10: the pair of Table 1 at three speeds (Liu 2021: none, unilateral, bilateral)\n");
    println!(
        "{:10} {:>6}  {:10} {:>10} {:>10} {:>12} {:>10} {:>6} {:>12} {:>7}",
        "reading",
        "rad/s",
        "state",
        "ppv q",
        "ppv f(q)",
        "ppv r_b2 q",
        "mean q",
        "loss",
        "impacts/turn",
        "period"
    );
    for (name, reading) in READINGS {
        let mut panels = Vec::new();
        for speed in [140.0, 160.0, 180.0] {
            let pair = NfgPair::with_reading(&NfgParams { speed, ..NfgParams::table1() }, reading())?;
            let run = measure(&pair)?;
            let period = if run.multiple > 0 { run.multiple.to_string() } else { "none".into() };
            println!(
                "{name:10} {speed:6}  {:10} {:10.4e} {:10.4e} {:10.3e} m {:10.3e} {:5.1}% {:12.1} \
                 {period:>7}",
                run.state.to_string(),
                run.q.peak_to_peak(),
                run.elastic.peak_to_peak(),
                run.deflection.peak_to_peak(),
                run.q.mean,
                100.0 * run.loss,
                run.impacts_per_turn
            );
            panels.extend(portrait(&pair, &run, &format!("{name}, {speed} rad/s: {}", run.state))?);
        }
        figure(folder.join(format!("fig8_10_{name}.svg")), 3, &panels)?;
    }

    println!(
        "\nThe thresholds of Liu 2021 come from a harmonic balance with 15 unknowns; these are converged \
         motions.\nIf the period is none, the numbers are those of {MEASURE} turns. See docs/models.md and \
         docs/errata.md."
    );

    println!("\nFig. 11: speed sweep from the static start");
    let speeds: Vec<f64> = (100..=250).map(f64::from).collect();
    let bar = progress("speed sweep", 2 * speeds.len());
    let mut csv = csv_file(
        folder.join("speed_sweep.csv"),
        "reading,omega_1,state,ppv,elastic_ppv,mean,min,max,deflection_p2p,period_multiple",
    )?;
    let mut states = Panel::new("rattle state (0 none, 1 unilateral, 2 bilateral)", "ω1 [rad/s]", "state");
    let mut ppv = Panel::new("peak-to-peak of q", "ω1 [rad/s]", "ppv [rad]");
    let mut elastic = Panel::new("peak-to-peak of f(q)", "ω1 [rad/s]", "[rad]");
    let mut deflection = Panel::new("peak-to-peak of the deflection r_b2 q", "ω1 [rad/s]", "[m]");
    let run_at = |reading: fn() -> NfgReading, speed: f64| -> Result<Run, String> {
        let pair = NfgPair::with_reading(&NfgParams { speed, ..NfgParams::table1() }, reading())
            .map_err(|e| e.to_string())?;
        measure(&pair).map_err(|e| format!("{speed} rad/s: {e}"))
    };
    for (name, reading) in READINGS {
        let runs: Result<Vec<Run>, String> = speeds
            .par_iter()
            .map(|&speed| {
                let run = run_at(reading, speed);
                bar.inc(1);
                run
            })
            .collect();
        let runs = runs?;
        for (speed, run) in speeds.iter().zip(&runs) {
            let [p2p, f_p2p, deflection] = [run.q, run.elastic, run.deflection].map(|s| s.peak_to_peak());
            let state = run.state.rsv();
            csv.row(&[
                &name,
                speed,
                &state,
                &p2p,
                &f_p2p,
                &run.q.mean,
                &run.q.min,
                &run.q.max,
                &deflection,
                &run.multiple,
            ])?;
        }
        let curve =
            |of: &dyn Fn(&Run) -> f64| speeds.iter().zip(&runs).map(|(s, r)| (*s, of(r))).collect::<Vec<_>>();
        states = states.with(name, Mark::Dots, curve(&|r| f64::from(r.state.rsv())));
        ppv = ppv.with(name, Mark::Line, curve(&|r| r.q.peak_to_peak()));
        elastic = elastic.with(name, Mark::Line, curve(&|r| r.elastic.peak_to_peak()));
        deflection = deflection.with(name, Mark::Line, curve(&|r| r.deflection.peak_to_peak()));
        // The first speed of the sweep at which `seen` is true, refined within the interval before it.
        let threshold = |seen: &dyn Fn(&Run) -> bool| -> Result<String, String> {
            let Some(first) = runs.iter().position(seen) else { return Ok("nowhere".into()) };
            let mut upper = speeds[first];
            while upper - FINE > speeds[first] - 1.0 && seen(&run_at(reading, upper - FINE)?) {
                upper -= FINE;
            }
            Ok(format!("{}-{upper} rad/s", upper - FINE))
        };
        let lost = threshold(&|r| r.state != RattleState::None)?;
        let bilateral = threshold(&|r| r.state == RattleState::Bilateral)?;
        // The last speed at which the period is not 1, and the motion there.
        let last = runs.iter().rposition(|r| r.multiple != 1);
        let again = last.map_or("always period one".into(), |last| {
            let there = match runs[last].multiple {
                0 => "none".into(),
                p => p.to_string(),
            };
            format!(
                "period one again from {} rad/s (period at {}: {there})",
                speeds[last] + 1.0,
                speeds[last]
            )
        });
        let list = |wanted: &dyn Fn(usize) -> bool| -> Vec<f64> {
            speeds.iter().zip(&runs).filter(|(_, r)| wanted(r.multiple)).map(|(s, _)| *s).collect()
        };
        let (aperiodic, longer) = (list(&|p| p == 0), list(&|p| p > 1));
        bar.suspend(|| {
            println!("{name:10} contact first lost: {lost}; bilateral from: {bilateral}; {again}");
            println!("{:10} no period up to 8 turns at {aperiodic:?} rad/s; 2 to 8 turns at {longer:?}", "");
        });
    }
    bar.finish_and_clear();
    figure(folder.join("fig11_speed_sweep.svg"), 1, &[states, ppv, elastic, deflection])?;

    println!("\nFig. 13b: eccentric ratios 0 and 0.2 at 160 rad/s");
    let mut panels = Vec::new();
    for (name, reading) in READINGS {
        for eccentric_ratio in [0.0, 0.2] {
            let pair =
                NfgPair::with_reading(&NfgParams { eccentric_ratio, ..NfgParams::table1() }, reading())?;
            let run = measure(&pair)?;
            let [q, f] = [run.q, run.elastic].map(|s| s.peak_to_peak());
            println!(
                "{name:10} ε = {eccentric_ratio}: {:10} peak-to-peak of q {q:.4e}, of f(q) {f:.4e} rad",
                run.state.to_string()
            );
            let [history, ..] =
                portrait(&pair, &run, &format!("{name}, 160 rad/s, eccentric ratio {eccentric_ratio}"))?;
            panels.push(history);
        }
    }
    figure(folder.join("fig13b_eccentric_ratio.svg"), 2, &panels)?;
    two_degrees_of_freedom()?;
    println!("\npictures and tables: {}", folder.display());
    Ok(())
}
