//! Error of the harmonic balance and its estimates over the number of orders H, for the face gear pair of Liu
//! 2021 (reading A of docs/models.md) at four speeds: without rattle, with unilateral and with bilateral
//! rattle.
//!
//! The reference is the orbit polished by shooting. Its projection is the guess at every H, so that the error
//! is that of the equations and not of the search. The tables and pictures show, as shares of the
//! peak-to-peak value, the error with closed and with sampled integrals and the estimates |z_H - z_1.3H| and
//! first correction of shooting; `convergence.csv` contains them.
//!
//! `cargo run --release -p examples --example balance_convergence`; everything is written to
//! target/gallery/balance_convergence/.

mod support;

use gear_dynamics::models::nfg::NfgReading;
use gear_dynamics::periodic::{FourierOrbit, Integrals, Proof};
use gear_dynamics::roots::Residual;
use gear_dynamics::{Balance, Dop853, Harmonics, NfgPair, NfgParams, Settle, Shooting, State};
use nalgebra::{DMatrix, DVector};
use plotters::prelude::SeriesLabelPosition;
use rayon::prelude::*;
use support::{Mark, Outcome, Panel, csv_file, figure, gallery, progress};

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
    let steady = Settle::new().tolerance(1e-6).run(&solver(), pair, &pair.static_start()?)?;
    let cycle =
        Shooting::new().multiple(steady.period_multiple).solve(pair, &[State { t: 0.0, ..steady.state }])?;
    let fine = Dop853::new().rtol(1e-13).atol_each(&[1e-18, 1e-19]);
    Ok((FourierOrbit::project(&fine, pair, &cycle.states()[0], &Harmonics::up_to(4000))?, cycle.crossings()))
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
    match balance.prove(pair, &orbit) {
        Ok(Proof { truncation, shooting, aliasing, .. }) => {
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
    let stiffness = load / (-pair.static_start()?.q[0] - pair.half_width());
    Ok(1.2 * stiffness.sqrt() / pair.centre_frequency())
}

/// Prints the differences of residual and Jacobian between the ways of integration, at the projected orbit.
fn ways_of_integrating(speed: f64, highest: usize) -> Outcome<()> {
    let pair = NfgPair::with_reading(
        &NfgParams { speed, ..NfgParams::table1() },
        NfgReading::published_on_base_radius(),
    )?;
    let steady = Settle::new().tolerance(1e-7).run(&solver(), &pair, &pair.static_start()?)?;
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
    let switches = guess.contacts(&pair)?[0].intervals.len();
    println!(
        "\n{speed} rad/s, H = {highest}, {switches} switches a turn: maximum difference from closed \
         integrals, equations scaled as solved"
    );
    for integrals in [
        Integrals::Kinks,
        Integrals::Panels,
        Integrals::Sampled { samples: 4096 },
        Integrals::Sampled { samples: 65_536 },
    ] {
        let (other, slopes) = look(integrals)?;
        println!(
            "  {:28} residual {:.0e}, Jacobian {:.0e}",
            format!("{integrals:?}"),
            (other - &r).amax(),
            (slopes - &jacobian).amax()
        );
    }
    Ok(())
}

fn main() -> Outcome<()> {
    let folder = gallery("balance_convergence")?;
    let bar = progress("orders", SPEEDS.len() * ORDERS.len() * WAYS.len());
    let mut csv = csv_file(
        folder.join("convergence.csv"),
        "omega_1,integrals,orders,error,truncation,shooting,aliasing,iterations",
    )?;
    let mut panels = Vec::new();
    let mut failures = [0, 0];
    for speed in SPEEDS {
        let pair = NfgPair::with_reading(
            &NfgParams { speed, ..NfgParams::table1() },
            NfgReading::published_on_base_radius(),
        )?;
        let needed = needed(&pair)?;
        let (truth, crossings) = truth(&pair)?;
        let cases: Vec<(usize, usize)> =
            (0..WAYS.len()).flat_map(|w| (0..ORDERS.len()).map(move |h| (w, h))).collect();
        let rows: Vec<Row> = cases
            .par_iter()
            .map(|&(w, h)| {
                let row = row(&pair, &truth, ORDERS[h], WAYS[w].1);
                bar.inc(1);
                row
            })
            .collect();
        bar.suspend(|| {
            println!(
                "\n{speed} rad/s, {crossings} crossings a turn: errors as shares of the peak-to-peak value\n"
            );
            println!(
                "{:>6}  {:>10} {:>10} {:>10}   {:>13} {:>14}",
                "orders", "error", "|zH-z1.3H|", "shooting", WAYS[1].0, WAYS[2].0
            );
            for (h, &orders) in ORDERS.iter().enumerate() {
                let [closed, coarse, fine] = [0, 1, 2].map(|w| rows[w * ORDERS.len() + h]);
                println!(
                    "{orders:6}  {:>10} {:>10} {:>10}   {:>13} {:>14}",
                    short(closed.error),
                    short(closed.truncation),
                    short(closed.shooting),
                    short(coarse.error),
                    short(fine.error)
                );
            }
            let low: Vec<usize> = (0..ORDERS.len()).filter(|&h| (ORDERS[h] as f64) < needed).collect();
            let failed = low.iter().filter(|&&h| rows[h].error.is_nan()).count();
            failures = [failures[0] + failed, failures[1] + low.len()];
            let slope = (rows[7].error / rows[5].error).ln() / (ORDERS[7] as f64 / ORDERS[5] as f64).ln();
            println!(
                "{needed:.0} orders reach the maximum local natural frequency; Newton fails at {failed} of \
                 {} below",
                low.len()
            );
            println!("from {} to {} orders the error is proportional to H^{slope:.1}", ORDERS[5], ORDERS[7]);
        });
        for (&(w, h), r) in cases.iter().zip(&rows) {
            csv.row(&[
                &speed,
                &WAYS[w].0,
                &ORDERS[h],
                &r.error,
                &r.truncation,
                &r.shooting,
                &r.aliasing,
                &r.iterations,
            ])?;
        }
        let curve = |w: usize, of: fn(&Row) -> f64| -> Vec<(f64, f64)> {
            ORDERS
                .iter()
                .zip(&rows[w * ORDERS.len()..])
                .map(|(h, r)| (*h as f64, of(r).log10()))
                .filter(|p| p.1.is_finite())
                .collect()
        };
        let panel =
            Panel::new(format!("{speed} rad/s, {crossings} crossings"), "orders H", "share of peak-to-peak")
                .decades();
        let panel = panel.labels_at(SeriesLabelPosition::UpperRight);
        panels.push(
            panel
                .with("error, closed", Mark::Line, curve(0, |r| r.error))
                .with("|z_H - z_1.3H|", Mark::Dots, curve(0, |r| r.truncation))
                .with("shooting correction", Mark::Dots, curve(0, |r| r.shooting))
                .with("error, M = 4096", Mark::Line, curve(1, |r| r.error))
                .with("error, M = 65536", Mark::Line, curve(2, |r| r.error)),
        );
    }
    bar.finish_and_clear();
    figure(folder.join("convergence.svg"), 2, &panels)?;
    println!(
        "\nbelow 1.2 √(max F)/ω_c orders, started on the reference, Newton fails {} times of {}",
        failures[0], failures[1]
    );
    ways_of_integrating(180.0, 500)?;
    println!("\n-: no orbit found from the reference. pictures and tables: {}", folder.display());
    Ok(())
}

/// A number with two digits; `-` if no orbit was found, `fails` if shooting found none.
fn short(x: f64) -> String {
    match x {
        x if x.is_nan() => "-".into(),
        x if x.is_infinite() => "fails".into(),
        x => format!("{x:.1e}"),
    }
}
