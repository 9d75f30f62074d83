//! The face gear pair from 100 to 250 rad/s, up and down, each run starting from where the one before it ended (reading A of docs/models.md).
//!
//! `cargo run --release --example bifurcation`

mod support;

use gear_dynamics::{Axis, Bifurcation, Dop853, Located, Mark as Marked, Marks, NfgPair, NfgParams, NfgReading};
use support::{Csv, Mark, Outcome, Panel, figure, gallery};

fn main() -> Outcome<()> {
    let folder = gallery("bifurcation")?;
    let speeds = Axis::linear("omega_1", 100.0, 250.0, 151)?;
    let diagram = Bifurcation::over(speeds, "q1", Marks::Strobed).settle(30).measure(40).run(
        &Located(Dop853::new().rtol(1e-9).atol_each(&[1e-14, 1e-15])),
        |p| NfgPair::with_reading(&NfgParams { speed: p["omega_1"], ..NfgParams::table1() }, NfgReading::published_on_base_radius()),
        |_, pair| pair.static_start(),
    )?;

    let mut csv = Csv::new(folder.join("bifurcation.csv"), "direction,omega_1,period,q")?;
    for (direction, marks) in [("up", diagram.up()), ("down", diagram.down())] {
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
    let period = |marks: &[Marked]| marks.iter().map(|m| (m.parameter, m.period.unwrap_or(0) as f64)).collect();
    let periods = Panel::new("period of the motion in turns, 0 when it does not repeat", "pinion speed [rad/s]", "turns")
        .with("up", Mark::Dots, period(diagram.up()))
        .with("down", Mark::Dots, period(diagram.down()));
    figure(folder.join("bifurcation.svg"), 1, &[panel, periods])?;
    println!("pictures and tables: {}", folder.display());
    Ok(())
}
