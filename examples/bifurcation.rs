//! Bifurcation diagram of the face gear pair of Liu 2021 from 100 to 250 rad/s (reading A of docs/models.md),
//! upwards and downwards with warm starts, with the largest Lyapunov exponent.
//!
//! The output lists the speeds with a positive exponent, with hysteresis and without a period. The pictures
//! show q once a turn and the exponent over the speed, and the range from 145 to 170 rad/s enlarged;
//! `bifurcation.csv` and `lyapunov.csv` contain the numbers.
//!
//! `cargo run --release -p examples --example bifurcation`, with `-- --coarse` for one sixth of the speeds;
//! everything is written to target/gallery/bifurcation/.

mod support;

use gear_dynamics::models::nfg::NfgReading;
use gear_dynamics::sweep::{Axis, Bifurcation, Located, Row, Rows};
use gear_dynamics::{Dop853, Lyapunov, NfgPair, NfgParams, Sweep};
use gear_dynamics_plots::{Mark, Panel, Picture, bifurcation};
use support::{Outcome, coarse, csv_file, gallery};

/// Steps of 0.5 rad/s where the motion is chaotic, larger ones elsewhere.
fn speeds() -> Vec<f64> {
    let span = |from: f64, step: f64, count: usize| (0..count).map(move |i| from + step * i as f64);
    let all = span(100.0, 3.0, 15).chain(span(145.0, 0.5, 50)).chain(span(170.0, 4.0, 21));
    all.step_by(if coarse() { 6 } else { 1 }).collect()
}

pub(crate) fn main() -> Outcome<()> {
    let folder = gallery("bifurcation")?;
    let speeds = Axis::of_values("omega_1", &speeds())?;
    // Exponents for a picture: 40 turns, at a tolerance of 1e-7.
    let exponents = Lyapunov::new().align(3).measure(40).flow_tolerance(1e-7);
    let sweep = Sweep::new(speeds).settle(30).measure(40).lyapunov(exponents);
    let engine = Located(Dop853::new().rtol(1e-8).atol_each(&[1e-13, 1e-14]));
    let diagram = Bifurcation::strobed("q0").run(
        &sweep
            .of(&engine, |p| {
                NfgPair::of_reading(
                    &NfgParams { speed: p["omega_1"], ..NfgParams::table1() },
                    NfgReading::published_on_base_radius(),
                )
            })
            .start(|_, pair| pair.on_drive_flank()),
    )?;

    let mut marked = csv_file(folder.join("bifurcation.csv"), "direction,omega_1,period,q")?;
    let mut grown =
        csv_file(folder.join("lyapunov.csv"), "direction,omega_1,exponent_per_turn,standard_error")?;
    let ways = [("up", diagram.up()), ("down", diagram.down())];
    for ((direction, marks), rows) in ways.into_iter().zip(diagram.rows()) {
        for mark in marks {
            let period = mark.period_multiple.map_or("none".into(), |p| p.to_string());
            for q in &mark.values {
                marked.row(&[&direction, &mark.parameter, &period, q])?;
            }
        }
        for row in rows.iter() {
            if let (Some(exponent), Some(error)) = (row.lyapunov(), row.lyapunov_standard_error()) {
                grown.row(&[&direction, &row.point()["omega_1"], &exponent, &error])?;
            }
        }
        let chaotic = |row: &Row<'_>| {
            row.lyapunov().is_some_and(|exponent| exponent > 0.0).then(|| row.point()["omega_1"])
        };
        let chaotic: Vec<f64> = rows.iter().filter_map(|row| chaotic(&row)).collect();
        if let (Some(first), Some(last)) = (chaotic.first(), chaotic.last()) {
            println!(
                "{direction:5} positive exponent at {} of {} speeds, from {first} to {last} rad/s",
                chaotic.len(),
                marks.len()
            );
        }
        for (index, error) in rows.errors() {
            println!("{direction:5} point {index}: {error}");
        }
    }
    let hysteresis = diagram.hysteresis(0.01)?;
    println!("hysteresis: upwards and downwards end on different motions at {hysteresis:?} rad/s");
    println!(
        "no decision about hysteresis at {:?} rad/s, since a motion does not repeat",
        diagram.undecided()
    );

    const SPEED: &str = "pinion speed [rad/s]";
    let differing = hysteresis.iter().filter_map(|s| diagram.up().iter().find(|m| m.parameter == *s));
    let differing: Vec<(f64, f64)> = differing.map(|mark| (mark.parameter, mark.values[0])).collect();
    let exponents = |rows: &Rows| -> Vec<(f64, f64)> {
        rows.iter().filter_map(|row| Some((row.point()["omega_1"], row.lyapunov()?))).collect()
    };
    let [up, down] = diagram.rows().map(exponents);
    let mut panels = Vec::new();
    for (from, to) in [(100.0, 250.0), (145.0, 170.0)] {
        let strobed =
            bifurcation(&diagram, [SPEED, "q [rad]"])?.title("q once in every turn of the face gear");
        let strobed = if differing.is_empty() {
            strobed
        } else {
            strobed.series("hysteresis", Mark::Dots, differing.clone())?
        };
        let exponent = Panel::new("largest Lyapunov exponent", SPEED, "exponent per turn [1]")?
            .series("upwards", Mark::Line, up.clone())?
            .series("downwards", Mark::Line, down.clone())?
            .name_y(&[(0.0, "chaos above")])?;
        panels.extend([strobed.x_range(from, to)?, exponent.x_range(from, to)?]);
    }
    Picture::new(panels).columns(2).save(folder.join("bifurcation.svg"))?;
    println!("pictures and tables: {}", folder.display());
    Ok(())
}
