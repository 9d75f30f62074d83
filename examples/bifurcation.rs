//! The face gear pair from 100 to 250 rad/s, up and down, each run starting from where the one before it ended (reading A of docs/models.md),
//! and the largest Lyapunov exponent beneath.
//!
//! `cargo run --release --example bifurcation`

mod support;

use gear_dynamics::{Axis, Bifurcation, Dop853, Located, Lyapunov, Mark as Marked, Marks, NfgPair, NfgParams, NfgReading, Rows};
use support::{Csv, Mark, Outcome, Panel, figure, gallery};

fn main() -> Outcome<()> {
    let folder = gallery("bifurcation")?;
    let speeds = Axis::linear("omega_1", 100.0, 250.0, 151)?;
    let diagram = Bifurcation::over(speeds, "q1", Marks::Strobed).settle(30).measure(40);
    // For a picture, not for digits: the flow held to 1e-7, 60 turns.
    let diagram = diagram.lyapunov(Lyapunov::new().align(3).periods(60).tolerance(1e-7)).run(
        &Located(Dop853::new().rtol(1e-9).atol_each(&[1e-14, 1e-15])),
        |p| NfgPair::with_reading(&NfgParams { speed: p["omega_1"], ..NfgParams::table1() }, NfgReading::published_on_base_radius()),
        |_, pair| pair.static_start(),
    )?;

    let mut csv = Csv::new(folder.join("bifurcation.csv"), "direction,omega_1,period,q")?;
    let mut exponents = Csv::new(folder.join("lyapunov.csv"), "direction,omega_1,exponent_per_turn,standard_error")?;
    for ((direction, marks), rows) in [("up", diagram.up()), ("down", diagram.down())].into_iter().zip(diagram.rows()) {
        for row in rows.iter() {
            let (exponent, error) = (row.lyapunov().unwrap_or(f64::NAN), row.lyapunov_error().unwrap_or(f64::NAN));
            exponents.row(&[&direction, &row.point()["omega_1"], &exponent, &error])?;
        }
        for mark in marks {
            let period = mark.period.map_or("none".into(), |p| p.to_string());
            for q in &mark.values {
                csv.row(&[&direction, &mark.parameter, &period, q])?;
            }
        }
        let aperiodic: Vec<f64> = marks.iter().filter(|m| m.period.is_none()).map(|m| m.parameter).collect();
        if let (Some(first), Some(last)) = (aperiodic.first(), aperiodic.last()) {
            println!("{direction:5} no period at {} of {} speeds, from {first} to {last} rad/s", aperiodic.len(), marks.len());
        }
    }
    let hysteresis = diagram.hysteresis(0.01);
    println!("the two ways end on different motions at {hysteresis:?} rad/s");

    let dots = |marks: &[Marked]| marks.iter().flat_map(|m| m.values.iter().map(|q| (m.parameter, *q))).collect();
    let points: Vec<(f64, f64)> =
        hysteresis.iter().filter_map(|s| diagram.up().iter().find(|m| m.parameter == *s)).map(|m| (m.parameter, m.values[0])).collect();
    let mut panel = Panel::new("q once in every turn of the face gear, 40 turns", "pinion speed [rad/s]", "q [rad]")
        .with("up", Mark::Specks, dots(diagram.up()))
        .with("down", Mark::Specks, dots(diagram.down()));
    if !points.is_empty() {
        panel = panel.with("hysteresis", Mark::Dots, points);
    }
    let exponent = |rows: &Rows| rows.iter().map(|row| (row.point()["omega_1"], row.lyapunov().unwrap_or(f64::NAN))).collect::<Vec<_>>();
    let [up, down] = diagram.rows().map(exponent);
    let ends = [100.0, 250.0].map(|speed| (speed, 0.0)).to_vec();
    let exponents = Panel::new("largest Lyapunov exponent per turn of the face gear", "pinion speed [rad/s]", "[1]")
        .with("up", Mark::Line, up)
        .with("down", Mark::Line, down)
        .with("chaos above", Mark::Line, ends);
    figure(folder.join("bifurcation.svg"), 1, &[panel, exponents])?;
    println!("pictures and tables: {}", folder.display());
    Ok(())
}
