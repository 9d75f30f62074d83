//! Time of the general solvers on workloads A, B3 and B16, compared with loops written by hand for workload
//! A: `cargo bench --bench solvers`. The last lines are work, errors and ratios of times.

mod common;

use common::{Pair, hand_dop853, hand_rk4, ratio, ring};
use criterion::{Criterion, criterion_group};
use gear_dynamics::ode::{Finish, Step};
use gear_dynamics::{Dop853, Integrator, Model, Rk4, Rk45, State};
use std::hint::black_box;
use std::ops::ControlFlow;

fn run<I: Integrator, M: Model>(solver: &I, model: &M, start: &State, end: f64) -> Finish {
    solver
        .run(model, start, end, &mut |_: &mut Step<'_>| ControlFlow::Continue(()))
        .expect("the workloads run")
}

fn steps(pair: &Pair) -> usize {
    (pair.end() / pair.step()).round() as usize
}

/// RK4 by hand over workload A.
fn by_hand(pair: &Pair) -> [f64; 2] {
    hand_rk4(black_box(pair), -6.4e-4, 0.0, pair.step(), steps(pair))
}

fn adaptive() -> Dop853 {
    Dop853::new().rtol(1e-8).atol(1e-12)
}

fn workload_a(c: &mut Criterion) {
    let (pair, start) = (Pair::new(), Pair::start());
    let mut group = c.benchmark_group("A");
    group.sample_size(20);
    group.bench_function("RK4, by hand", |b| b.iter(|| by_hand(&pair)));
    group.bench_function("RK4, plain steps", |b| {
        b.iter(|| run(&Rk4::new(pair.step()).plain(), black_box(&pair), &start, pair.end()))
    });
    group.bench_function("RK4, located edges", |b| {
        b.iter(|| run(&Rk4::new(pair.step()), black_box(&pair), &start, pair.end()))
    });
    group.bench_function("DOP853, by hand", |b| {
        b.iter(|| hand_dop853::run(black_box(&pair), -6.4e-4, 0.0, pair.end(), 1e-8, 1e-12))
    });
    group.bench_function("DOP853, located edges", |b| {
        b.iter(|| run(&adaptive(), black_box(&pair), &start, pair.end()))
    });
    group.bench_function("RK45, located edges", |b| {
        b.iter(|| run(&Rk45::new().rtol(1e-8).atol(1e-12), black_box(&pair), &start, pair.end()))
    });
    group.finish();
}

fn workloads_b(c: &mut Criterion) {
    let mut group = c.benchmark_group("B");
    group.sample_size(10);
    for gears in [3, 16] {
        let (ring, start) = (ring(gears, 2.0), State::at_rest(2 * gears + 1));
        group.bench_function(format!("B{gears}, DOP853, located edges"), |b| {
            b.iter(|| run(&adaptive(), black_box(&ring), &start, common::RING_END))
        });
        group.bench_function(format!("B{gears}, RK4, plain steps"), |b| {
            b.iter(|| run(&Rk4::new(2e-6).plain(), black_box(&ring), &start, common::RING_END))
        });
    }
    group.finish();
}

/// Prints the evaluations of the accelerations and the errors with located edges, on the three workloads.
/// Errors are shares of 1e-5 (deflection of A), of 1e-4 rad (angles of B) and of 1 rad/s (its speeds).
fn work_and_error() {
    println!("\nevaluations and errors, DOP853 rtol 1e-8, atol 1e-12, against rtol 1e-13");
    let pair = Pair::new();
    let truth = run(&Dop853::new().rtol(1e-13).atol(1e-18), &pair, &Pair::start(), pair.end()).state;
    let finish = run(&adaptive(), &pair, &Pair::start(), pair.end());
    let error = (finish.state.q[0] - truth.q[0]).abs() / 1e-5;
    println!(
        "A    {:7} evaluations, {:4} edges, error {error:.1e}",
        finish.stats.evaluations, finish.stats.crossings
    );
    for (gears, torque) in [(3, 2.0), (16, 40.0)] {
        let (ring, n) = (ring(gears, torque), 2 * gears + 1);
        let tight = Dop853::new().rtol(1e-13).atol_each(&[vec![1e-19; n], vec![1e-15; n]].concat());
        let truth = run(&tight, &ring, &State::at_rest(n), common::RING_END).state;
        let finish = run(&adaptive(), &ring, &State::at_rest(n), common::RING_END);
        let worst = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
        let error = (worst(&finish.state.q, &truth.q) / 1e-4).max(worst(&finish.state.v, &truth.v));
        println!(
            "B{gears:<3} {:7} evaluations, {:4} edges, error {error:.1e} (load {torque} N m)",
            finish.stats.evaluations, finish.stats.crossings
        );
    }
}

/// Prints median, minimum and maximum of ratios of times: the general solver over the loop by hand.
fn ratios() {
    let (pair, start) = (Pair::new(), Pair::start());
    let rk4 = Rk4::new(pair.step()).plain();
    let [median, least, most] =
        ratio(41, || drop(black_box(run(&rk4, &pair, &start, pair.end()))), || _ = black_box(by_hand(&pair)));
    println!("\nratio solvers rk4 hand {median:.3} ({least:.3} .. {most:.3})");
    let machine = pair.machine();
    let [median, least, most] = ratio(
        41,
        || drop(black_box(run(&rk4, &machine, &start, pair.end()))),
        || _ = black_box(by_hand(&pair)),
    );
    println!("ratio solvers rk4 of a shape hand {median:.3} ({least:.3} .. {most:.3})");
    let ours = run(&adaptive(), &pair, &start, pair.end());
    let (hand, evaluations, crossings) = hand_dop853::run(&pair, -6.4e-4, 0.0, pair.end(), 1e-8, 1e-12);
    let [median, least, most] = ratio(
        41,
        || drop(black_box(run(&adaptive(), &pair, &start, pair.end()))),
        || _ = black_box(hand_dop853::run(&pair, -6.4e-4, 0.0, pair.end(), 1e-8, 1e-12)),
    );
    let per = evaluations as f64 / ours.stats.evaluations as f64;
    println!(
        "ratio solvers dop853 hand per evaluation {:.3} ({:.3} .. {:.3}); {} against {evaluations} \
         evaluations, {} against {crossings} edges, difference at the end {:.3e}",
        median * per,
        least * per,
        most * per,
        ours.stats.evaluations,
        ours.stats.crossings,
        (ours.state.q[0] - hand[0]).abs()
    );
}

criterion_group!(benches, workload_a, workloads_b);

fn main() {
    benches();
    work_and_error();
    ratios();
}
