//! Gear trains from parts beside the ring: cost of the general algebra, and planetary maps in lanes.
//!
//! `cargo bench --bench trains` prints the ratios that docs/trains.md and CHANGELOG.md state.

mod common;

use common::ratio;
use gear_dynamics::contact::Mesh;
use gear_dynamics::excitation::{Fourier, Side};
use gear_dynamics::models::nfg::NfgPair2;
use gear_dynamics::sweep::{Axis, InstructionSet, LaneRk4, Point, Points, TableRk4, bounds::SweepEngine};
use gear_dynamics::trains::{Bearing, Body, Members, Planetary, Train, Warning, nfg_parts, ring_parts};
use gear_dynamics::{
    Dop853, Integrator, Model, NfgParams, ParameterError, Periodic, Ring, Rk4, State, Statistics, Sweep, Wave,
};
use std::f64::consts::TAU;
use std::hint::black_box;

/// A ring of n gears by its constructor and from parts. `phase`: of the waves of each mesh after those of the mesh before
/// it, in mesh cycles.
fn rings(gears: usize, phase: f64) -> (Ring, Train) {
    let mut params = common::ring_params(gears, 1.5e-3, 2.0);
    for (i, mesh) in params.meshes.iter_mut().enumerate() {
        let later = |wave: &Wave| wave.clone().with_phase(TAU * phase * i as f64).expect("it is in range");
        *mesh = Mesh::new(later(mesh.stiffness()), later(mesh.error()), *mesh.law());
    }
    let mut parts = ring_parts(&params, 20).expect("all gears are equal");
    let train = parts.accept(Warning::Unbalanced).build("gear 1", params.omega / 20.0).expect("it is a ring");
    (Ring::as_printed(&params).expect("the parameters are in range"), train)
}

/// Evaluates the accelerations `count` times in states that change. `DRIVEN`: with the drives at times that change, as
/// a right-hand side needs them.
fn evaluate<const DRIVEN: bool, M: Model>(model: &M, count: usize) {
    let n = model.dof();
    let (mut u, mut a) = (vec![0.0; model.drives()], vec![0.0; n]);
    model.drive(1e-4, Side::After, &mut u);
    let mut q: Vec<f64> = (0..n).map(|i| 1e-5 * (i as f64 * 0.618).fract()).collect();
    let v = vec![1e-3; n];
    for i in 0..count {
        if DRIVEN {
            model.drive(1e-6 * i as f64, Side::After, &mut u);
        }
        model.accel(&u, black_box(&q), &v, &mut a);
        q[0] += 1e-20 * a[0];
    }
    black_box(q);
}

/// Runs 64 torques in lanes.
fn lanes<M: Periodic + Sync>(sample: &M, with: impl Fn(f64) -> Result<M, ParameterError> + Sync)
where
    LaneRk4<16>: SweepEngine<M>,
{
    let torques = Axis::linear("torque", 40.0, 50.0, 64).expect("the range is in order");
    let rows = Sweep::new(torques)
        .settle(0)
        .measure(20)
        .channels(&["deflection 0"])
        .of(&LaneRk4::new(64).instructions(InstructionSet::Best), |p| with(p["torque"]))
        .start(|_, model| State::at_rest(model.dof()))
        .run()
        .expect("the ring runs");
    black_box((rows, sample.dof()));
}

/// A torsional planetary set with backlash in six meshes.
fn planetary() -> Train {
    let wave = || Wave::new(Fourier::new(2e8, &[[4e7, 0.0]]).expect("it is in range"));
    let ring = (90, Body::new(5e-2).locked());
    let members =
        Members { sun: (30, Body::new(1e-3)), planet: (30, Body::new(1e-3)), ring, carrier: Body::new(3e-2) };
    let set = Planetary::new(3, 0.03, members, [wave(), wave()]).expect("it is in range");
    let mut parts = set.damping(2000.0).half_backlash(3e-5).parts();
    parts.torque("drive", "sun", 30.0).load("carrier");
    parts.build("sun", 100.0).expect("it assembles")
}

/// The same set with every member on a bearing: 18 coordinates.
fn planetary_on_bearings() -> Train {
    let wave = || Wave::new(Fourier::new(2e8, &[[4e7, 0.0]]).expect("it is in range"));
    let on = |inertia: f64, mass: f64, stiffness: f64| {
        Body::new(inertia).bearing(Bearing::new(mass, stiffness).damping(500.0))
    };
    let ring = (90, on(5e-2, 6.0, 1e9).grounded(1e7, 1e3));
    let members = Members {
        sun: (30, on(1e-3, 0.5, 1e8)),
        planet: (30, on(1e-3, 0.6, 1e8)),
        ring,
        carrier: on(3e-2, 5.0, 1e9),
    };
    let set = Planetary::new(3, 0.03, members, [wave(), wave()]).expect("it is in range");
    let mut parts = set.damping(2000.0).half_backlash(3e-5).parts();
    parts.torque("drive", "sun", 30.0).load("carrier");
    parts.build("sun", 100.0).expect("it assembles")
}

/// Points of a map over speed and load, with 20 periods settled and 10 measured.
fn map(train: &Train, side: usize, engine: &impl SweepEngine<Train>) {
    let axis = |name, low, high| Axis::linear(name, low, high, side).expect("the range is in order");
    let points = Points::grid(vec![axis("speed", 80.0, 200.0), axis("load", 0.1, 2.0)]).expect("two axes");
    let model = |p: &Point<'_>| train.with_all(&[("drive", 30.0 * p["load"]), ("speed", p["speed"])]);
    let start = |_: &Point<'_>, train: &Train| Ok::<_, ParameterError>(State::at_rest(train.dof()));
    let sweep = Sweep::new(points).settle(20).measure(10).channels(&["deflection 0"]);
    black_box(sweep.of(engine, model).start(start).run().expect("the map runs"));
}

/// The same runs one by one with RK4 and statistics, without a table of the drives.
fn one_by_one(train: &Train, side: usize) {
    for i in 0..side * side {
        let share = |k: usize| k as f64 / (side - 1) as f64;
        let (speed, load) = (80.0 + 120.0 * share(i % side), 0.1 + 1.9 * share(i / side));
        let run = train.with_all(&[("drive", 30.0 * load), ("speed", speed)]).expect("it is in range");
        let solver = Rk4::new(run.period() / 64.0).plain();
        let settled = solver.end(&run, &State::at_rest(run.dof()), 20.0 * run.period()).expect("it runs");
        let mut statistics = Statistics::new(&run, &["deflection 0"]).expect("the channel exists");
        solver.run(&run, &settled, settled.t + 10.0 * run.period(), &mut statistics).expect("it runs");
        drop(black_box(statistics));
    }
}

/// The face gear pair from parts over that of its own algebra.
fn face_gears() {
    let params = NfgParams::table1();
    let train = nfg_parts(&params, 0.01)
        .and_then(|mut parts| parts.accept(Warning::Drifts).build("pinion", params.speed));
    let pair =
        NfgPair2::new(&params, 0.01).and_then(|pair| pair.with_torque(params.load_torque / params.ratio));
    let (train, pair) = (train.expect("it is in range"), pair.expect("it is in range"));
    let count = 1_000_000;
    let [median, least, most] =
        ratio(15, || evaluate::<true, _>(&train, count), || evaluate::<true, _>(&pair, count));
    println!("ratio train face gear pair right-hand side {median:.3} ({least:.3} .. {most:.3})");
    let [median, least, most] =
        ratio(15, || evaluate::<false, _>(&train, count), || evaluate::<false, _>(&pair, count));
    println!("ratio train face gear pair accel {median:.3} ({least:.3} .. {most:.3})");
    let end = 20.0 * pair.period();
    let start = pair.on_drive_flank().expect("the mesh has a stiffness");
    let [median, least, most] = ratio(
        11,
        || drop(black_box(Dop853::new().end(&train, &start, end))),
        || drop(black_box(Dop853::new().end(&pair, &start, end))),
    );
    println!("ratio train face gear pair DOP853 {median:.3} ({least:.3} .. {most:.3})");
}

fn main() {
    let train = planetary();
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("threads start");
    alone.install(|| {
        let lanes = || map(&train, 16, &LaneRk4::new(64));
        let [median, least, most] = ratio(7, || one_by_one(&train, 16), lanes);
        println!("ratio planetary map one by one lanes {median:.2} ({least:.2} .. {most:.2}), one thread");
        let [median, least, most] = ratio(7, || map(&train, 16, &TableRk4::new(64)), lanes);
        println!("ratio planetary map tables lanes {median:.2} ({least:.2} .. {most:.2}), one thread");
    });
    let set = planetary_on_bearings();
    alone.install(|| {
        let on = |instructions| map(&set, 8, &LaneRk4::new(256).instructions(instructions));
        let [median, least, most] = ratio(7, || on(InstructionSet::Best), || on(InstructionSet::Baseline));
        println!(
            "ratio planetary set on bearings best baseline instructions {median:.2} ({least:.2} .. {most:.2})"
        );
    });
    let all = || map(&train, 16, &LaneRk4::new(64));
    let [median, least, most] = ratio(7, || one_by_one(&train, 16), all);
    println!("ratio planetary map one by one lanes {median:.2} ({least:.2} .. {most:.2}), all threads");
    face_gears();
    let mut each = [0.0; 2];
    for gears in [3, 16, 1024] {
        let (ring, train) = rings(gears, 0.0);
        let count = 3_000_000 / gears;
        let (phased_ring, phased_train) = rings(gears, 0.37);
        for (waves, ring, train) in [("equal", &ring, &train), ("own", &phased_ring, &phased_train)] {
            let [median, least, most] =
                ratio(15, || evaluate::<true, _>(train, count), || evaluate::<true, _>(ring, count));
            println!(
                "ratio train ring right-hand side, {waves} waves, n={gears} {median:.3} ({least:.3} .. {most:.3})"
            );
        }
        let [median, least, most] =
            ratio(15, || evaluate::<false, _>(&train, count), || evaluate::<false, _>(&ring, count));
        println!("ratio train ring accel n={gears} {median:.3} ({least:.3} .. {most:.3})");
        let start = std::time::Instant::now();
        evaluate::<false, _>(&train, count);
        let ns = start.elapsed().as_secs_f64() * 1e9 / (count * gears) as f64;
        println!("train n={gears}: {ns:.2} ns per gear");
        each = [each[1], ns];
    }
    println!("ratio per gear 1024 over 16 {:.3}", each[1] / each[0]);
    for gears in [3, 16] {
        let (ring, train) = rings(gears, 0.0);
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("threads start");
        let [median, least, most] = alone.install(|| {
            let general = || lanes(&train, |torque| train.with("motor torque", torque));
            ratio(11, general, || lanes(&ring, |torque| ring.with("motor torque", torque)))
        });
        println!("ratio train ring lanes n={gears} {median:.3} ({least:.3} .. {most:.3})");
    }
}
