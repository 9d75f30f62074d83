//! Basins of attraction of a spur pair with a dead zone that has two coexisting motions.
//!
//! The table lists the motions at four frequencies, with the share of the starts that lead to each, and the
//! shares of the rattle states over the amplitude of the torque. The pictures show which motion each start
//! (q, v) reaches; `basins.csv` and `amplitudes.csv` contain the tables.
//!
//! `cargo run --release -p examples --example basins`, with `-- --coarse` for a sixteenth of the starts; everything is
//! written to target/gallery/basins/.

mod support;

use gear_dynamics::models::Oscillator;
use gear_dynamics::sweep::{Attractors, Axis, LaneRk4, Points, Row};
use gear_dynamics::{RattleState, State, Sweep};
use gear_dynamics_plots::{Picture, category_map};
use support::{Outcome, coarse, csv_file, gallery};

pub(crate) fn main() -> Outcome<()> {
    let side = if coarse() { 50 } else { 200 };
    let folder = gallery("basins")?;
    let mut csv = csv_file(folder.join("basins.csv"), "omega,attractor,period,q,v,share")?;
    let mut panels = Vec::new();
    // x'' + 0.1 x' + g(x) = 0.25 + P cos Ωt, g the dead zone of half width 1: a spur pair under a pulsating torque.
    // Below its resonance a small motion and a large one, which touches both flanks, coexist.
    let pair = Oscillator::new(&[
        ("speed", 0.69),
        ("damping", 0.1),
        ("mesh stiffness", 1.0),
        ("mean force", 0.25),
        ("force", 0.25),
        ("half backlash", 1.0),
    ])?;
    for omega in [0.66, 0.69, 0.72, 0.75] {
        let starts =
            Points::grid(vec![Axis::linear("q", -4.0, 4.0, side)?, Axis::linear("v", -4.0, 4.0, side)?])?;
        let rows = Sweep::new(starts)
            .settle(100)
            .measure(20)
            .strobe(16)
            .of(&LaneRk4::new(256), |_| pair.with("speed", omega))
            .start(|p, _| State::new(0.0, &[p["q"]], &[p["v"]]))
            .run()?;
        let attractors = Attractors::find(&rows, 1e-4)?;
        println!("Ω = {omega}: {} motions", attractors.all().len());
        for (i, one) in attractors.all().iter().enumerate() {
            let share = one.rows as f64 / (side * side) as f64;
            let period = one.period_multiple.map_or("none".into(), |p| p.to_string());
            let state = one.states.first().cloned().unwrap_or_else(|| vec![f64::NAN; 2]);
            println!(
                "  {i}: period {period:4} at q = {:8.5}, v = {:8.5}, from {:5.1}% of the starts",
                state[0],
                state[1],
                100.0 * share
            );
            csv.row(&[&omega, &i, &period, &state[0], &state[1], &share])?;
        }
        let names: Vec<String> = (0..attractors.all().len()).map(|i| format!("motion {i}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let panel =
            category_map(&rows, ["q(0) [1]", "v(0) [1]"], &names, |row| attractors.label(row.index()))?;
        panels.push(panel.title(format!("Ω = {omega}: the motion reached, by start")));
    }
    Picture::new(panels).columns(2).panel_size(420.0, 420.0).save(folder.join("basins.svg"))?;

    // The amplitude is a constant of the machine: one drive table serves all starts at all amplitudes.
    let few = if coarse() { 12 } else { 50 };
    let amplitudes = Axis::linear("amplitude", 0.08, 0.32, 13)?;
    let axes =
        vec![amplitudes.clone(), Axis::linear("q", -4.0, 4.0, few)?, Axis::linear("v", -4.0, 4.0, few)?];
    let rows = Sweep::new(Points::grid(axes)?)
        .settle(100)
        .measure(20)
        .rattle()
        .of(&LaneRk4::new(256), |p| pair.with("force", p["amplitude"]))
        .start(|p, _| State::new(0.0, &[p["q"]], &[p["v"]]))
        .run()?;
    println!(
        "Ω = 0.69, {} runs, {} of them without lanes: shares of the rattle states",
        rows.iter().count(),
        rows.alone()
    );
    let mut csv = csv_file(folder.join("amplitudes.csv"), "amplitude,none,unilateral,bilateral")?;
    for amplitude in amplitudes.values() {
        let share = |state: RattleState| {
            let ends = |row: &Row<'_>| {
                row.point()["amplitude"] == *amplitude && row.contacts()[0].rattle_state() == state
            };
            100.0 * rows.iter().filter(ends).count() as f64 / (few * few) as f64
        };
        let [none, one, both] =
            [RattleState::None, RattleState::Unilateral, RattleState::Bilateral].map(share);
        println!(
            "  amplitude {amplitude:.2}: no rattle {none:5.1}%, unilateral {one:5.1}%, bilateral {both:5.1}%"
        );
        csv.row(&[amplitude, &none, &one, &both])?;
    }
    println!("pictures and tables: {}", folder.display());
    Ok(())
}
