//! Prints a fingerprint of each of some random sweeps: `bits SEED`. The number of threads must not change it.

use gear_dynamics::sweep::bounds::SweepEngine;
use gear_dynamics::sweep::{Axis, LaneRk4, LaneTaylor, Point, TableRk4};
use gear_dynamics::{Model, ParameterError, Periodic, State, Sweep, Taylor, trains::Train};
use search::draw::Draw;
use search::models::pair::Pair;

/// Number of sweeps with each engine.
const SWEEPS: u64 = 8;

/// Number of points of a sweep: more than the lanes of all threads.
const POINTS: usize = 150;

fn print<E: SweepEngine<Train>>(name: &str, train: &Train, engine: &E) -> Result<(), String> {
    let told = |error: &dyn std::fmt::Display| error.to_string();
    let points = Axis::linear("speed", 0.5, 2.4, POINTS).map_err(|error| told(&error))?;
    let sweep = Sweep::new(points).settle(10).measure(4).channels(&["deflection", "mesh force"]).rattle();
    let sweep = sweep.of(engine, |p| train.with("speed", p["speed"]));
    let start = |_: &Point<'_>, model: &Train| Ok::<_, ParameterError>(State::at_rest(model.dof()));
    let rows = sweep.start(start).run().map_err(|error| told(&error))?;
    println!("{name} {:x} {}", rows.fingerprint(), train.period());
    Ok(())
}

fn run(seed: u64) -> Result<(), String> {
    for index in 0..SWEEPS {
        let train = Pair::draw(&mut Draw::new(seed, "bits", index, false)).at(0.5);
        let train = train.map_err(|error| error.to_string())?;
        print("LaneRk4", &train, &LaneRk4::new(64))?;
        print("TableRk4", &train, &TableRk4::new(64))?;
        print("LaneTaylor", &train, &LaneTaylor::new(Taylor::new()))?;
    }
    Ok(())
}

fn main() -> std::process::ExitCode {
    let seed = std::env::args().nth(1).and_then(|seed| seed.parse().ok()).unwrap_or(1);
    match run(seed) {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            std::process::ExitCode::FAILURE
        }
    }
}
