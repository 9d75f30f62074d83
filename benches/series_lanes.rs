//! Time of Taylor series in lanes: the engine `LaneTaylor` over `Located` on the same sweeps, on one thread, with
//! statistics and rattle. `cargo bench --bench series_lanes`. Other work on the machine adds to all times: each time is
//! the least of several, and the two of a ratio are measured in turn.

mod common;

use common::{Pair, Rattling, ring};
use gear_dynamics::excitation::Fourier;
use gear_dynamics::models::ring::RingShape;
use gear_dynamics::sweep::{
    Axis, InstructionSet, LaneRk4, LaneTaylor, Located, Point, Points, Rows, bounds::SweepEngine,
};
use gear_dynamics::trains::{Body, Members, Planetary, Train, TrainShape};
use gear_dynamics::{
    Dop853, Lyapunov, Machine, Model, NfgPair, NfgParams, ParameterError, Shape, Shooting, State, Sweep,
    Taylor, Wave,
};
use std::time::Instant;

/// A sweep of one machine over one constant.
struct Workload<G> {
    name: &'static str,
    machine: Machine<G>,
    constant: &'static str,
    channel: &'static str,
    sweep: Sweep,
    start: State,
}

impl<G: Shape + Send + Sync> Workload<G> {
    fn run(&self, engine: &impl SweepEngine<Machine<G>>) -> Rows {
        let family = |p: &Point<'_>| self.machine.with(self.constant, p[self.constant]);
        let start = |_: &Point<'_>, _: &Machine<G>| Ok::<_, ParameterError>(self.start.clone());
        self.sweep.of(engine, family).start(start).run().expect("the workload runs")
    }

    /// Prints times and ratios of the engines; `tolerances`: relative and absolute.
    fn report(&self, [rtol, atol]: [f64; 2], dop853: [f64; 2], rounds: usize) {
        let taylor = Taylor::new().rtol(rtol).atol(atol);
        let (lanes, scalar) = (LaneTaylor::new(taylor.clone()), Located(taylor.clone()));
        let runge_kutta = Located(Dop853::new().rtol(dop853[0]).atol(dop853[1]));
        let count = self.run(&lanes).iter().count();
        let name = self.name;
        let narrow = lanes.clone().instructions(InstructionSet::Avx2);
        let [wide, avx2, one, other] = least(
            rounds,
            [
                &mut || drop(self.run(&lanes)),
                &mut || drop(self.run(&narrow)),
                &mut || drop(self.run(&scalar)),
                &mut || drop(self.run(&runge_kutta)),
            ],
        );
        let each = |time: f64| 1e3 * time / count as f64;
        let impacts: u64 = self.run(&scalar).iter().map(|row| row.contacts()[0].impact_count()).sum();
        println!(
            "{name}: {count} rows with {impacts} impacts, {:.3} ms a row; {:.3} with AVX2, {:.3} Located(Taylor), {:.3} Located(Dop853)",
            each(wide),
            each(avx2),
            each(one),
            each(other)
        );
        println!("ratio lanes-taylor scalar {name} {:.2}", one / wide);
        println!("ratio lanes-taylor scalar {name}, AVX2 {:.2}", one / avx2);
        println!("ratio lanes-taylor dop853 {name} {:.2}", other / wide);
        self.compare(&lanes, &scalar, &runge_kutta);
    }

    /// Prints how far the means of the first channel are apart.
    fn compare(
        &self,
        lanes: &impl SweepEngine<Machine<G>>,
        scalar: &impl SweepEngine<Machine<G>>,
        other: &impl SweepEngine<Machine<G>>,
    ) {
        let tight = Located(Taylor::new().rtol(1e-14).atol(1e-19));
        let means = |rows: Rows| rows.column(|row| row.channel(self.channel).map_or(f64::NAN, |x| x.rms));
        let truth = means(self.run(&tight));
        let apart = |rows: Rows| {
            let mut apart: Vec<f64> =
                means(rows).iter().zip(&truth).map(|(a, b)| (a / b - 1.0).abs()).collect();
            apart.sort_by(f64::total_cmp);
            format!("{:.1e} .. {:.1e}", apart[apart.len() / 2], apart[apart.len() - 1])
        };
        let [a, b, c] = [apart(self.run(lanes)), apart(self.run(scalar)), apart(self.run(other))];
        println!("    RMS off by median .. largest: lanes {a}, Located(Taylor) {b}, Located(Dop853) {c}");
    }
}

fn threads<T: Send>(count: usize, f: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("threads start").install(f)
}

/// Least times of jobs that run in turn.
fn least<const N: usize>(rounds: usize, mut jobs: [&mut dyn FnMut(); N]) -> [f64; N] {
    let mut least = [f64::INFINITY; N];
    for _ in 0..rounds {
        for (job, least) in jobs.iter_mut().zip(&mut least) {
            let start = Instant::now();
            job();
            *least = least.min(start.elapsed().as_secs_f64());
        }
    }
    least
}

fn axis(name: &str, from: f64, to: f64, count: usize) -> Points {
    Points::from(Axis::linear(name, from, to, count).expect("the range is in order"))
}

/// The rattling pair over 64 speeds, 20 turns.
fn pair(count: usize) -> Workload<Rattling> {
    Workload {
        name: "A",
        machine: Pair::new().machine_of_waves(),
        constant: "wc",
        channel: "q0",
        sweep: Sweep::new(axis("wc", 0.15 / 63.0, 0.36 / 63.0, count))
            .settle(0)
            .measure(20)
            .channels(&["q0"])
            .rattle(),
        start: Pair::start(),
    }
}

/// The ring of three gears over 64 speeds.
fn ring_of_three() -> Workload<RingShape> {
    let machine = ring(3, 2.0);
    let omega = machine.speed();
    Workload {
        name: "B3",
        constant: "mesh frequency",
        channel: "deflection 0",
        sweep: Sweep::new(axis("mesh frequency", 0.5 * omega, omega, 64))
            .settle(20)
            .measure(20)
            .channels(&["deflection 0"])
            .rattle(),
        start: State::at_rest(machine.dof()),
        machine,
    }
}

/// A planetary set with three planets and backlash over 64 speeds.
fn planetary() -> Workload<TrainShape> {
    let wave = |mean: f64| Wave::new(Fourier::new(mean, &[[0.2 * mean, 0.0]]).expect("finite"));
    let error = || Wave::new(Fourier::new(0.0, &[[3e-6, 0.0]]).expect("finite"));
    let members = Members {
        sun: (30, Body::new(1e-3)),
        planet: (30, Body::new(1e-3)),
        ring: (90, Body::new(5e-2).locked()),
        carrier: Body::new(3e-2),
    };
    let set = Planetary::new(3, 0.03, members, [wave(2e8), wave(2.5e8)]).expect("the set assembles");
    let mut parts = set.error([error(), error()]).damping(1000.0).half_backlash(2e-5).parts();
    parts.torque("drive", "sun", 10.0).torque("load", "carrier", -40.0);
    let machine: Train = parts.build("sun", 100.0).expect("the set assembles");
    Workload {
        name: "planetary",
        constant: "speed",
        channel: "deflection 0",
        sweep: Sweep::new(axis("speed", 200.0, 600.0, 64))
            .settle(20)
            .measure(20)
            .channels(&["deflection 0"])
            .rattle(),
        start: State::at_rest(machine.dof()),
        machine,
    }
}

/// Prints the time of Lyapunov exponents in lanes and one by one. Each run of the sweep itself takes a period only.
fn exponents<G: Shape + Send + Sync>(name: &str, points: Points, machine: &Machine<G>, rounds: usize) {
    let count = points.len();
    let lyapunov = Lyapunov::new().align(10).measure(40);
    let sweep = Sweep::new(points).settle(0).measure(1).lyapunov(lyapunov);
    let taylor = Taylor::new().rtol(1e-10).atol(1e-15);
    let (lanes, single) = (LaneTaylor::new(taylor.clone()), Located(taylor));
    let in_lanes = || sweep.over(&lanes, machine).expect("constants").run().expect("it runs");
    let one_by_one = || sweep.over(&single, machine).expect("constants").run().expect("it runs");
    let [wide, one] = least(rounds, [&mut || drop(in_lanes()), &mut || drop(one_by_one())]);
    let each = |time: f64| 1e3 * time / count as f64;
    println!("exponents of {name}: {count} points, {:.2} ms each, {:.2} one by one", each(wide), each(one));
    println!("ratio lanes-taylor one-by-one exponents of {name} {:.2}", one / wide);
}

/// Prints the time of multipliers in lanes and one by one, without that of the runs before.
fn multipliers<G: Shape + Send + Sync>(name: &str, points: Points, machine: &Machine<G>, settle: usize) {
    let plain = Sweep::new(points).settle(settle).measure(2).periodic_tolerance(1e-3);
    let sweep = plain.clone().multipliers(Shooting::new());
    let taylor = Taylor::new().rtol(1e-10).atol(1e-15);
    let (lanes, single) = (LaneTaylor::new(taylor.clone()), Located(taylor));
    let in_lanes = |sweep: &Sweep| sweep.over(&lanes, machine).expect("constants").run().expect("it runs");
    let one_by_one = |sweep: &Sweep| sweep.over(&single, machine).expect("constants").run().expect("it runs");
    let count = in_lanes(&sweep).iter().filter(|row| row.multipliers().is_some()).count();
    let times = least(
        2,
        [
            &mut || drop(in_lanes(&sweep)),
            &mut || drop(in_lanes(&plain)),
            &mut || drop(one_by_one(&sweep)),
            &mut || drop(one_by_one(&plain)),
        ],
    );
    let [wide, one] = [times[0] - times[1], times[2] - times[3]];
    let each = |time: f64| 1e3 * time / count as f64;
    println!("multipliers of {name}: {count} orbits, {:.2} ms each, {:.2} one by one", each(wide), each(one));
    println!("ratio lanes-shooting scalar {name} {:.2}", one / wide);
}

/// Points of a map of the face gear pair.
fn map_of_the_face_gear_pair(side: usize) -> Points {
    let axis = |name: &str, from, to| Axis::linear(name, from, to, side).expect("the range is in order");
    Points::grid(vec![axis("speed", 100.0, 250.0), axis("load torque", 2.0, 50.0)]).expect("the axes differ")
}

/// The times of a map in lanes by Taylor series and by fixed steps.
fn report_map() {
    let mut map = pair(1000);
    map.sweep = map.sweep.settle(60).measure(40);
    let mut early = pair(1000);
    early.sweep = map.sweep.clone().repeat_tolerance(1e-8);
    let plain = LaneRk4::new(63 * 64).lanes::<32>();
    let located = LaneTaylor::new(Taylor::new().rtol(1e-9).atol(1e-14));
    let [slow, fast, slow_early, fast_early] = threads(2, || {
        least(
            2,
            [
                &mut || drop(map.run(&located)),
                &mut || drop(map.run(&plain)),
                &mut || drop(early.run(&located)),
                &mut || drop(early.run(&plain)),
            ],
        )
    });
    println!("1000 of the 10 000 points of a map, 60 + 40 turns, two threads:");
    println!("    all turns: {slow:.2} s, LaneRk4 {fast:.2} s");
    println!("    until the motion repeats: {slow_early:.2} s, LaneRk4 {fast_early:.2} s");
    println!("ratio lanes-rk4 lanes-taylor map, all turns {:.3}", fast / slow);
    println!("ratio lanes-rk4 lanes-taylor map {:.3}", fast / slow_early);
}

/// Prints time and peak memory of sweeps of one turn whose rows are dropped chunk by chunk. Runs only if it is named.
fn memory() {
    let peak = || {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        line.map_or("not known".to_owned(), |line| line.trim().to_owned())
    };
    let engine = LaneTaylor::new(Taylor::new().rtol(1e-9).atol(1e-14));
    // Points of a grid: its axes take no memory to speak of.
    for (count, chunks) in [(10_000, 1), (100_000, 10), (1_000_000, 100), (100_000, 1)] {
        let Workload { machine, start, .. } = pair(2);
        let axis =
            |name, from, to, count| Axis::linear(name, from, to, count).expect("the range is in order");
        let axes = vec![axis("wc", 0.15 / 63.0, 0.36 / 63.0, count / 100), axis("run", 1.0, 100.0, 100)];
        let points = Points::grid(axes).expect("the axes differ");
        let sweep = Sweep::new(points).settle(0).measure(1).channels(&["q0"]).rattle();
        let family = |p: &Point<'_>| machine.with("wc", p["wc"]);
        let begin = |_: &Point<'_>, _: &_| Ok::<_, ParameterError>(start.clone());
        let (runner, begun, mut rows) = (sweep.of(&engine, family).start(begin), Instant::now(), 0);
        for chunk in 0..chunks {
            rows += runner.chunk(chunk, chunks).expect("the workload runs").iter().count();
        }
        let seconds = begun.elapsed().as_secs_f64();
        println!("{rows} rows in {chunks} chunks: {seconds:.1} s, peak memory so far {}", peak());
    }
}

fn main() {
    let asked = |what: &str| std::env::args().any(|arg| arg == what);
    let quick = asked("quick");
    let rounds = if quick { 1 } else { 5 };
    // Without a name all parts are measured.
    let parts = ["A", "exponents", "multipliers", "map"];
    let part = |what: &str| asked(what) || !parts.iter().any(|part| asked(part));
    if asked("memory") {
        return memory();
    }
    let pair_of_64 = pair(64);
    threads(1, || {
        if part("A") {
            pair_of_64.report([1e-10, 1e-15], [3e-11, 3e-16], rounds);
        }
        if part("") {
            ring_of_three().report([1e-10, 1e-15], [1e-10, 1e-15], rounds);
            planetary().report([1e-10, 1e-15], [1e-10, 1e-15], rounds);
        }
        if part("exponents") {
            let wc = axis("wc", 0.15 / 63.0, 0.36 / 63.0, if quick { 16 } else { 64 });
            exponents("A", wc, &pair_of_64.machine, 1);
            let set = planetary().machine;
            exponents("planetary", axis("speed", 200.0, 600.0, if quick { 16 } else { 64 }), &set, 1);
            let face = NfgPair::new(&NfgParams::table1()).expect("the pair of the table");
            exponents("the face gear pair", map_of_the_face_gear_pair(if quick { 4 } else { 8 }), &face, 1);
        }
        if part("multipliers") {
            let wc = axis("wc", 0.15 / 63.0, 0.36 / 63.0, if quick { 16 } else { 64 });
            multipliers("A", wc, &pair_of_64.machine, 30);
            let face = NfgPair::new(&NfgParams::table1()).expect("the pair of the table");
            multipliers(
                "the face gear pair",
                map_of_the_face_gear_pair(if quick { 4 } else { 8 }),
                &face,
                12,
            );
        }
    });
    if part("") && !quick {
        let lanes = LaneTaylor::new(Taylor::new().rtol(1e-10).atol(1e-15));
        let many = pair(256);
        let [one, two] = least(
            rounds,
            [&mut || threads(1, || drop(many.run(&lanes))), &mut || threads(2, || drop(many.run(&lanes)))],
        );
        println!("ratio lanes-taylor one two threads {:.2}", one / two);
    }
    if part("map") && !quick {
        report_map();
    }
}
