//! The face gear pair of Liu 2021 from the static start, integrated in time with located edges: the onsets of
//! rattle, and the model of two degrees of freedom.

use super::super::report::{Kind, Report};
use super::super::support::{Outcome, coarse, progress};
use super::motions::{Cycle, settled, turns};
use gear_dynamics::analysis::Summary;
use gear_dynamics::models::nfg::{NfgPair2, NfgReading};
use gear_dynamics::ode::uniform_times;
use gear_dynamics::{Dop853, Integrator, NfgPair, NfgParams, Periodic, Rattle, RattleState, Statistics};
use gear_dynamics_plots::{Mark, Panel};
use rayon::prelude::*;

type Reading = (&'static str, fn() -> NfgReading);
const READINGS: [Reading; 2] = [("published", NfgReading::published), ("exact", NfgReading::exact)];

fn solver() -> Dop853 {
    Dop853::new().rtol(1e-10).atol_each(&[1e-15, 1e-16])
}

/// Results of a settled run.
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
}

/// Settles from the static start and measures one period, or so many [`turns`] if the motion does not repeat.
fn measure(pair: &NfgPair) -> Outcome<Run> {
    let (state, cycle) = settled(pair, &pair.on_drive_flank()?)?;
    let start = cycle.as_ref().map_or(&state, Cycle::start);
    let multiple = cycle.as_ref().map_or(0, Cycle::turns);
    let turns = if multiple > 0 { multiple } else { turns()[1] };
    let mut rattle = Rattle::new(pair);
    let mut statistics = Statistics::new(pair, &["q0", "elastic part", "deflection"])?;
    let mut both = (&mut rattle, &mut statistics);
    solver().run(pair, start, start.t + turns as f64 * pair.period(), &mut both)?;
    let contact = rattle.contacts()[0];
    Ok(Run {
        state: contact.rattle_state(),
        q: statistics.summary("q0")?,
        elastic: statistics.summary("elastic part")?,
        deflection: statistics.summary("deflection")?,
        loss: contact.loss_fraction(),
        impacts_per_turn: contact.impact_count() as f64 / turns as f64,
        multiple,
    })
}

fn run_at(reading: fn() -> NfgReading, speed: f64) -> Result<Run, String> {
    let pair = NfgPair::of_reading(&NfgParams { speed, ..NfgParams::table1() }, reading())
        .map_err(|e| e.to_string())?;
    measure(&pair).map_err(|e| format!("{speed} rad/s: {e}"))
}

/// The speed sweep from the static start: each speed by itself.
pub fn figures(report: &mut Report) -> Outcome<()> {
    // Steps of the sweep, and the resolution of the thresholds [rad/s], which divides them.
    let (step, fine) = if coarse() { (30.0, 15.0) } else { (1.0, 0.5) };
    let speeds: Vec<f64> =
        (0..).map(|i| 100.0 + step * f64::from(i)).take_while(|speed| *speed <= 250.0).collect();
    let bar = progress("speed sweep from rest", READINGS.len() * speeds.len());
    let mut all = Vec::new();
    for (name, reading) in READINGS {
        let runs: Result<Vec<Run>, String> = speeds
            .par_iter()
            .map(|&speed| {
                let run = run_at(reading, speed);
                bar.inc(1);
                run
            })
            .collect();
        all.push((name, reading, runs?));
    }
    bar.finish_and_clear();
    let mut rows = Vec::new();
    let mut at_160 = Vec::new();
    for (name, reading, runs) in &all {
        // The first speed of the sweep at which `seen` is true, refined within the interval before it.
        let threshold = |seen: &dyn Fn(&Run) -> bool| -> Result<String, String> {
            let Some(first) = runs.iter().position(seen) else { return Ok("nowhere".into()) };
            let mut upper = speeds[first];
            while upper - fine > speeds[first] - step && seen(&run_at(*reading, upper - fine)?) {
                upper -= fine;
            }
            Ok(format!("{}-{upper} rad/s", upper - fine))
        };
        // The last speed at which the period is not 1.
        let last = runs.iter().rposition(|r| r.multiple != 1);
        let again =
            last.and_then(|last| speeds.get(last + 1)).map_or("-".into(), |speed| format!("{speed} rad/s"));
        rows.push(vec![
            (*name).to_owned(),
            threshold(&|r| r.state != RattleState::None)?,
            threshold(&|r| r.state == RattleState::Bilateral)?,
            again,
            runs.iter().filter(|r| r.multiple == 0).count().to_string(),
            runs.iter().filter(|r| r.multiple > 1).count().to_string(),
        ]);
        if let Some(i) = speeds.iter().position(|speed| *speed == 160.0) {
            let r = &runs[i];
            at_160.push(vec![
                (*name).to_owned(),
                r.state.to_string(),
                if r.multiple > 0 { r.multiple.to_string() } else { "none".into() },
                format!("{:.3e}", r.q.peak_to_peak()),
                format!("{:.3e}", r.elastic.peak_to_peak()),
                format!("{:.3e}", r.deflection.peak_to_peak()),
                format!("{:.1} %", 100.0 * r.loss),
                format!("{:.1}", r.impacts_per_turn),
            ]);
        }
    }
    #[rustfmt::skip]
    let header = ["reading", "contact first lost", "bilateral rattle from", "period one again from",
        "speeds without a period", "speeds with 2 to 8 turns"];
    report.table("onsets_from_rest", Kind::Full, &header, &rows);
    #[rustfmt::skip]
    let header = ["reading, 160 rad/s", "state", "period", "ppv of q [rad]", "ppv of f(q) [rad]",
        "ppv of the deflection [m]", "contact lost", "impacts a turn"];
    report.table("from_rest_at_160", Kind::Full, &header, &at_160);
    report.csv(
        "speed_from_rest.csv",
        "reading,omega_1,state,ppv,elastic_ppv,mean,min,max,deflection_p2p,period_multiple",
        |csv| {
            for (name, _, runs) in &all {
                for (speed, run) in speeds.iter().zip(runs) {
                    let [p2p, f_p2p, deflection] = [run.q, run.elastic, run.deflection].map(|s| s.peak_to_peak());
                    let (state, q) = (run.state.rsv(), run.q);
                    #[rustfmt::skip]
                    csv.row(&[name, speed, &state, &p2p, &f_p2p, &q.mean, &q.min, &q.max, &deflection, &run.multiple])?;
                }
            }
            Ok(())
        },
    );
    let panel = |title: &str, value: &str, of: fn(&Run) -> f64| {
        let panel = Panel::new(title, "ω1 [rad/s]", value)?;
        all.iter().try_fold(panel, |panel, (name, _, runs)| {
            panel.series(name, Mark::Dots, speeds.iter().zip(runs).map(|(s, r)| (*s, of(r))))
        })
    };
    let panels = [
        panel("0 none, 1 unilateral, 2 bilateral", "rattle state [1]", |r| f64::from(r.state.rsv()))?,
        panel("from rest", "peak-to-peak of q [rad]", |r| r.q.peak_to_peak())?,
        panel("from rest", "peak-to-peak of f(q) [rad]", |r| r.elastic.peak_to_peak())?,
        panel("from rest", "peak-to-peak of r_b2 q [m]", |r| r.deflection.peak_to_peak())?,
    ];
    report.picture("fig11_from_rest.svg", 2, panels);
    Ok(())
}

/// How the model of two degrees of freedom tends to that of one with a heavy pinion.
pub fn two_degrees_of_freedom(report: &mut Report) -> Outcome<()> {
    let mut rows = Vec::new();
    for speed in [120.0, 140.0] {
        let mut cells = vec![format!("{speed} rad/s")];
        for inertia in [10.0, 1000.0] {
            let params = NfgParams { speed, ..NfgParams::table1() };
            let (one, two) = (NfgPair::new(&params)?, NfgPair2::new(&params, inertia)?);
            let times = uniform_times(0.0, 3.0 * two.period(), 30_000)?;
            let taus: Vec<f64> = times.iter().map(|t| t * one.natural_frequency()).collect();
            let x1 = solver().sample(&one, &one.on_drive_flank()?, &taus)?.channel(&one, "deflection")?;
            let two_solver = Dop853::new().rtol(1e-10).atol(1e-16);
            let x2 = two_solver.sample(&two, &two.on_drive_flank()?, &times)?.channel(&two, "deflection")?;
            // The drive flank is the lower one in the first model and the upper one in the second, so that
            // the deflections have opposite signs.
            let worst = x1.iter().zip(&x2).fold(0.0, |m: f64, (a, b)| m.max((a + b).abs()));
            let share = worst / Summary::of_samples(&x1[20_000..])?.peak_to_peak();
            cells.push(format!("{share:.1e}"));
        }
        rows.push(cells);
    }
    let header = ["", "I1 = 10 kg m²", "I1 = 1000 kg m²"];
    report.table("two_degrees_of_freedom", Kind::Fixed, &header, &rows);
    Ok(())
}
