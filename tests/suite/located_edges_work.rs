//! Work and error of runs with located edges on the benchmark problems (benches/common): DOP853 at rtol 1e-8
//! and atol 1e-12 against rtol 1e-13. The numbers are upper bounds on the evaluations of the accelerations
//! and on the error at the end; errors are shares of 1e-5 (deflection of the pair), of 1e-4 rad (angles of
//! the ring) and of 1 rad/s (its speeds).

use crate::api::*;
use crate::benchmarks::{Pair, RING_END, Unheld, ring};
use std::ops::ControlFlow;

fn run<M: Model>(solver: &Dop853, model: &M, start: &State, end: f64) -> Finish {
    solver.run(model, start, end, &mut |_: &mut Step<'_>| ControlFlow::Continue(())).unwrap()
}

fn adaptive() -> Dop853 {
    Dop853::new().rtol(1e-8).atol(1e-12)
}

#[test]
fn the_rattling_pair() {
    let pair = Pair::new();
    let truth = run(&Dop853::new().rtol(1e-13).atol(1e-18), &pair, &Pair::start(), pair.end()).state;
    let error = |finish: &Finish| (finish.state.q[0] - truth.q[0]).abs() / 1e-5;
    let held = run(&adaptive(), &pair, &Pair::start(), pair.end());
    assert!(held.stats.evaluations <= 550_000 && error(&held) <= 1e-6, "{:?}: {}", held.stats, error(&held));
    // Without fixed pieces edges are found by stepping again: the same crossings and accuracy.
    let unheld = run(&adaptive(), &Unheld(Pair::new()), &Pair::start(), pair.end());
    assert!(
        error(&unheld) <= 1e-6 && unheld.stats.crossings == held.stats.crossings,
        "{:?}: {}",
        unheld.stats,
        error(&unheld)
    );
    // Steps across the edges cost at least 10 % more evaluations.
    let plain = run(&adaptive().plain(), &pair, &Pair::start(), pair.end());
    assert!(plain.stats.evaluations as f64 > 1.1 * held.stats.evaluations as f64, "{:?}", plain.stats);
}

#[test]
fn rings_of_3_and_16() {
    for (gears, torque, evaluations, bound) in [(3, 2.0, 130_000, 1e-8), (16, 40.0, 150_000, 3e-6)] {
        let (ring, n) = (ring(gears, torque), 2 * gears + 1);
        let tight = Dop853::new().rtol(1e-13).atol_each(&[vec![1e-19; n], vec![1e-15; n]].concat());
        let truth = run(&tight, &ring, &State::at_rest(n), RING_END).state;
        let finish = run(&adaptive(), &ring, &State::at_rest(n), RING_END);
        let worst = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
        let error = (worst(&finish.state.q, &truth.q) / 1e-4).max(worst(&finish.state.v, &truth.v));
        println!("{gears}: {:?}, error {error:.1e}", finish.stats);
        assert!(
            finish.stats.evaluations <= evaluations && error <= bound,
            "{gears}: {:?}, error {error}",
            finish.stats
        );
    }
}
