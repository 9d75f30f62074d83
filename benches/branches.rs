//! Time of whole frequency responses by continuation, with the multipliers of every point: the workloads D
//! of the comparison with other programs. `cargo bench --bench branches`.
//!
//! - Duffing: q'' + 0.05 q' + q + 0.1 q³ = 0.18 cos Ω t, Ω = 0.5 .. 1.6 (example 1 of NLvib);
//! - dead zone: q'' + 0.1 q' + g(q) = 0.25 + 0.25 cos Ω t with the half width 1, Ω = 2.5 .. 0.4.
//!
//! By harmonic balance with the orders 0 .. 10 and exact switching, and by shooting.

use gear_dynamics::branches::{Branch, Continuation, Family};
use gear_dynamics::models::Oscillator;
use gear_dynamics::periodic::FourierOrbit;
use gear_dynamics::{Balance, Harmonics, Periodic, State};
use std::time::Instant;

fn report(name: &str, model: &Oscillator, continuation: &Continuation, others: &[(&str, f64)], start: f64) {
    let family = Family::over(model, ["speed"]).expect("a constant");
    let with_balance = continuation.clone().balance(Balance::new(Harmonics::up_to(10)));
    let guess =
        FourierOrbit::new(&Harmonics::up_to(1), model.period(), &[vec![start, 0.1, 0.1]]).expect("finite");
    // The default steps, then shorter ones, with about as many points as the others compute.
    let short = with_balance.clone().first_step(0.004).max_step(0.018);
    for (steps, continuation) in [("default steps", &with_balance), ("short steps", &short)] {
        let by_balance = || continuation.run(&family, &guess).expect("an orbit");
        let branch = by_balance();
        if !std::ptr::eq(continuation, &short) {
            println!("{name}: {branch}");
        }
        let milliseconds = least(50, || drop(by_balance()));
        println!("  balance, {steps}: {} points in {milliseconds:.2} ms", branch.points().len());
        for (other, theirs) in others {
            println!("    {other}: {theirs} ms, {:.1} times as long", theirs / milliseconds);
        }
    }
    let by_shooting = || continuation.run(&family, &State::new(0.0, &[start], &[0.0])).expect("an orbit");
    let branch: Branch = by_shooting();
    let milliseconds = least(5, || drop(by_shooting()));
    println!("  shooting: {} points in {milliseconds:.2} ms\n", branch.points().len());
}

/// Least time of several runs in milliseconds.
fn least(runs: usize, mut run: impl FnMut()) -> f64 {
    let time = |run: &mut dyn FnMut()| {
        let begun = Instant::now();
        run();
        1e3 * begun.elapsed().as_secs_f64()
    };
    (0..runs).map(|_| time(&mut run)).fold(f64::INFINITY, f64::min)
}

fn main() {
    // `cargo test --benches` runs each bench with this argument: it does not measure.
    if std::env::args().any(|arg| arg == "--test") {
        return;
    }
    // Times of the others: CPU time of another machine, release builds, with about 200 .. 260 points.
    let duffing = [("damping", 0.05), ("linear stiffness", 1.0), ("cubic stiffness", 0.1), ("force", 0.18)];
    let duffing = Oscillator::new(&[&[("speed", 0.5)], &duffing[..]].concat()).expect("valid");
    let others = [("AUTO-07p, with stability", 50.0), ("pyHarm 1.2.2, without stability", 380.0)];
    report("Duffing", &duffing, &Continuation::new(0.5, 1.6), &others, 0.0);
    let dead_zone = [("damping", 0.1), ("mesh stiffness", 1.0), ("half backlash", 1.0)];
    let forces = [("speed", 2.5), ("mean force", 0.25), ("force", 0.25)];
    let dead_zone = Oscillator::new(&[dead_zone, forces].concat()).expect("valid");
    let others = [("AUTO-07p, with stability", 145.0), ("pyHarm 1.2.2, without stability", 590.0)];
    report("dead zone", &dead_zone, &Continuation::new(2.5, 0.4), &others, 1.2);
}
