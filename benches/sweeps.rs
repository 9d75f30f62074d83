//! Time of sweeps: workload C (many runs of workload A) and rings in lanes, per trajectory and per
//! evaluation, with statistics, on one thread; the gain of a second thread; and whether lanes still compile
//! to vector instructions. `cargo bench --bench sweeps`. Other crates on the same problems: `cargo bench -p
//! peers`.

mod common;

use common::{Pair, Rattling, ratio, ring};
use criterion::{Criterion, criterion_group};
use gear_dynamics::sweep::{
    Axis, InstructionSet, LaneRk4, Point, Points, Rows, TableRk4, bounds::SweepEngine,
};
use gear_dynamics::{Machine, Model, ParameterError, Ring, State, Sweep};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Steps per period of the pair: 64 per mesh period.
const STEPS: usize = 63 * 64;
/// Periods of a run.
const PERIODS: usize = 20;

fn ensemble(count: usize) -> Sweep {
    ensemble_over(count, PERIODS)
}

fn ensemble_over(count: usize, periods: usize) -> Sweep {
    let points = Points::from(Axis::linear("we", 0.15, 0.36, count).expect("the range is in order"));
    Sweep::new(points).settle(0).measure(periods).channels(&["q0"]).rattle()
}

fn run(sweep: &Sweep, engine: &impl SweepEngine<Machine<Rattling>>) -> Rows {
    let pair = Pair::new().machine();
    let rows = sweep.of(engine, |p| pair.with("wc", p["we"] / 63.0)).start(|_, _| Pair::start()).run();
    rows.expect("the workload runs")
}

fn one_thread<T: Send>(f: impl FnOnce() -> T + Send) -> T {
    threads(1, f)
}

fn threads<T: Send>(count: usize, f: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("threads start").install(f)
}

/// Minimum times of two jobs that run alternately. Many short jobs are timed, since other work on the machine
/// only adds to their times.
fn least(rounds: usize, mut jobs: [&mut dyn FnMut(); 2]) -> [f64; 2] {
    let mut least = [f64::INFINITY; 2];
    for _ in 0..rounds {
        for (job, least) in jobs.iter_mut().zip(&mut least) {
            let start = Instant::now();
            job();
            *least = least.min(start.elapsed().as_secs_f64());
        }
    }
    least
}

/// Prints the time of one batch of W runs. The time per run is that of additional periods, so that the drive
/// table, which many runs share, is not counted; the time of the table is printed separately.
fn report<const W: usize>(set: InstructionSet) {
    let engine = LaneRk4::new(STEPS).lanes::<W>().instructions(set);
    let sweeps = [5, 20].map(|periods| ensemble_over(W, periods));
    let job = |sweep| drop(black_box(run(sweep, &engine)));
    let [short, long] = one_thread(|| least(100, [&mut || job(&sweeps[0]), &mut || job(&sweeps[1])]));
    let each = (long - short) / (15 * W) as f64;
    let table = short - each * (5 * W) as f64;
    let (per_run, per_evaluation) = (1e3 * each * PERIODS as f64, 1e9 * each / (4 * STEPS) as f64);
    println!(
        "pair, W = {W:2}, {set:?}: {per_run:.3} ms per trajectory, {per_evaluation:.3} ns per evaluation; \
         table {:.2} ms",
        1e3 * table
    );
}

fn ring_sweep(gears: usize, count: usize, periods: usize, engine: &impl SweepEngine<Ring>) -> Rows {
    let torques = Axis::linear("torque", 40.0, 50.0, count).expect("the range is in order");
    let sample = ring(gears, 2.0);
    Sweep::new(torques)
        .settle(0)
        .measure(periods)
        .channels(&["deflection 0"])
        .of(engine, |p| sample.with("motor torque", p["torque"]))
        .start(|_, ring| State::at_rest(ring.dof()))
        .run()
        .expect("the ring runs")
}

fn report_ring<const W: usize>(gears: usize) {
    const STEPS: usize = 1000;
    let engine = LaneRk4::new(STEPS).lanes::<W>();
    let job = |periods| drop(black_box(ring_sweep(gears, W, periods, &engine)));
    let [short, long] = one_thread(|| least(100, [&mut || job(1), &mut || job(5)]));
    let each = (long - short) / (4 * W * 4 * STEPS) as f64;
    println!("ring of {gears}, W = {W:2}: {:.2} ns per evaluation and trajectory", 1e9 * each);
}

/// Prints the ratio for a ring of 3 over 64 speeds: a drive table for every speed over lanes on one table.
fn report_speeds() {
    let sample = ring(3, 2.0);
    let omega = sample.speed();
    let speeds = Axis::linear("omega", 0.5 * omega, omega, 64).expect("the range is in order");
    let sweep = Sweep::new(speeds).settle(10).measure(10).channels(&["deflection 0"]).rattle();
    let start = |_: &Point<'_>, ring: &Ring| Ok::<_, ParameterError>(State::at_rest(ring.dof()));
    let family = |p: &Point<'_>| sample.with("mesh frequency", p["omega"]);
    let lanes =
        || drop(black_box(sweep.of(&LaneRk4::new(1000), family).start(start).run().expect("the rings run")));
    let tables =
        || drop(black_box(sweep.of(&TableRk4::new(1000), family).start(start).run().expect("the rings run")));
    let [median, least, most] = one_thread(|| ratio(9, tables, lanes));
    println!("ratio sweeps ring of 3 tables lanes {median:.1} ({least:.1} .. {most:.1})");
}

fn workload_c(c: &mut Criterion) {
    let mut group = c.benchmark_group("C");
    group.sample_size(10).measurement_time(Duration::from_secs(3));
    let sweep = ensemble(96);
    group.bench_function("96 trajectories, lanes", |b| {
        b.iter(|| one_thread(|| run(&sweep, &LaneRk4::new(STEPS).lanes::<32>())))
    });
    let sweep = ensemble(4);
    group.bench_function("4 trajectories, table", |b| {
        b.iter(|| one_thread(|| run(&sweep, &TableRk4::new(STEPS))))
    });
    group.finish();
}

criterion_group!(benches, workload_c);

fn main() {
    benches();
    println!("\nworkload C, statistics included, one thread");
    for &set in InstructionSet::available().iter().rev() {
        report::<16>(set);
        report::<32>(set);
    }
    report_ring::<8>(3);
    report_ring::<16>(3);
    report_ring::<32>(3);
    report_ring::<8>(16);
    report_ring::<16>(16);
    report_speeds();
    let sweep = ensemble(512);
    let lanes = LaneRk4::new(STEPS);
    let baseline = lanes.instructions(InstructionSet::Baseline);
    let [median, least, most] =
        one_thread(|| ratio(9, || drop(run(&sweep, &lanes)), || drop(run(&sweep, &baseline))));
    println!(
        "ratio sweeps best baseline instructions {median:.2} ({least:.2} .. {most:.2}); above 0.9 lanes are no \
         longer vector instructions"
    );
    // The gain of two threads, and for comparison that of two separate runs on one thread each, which is the
    // maximum that the machine offers at that moment.
    let alone = || one_thread(|| drop(run(&sweep, &lanes)));
    let [median, least, most] = ratio(21, alone, || threads(2, || drop(run(&sweep, &lanes))));
    println!("ratio sweeps one two threads {median:.2} ({least:.2} .. {most:.2})");
    let apart = || {
        std::thread::scope(|s| {
            [(); 2].map(|()| s.spawn(alone)).into_iter().for_each(|job| job.join().expect("runs"))
        })
    };
    let both = || threads(2, || (0..2).for_each(|_| drop(run(&sweep, &lanes))));
    let [median, least, most] = ratio(21, apart, both);
    println!("ratio sweeps apart both on two threads {median:.2} ({least:.2} .. {most:.2})");
}
