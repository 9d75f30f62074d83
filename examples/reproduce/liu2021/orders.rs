//! Error of the harmonic balance and its estimates over the number of orders H, for the face gear pair of Liu
//! 2021 (reading A of docs/models.md) at four speeds.
//!
//! The reference is the orbit polished by shooting. Its projection is the guess at every H, so that the error
//! is that of the equations and not of the search. Errors are shares of the peak-to-peak value.

use super::super::report::{Kind, Report};
use super::super::support::{Outcome, coarse, progress};
use gear_dynamics::models::nfg::NfgReading;
use gear_dynamics::periodic::{ErrorEstimate, FourierOrbit, Integrals};
use gear_dynamics::roots::Residual;
use gear_dynamics::{Balance, Dop853, Harmonics, NfgPair, NfgParams, Settle, Shooting, State};
use gear_dynamics_plots::{Mark, Panel};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

const SPEEDS: [f64; 4] = [120.0, 140.0, 180.0, 220.0];
const ORDERS: [usize; 8] = [65, 100, 200, 300, 400, 550, 750, 1000];
const WAYS: [(&str, Integrals); 3] = [
    ("closed", Integrals::Closed),
    ("sampled 4096", Integrals::Sampled { samples: 4096 }),
    ("sampled 65536", Integrals::Sampled { samples: 65_536 }),
];

fn solver() -> Dop853 {
    Dop853::new().rtol(1e-11).atol_each(&[1e-16, 1e-17])
}

/// The reference orbit on 4000 orders, and its crossings in a turn.
fn truth(pair: &NfgPair) -> Outcome<(FourierOrbit, u64)> {
    let steady = Settle::new().tolerance(1e-6).run(&solver(), pair, &pair.on_drive_flank()?)?;
    let cycle = Shooting::new()
        .period_multiple(steady.period_multiple)
        .solve(pair, &[State { t: 0.0, ..steady.state }])?;
    let fine = Dop853::new().rtol(1e-13).atol_each(&[1e-18, 1e-19]);
    Ok((
        FourierOrbit::project(&fine, pair, &cycle.states()[0], &Harmonics::up_to(4000))?,
        cycle.crossing_count(),
    ))
}

/// Results of a balance of H orders, as shares of the peak-to-peak value of the reference; NaN if no orbit is
/// found.
#[derive(Clone, Copy)]
struct Row {
    error: f64,
    truncation: f64,
    shooting: f64,
    aliasing: f64,
    iterations: usize,
}

const NOTHING: Row =
    Row { error: f64::NAN, truncation: f64::NAN, shooting: f64::NAN, aliasing: f64::NAN, iterations: 0 };

fn row(pair: &NfgPair, truth: &FourierOrbit, highest: usize, integrals: Integrals) -> Row {
    let balance = Balance::new(Harmonics::up_to(highest)).integrals(integrals);
    let Ok(orbit) = balance.solve(pair, truth) else { return NOTHING };
    let error = truth.distance(&orbit);
    let iterations = orbit.iterations();
    match balance.error_estimate(pair, &orbit) {
        Ok(ErrorEstimate { truncation, shooting, aliasing, .. }) => {
            Row { error, truncation, shooting, aliasing, iterations }
        }
        // The finer balance found no orbit near: only the polished orbit remains.
        Err(_) => {
            let shooting = Shooting::new()
                .solve_from(pair, &orbit)
                .map_or(f64::INFINITY, |cycle| cycle.first_correction());
            Row { error, shooting, iterations, ..NOTHING }
        }
    }
}

/// Number of orders above the maximum local natural frequency: H > 1.2 √(max F)/ω_c. Both factors of F are
/// largest at the start, where the static deflection B0/F is known.
fn needed(pair: &NfgPair) -> Outcome<f64> {
    let load = pair.constant("load torque")? / (pair.constant("inertia")? * pair.natural_frequency().powi(2));
    let stiffness = load / (-pair.on_drive_flank()?.q[0] - pair.half_backlash_angle());
    Ok(1.2 * stiffness.sqrt() / pair.speed())
}

/// The differences of residual and Jacobian between the ways of integration, at the projected orbit.
fn ways_of_integrating(report: &mut Report, speed: f64, highest: usize) -> Outcome<()> {
    let pair = NfgPair::of_reading(
        &NfgParams { speed, ..NfgParams::table1() },
        NfgReading::published_on_base_radius(),
    )?;
    let steady = Settle::new().tolerance(1e-7).run(&solver(), &pair, &pair.on_drive_flank()?)?;
    let guess = FourierOrbit::project(&solver(), &pair, &steady.state, &Harmonics::up_to(highest))?;
    let look = |integrals| -> Outcome<(DVector<f64>, DMatrix<f64>)> {
        let mut equations =
            Balance::new(Harmonics::up_to(highest)).integrals(integrals).equations(&pair, &guess)?;
        let x = equations.unknowns(&guess);
        let (mut r, mut matrix) = (vec![0.0; x.len()], equations.matrix());
        equations.residual(&x, &mut r);
        equations.jacobian(&x, &mut matrix);
        Ok((DVector::from_vec(r), DMatrix::from(&matrix)))
    };
    let (r, jacobian) = look(Integrals::Closed)?;
    let crossings = guess.contacts(&pair)?[0].intervals.len();
    println!("{speed} rad/s, H = {highest}, {crossings} crossings a turn, equations scaled as solved");
    let mut rows = Vec::new();
    for integrals in [
        Integrals::Kinks,
        Integrals::Panels,
        Integrals::Sampled { samples: 4096 },
        Integrals::Sampled { samples: 65_536 },
    ] {
        let (other, slopes) = look(integrals)?;
        rows.push(vec![
            format!("{integrals:?}"),
            format!("{:.0e}", (other - &r).amax()),
            format!("{:.0e}", (slopes - &jacobian).amax()),
        ]);
    }
    // Differences near the rounding error are those of one machine.
    report.table("integrals", Kind::Full, &["integrals", "residual", "Jacobian"], &rows);
    Ok(())
}

/// Errors over the number of orders, and the ways of integration.
pub fn figures(report: &mut Report) -> Outcome<()> {
    let (orders, speeds) = if coarse() { (&ORDERS[..2], &SPEEDS[..1]) } else { (&ORDERS[..], &SPEEDS[..]) };
    let bar = progress("orders", speeds.len() * orders.len() * WAYS.len());
    let mut panels = Vec::new();
    let mut all: Vec<(f64, Vec<Row>)> = Vec::new();
    let mut reach = Vec::new();
    for &speed in speeds {
        let pair = NfgPair::of_reading(
            &NfgParams { speed, ..NfgParams::table1() },
            NfgReading::published_on_base_radius(),
        )?;
        let needed = needed(&pair)?;
        let (truth, crossings) = truth(&pair)?;
        let cases: Vec<(usize, usize)> =
            (0..WAYS.len()).flat_map(|w| (0..orders.len()).map(move |h| (w, h))).collect();
        let rows: Vec<Row> = cases
            .par_iter()
            .map(|&(w, h)| {
                let row = row(&pair, &truth, orders[h], WAYS[w].1);
                bar.inc(1);
                row
            })
            .collect();
        let low: Vec<usize> = (0..orders.len()).filter(|&h| (orders[h] as f64) < needed).collect();
        let failed = low.iter().filter(|&&h| rows[h].error.is_nan()).count();
        reach.push(vec![
            format!("{speed}"),
            crossings.to_string(),
            format!("{needed:.0}"),
            format!("{failed} of {}", low.len()),
        ]);
        let curve = |w: usize, of: fn(&Row) -> f64| -> Vec<(f64, f64)> {
            orders
                .iter()
                .zip(&rows[w * orders.len()..])
                .map(|(h, r)| (*h as f64, of(r)))
                .filter(|p| p.1.is_finite() && p.1 > 0.0)
                .collect()
        };
        let title = format!("{speed} rad/s, {crossings} crossings");
        let mut panel = Panel::new(title, "orders H [1]", "share of the peak-to-peak value [1]")?;
        for (name, mark, points) in [
            ("error, closed", Mark::Joined, curve(0, |r| r.error)),
            ("|z_H - z_1.3H|", Mark::Dots, curve(0, |r| r.truncation)),
            ("shooting correction", Mark::Dots, curve(0, |r| r.shooting)),
            ("error, M = 4096", Mark::Joined, curve(1, |r| r.error)),
            ("error, M = 65536", Mark::Joined, curve(2, |r| r.error)),
        ] {
            // Where no orbit is found there is nothing to draw.
            if !points.is_empty() {
                panel = panel.series(name, mark, points)?;
            }
        }
        panels.push(panel.logarithmic_y()?);
        all.push((speed, rows));
    }
    bar.finish_and_clear();
    let rows: Vec<Vec<String>> = (0..orders.len())
        .map(|h| {
            let mut cells = vec![orders[h].to_string()];
            cells.extend(all.iter().map(|(_, rows)| {
                let [closed, _, sampled] = [0, 1, 2].map(|w| rows[w * orders.len() + h]);
                format!("{}, {}, {}", short(closed.error), short(closed.truncation), short(sampled.error))
            }));
            cells
        })
        .collect();
    let names: Vec<String> = speeds.iter().map(|speed| format!("{speed} rad/s")).collect();
    let header: Vec<&str> = ["orders H"].into_iter().chain(names.iter().map(String::as_str)).collect();
    report.table("orders_of_a_balance", Kind::Full, &header, &rows);
    #[rustfmt::skip]
    let header = ["speed [rad/s]", "crossings a turn", "orders that reach the largest local natural frequency",
        "Newton fails below them"];
    report.table("orders_needed", Kind::Full, &header, &reach);
    report.csv(
        "convergence.csv",
        "omega_1,integrals,orders,error,truncation,shooting,aliasing,iterations",
        |csv| {
            for (speed, rows) in &all {
                for (i, r) in rows.iter().enumerate() {
                    let (w, h) = (i / orders.len(), i % orders.len());
                    #[rustfmt::skip]
                    csv.row(&[speed, &WAYS[w].0, &orders[h], &r.error, &r.truncation, &r.shooting, &r.aliasing,
                        &r.iterations])?;
                }
            }
            Ok(())
        },
    );
    report.picture("convergence.svg", 2, panels);
    ways_of_integrating(report, 180.0, if coarse() { 100 } else { 500 })
}

/// A number with two digits; `-` if no orbit was found, `fails` if shooting found none.
fn short(x: f64) -> String {
    match x {
        x if x.is_nan() => "-".into(),
        x if x.is_infinite() => "fails".into(),
        x => format!("{x:.1e}"),
    }
}
