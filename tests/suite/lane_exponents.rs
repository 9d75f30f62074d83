//! Lyapunov exponents by Taylor series in lanes: those of single runs, closed forms, the same bits for any way of
//! running, jumps at edges and at rigid stops, intervals that are halved, errors.

use crate::api::*;
use crate::benchmarks::{Pair, ring};
use crate::lane_taylor::{Stops, axis, pair, planetary, rows, tolerant, wave};
use gear_dynamics::ode::Exhausted;
use gear_dynamics::periodic::LyapunovError;
use gear_dynamics::sweep::Watch;
use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

const TOLERANCE: f64 = 1e-9;

fn lyapunov() -> Lyapunov {
    Lyapunov::new().align(3).measure(4).flow_tolerance(TOLERANCE)
}

/// Exponents in lanes are those of single runs from the same state. Where the motion repeats, the error of a single run
/// is known from one with a hundredth of the tolerance; elsewhere exponents agree within their standard errors.
fn exponents_agree<G: Shape + Send + Sync>(
    machine: &Machine<G>,
    start: &State,
    sweep: Sweep,
    [least, chaotic]: [usize; 2],
) {
    let sweep = sweep.periodic_tolerance(1e-7).strobe(1).lyapunov(lyapunov());
    let name = sweep.points().names()[0].clone();
    let lanes = rows(&sweep, &LaneTaylor::new(tolerant()), machine, start);
    assert!(lanes.errors().is_empty() && lanes.exponent_errors().is_empty(), "{:?}", lanes.exponent_errors());
    let mut compared = [0; 2];
    for row in lanes.iter() {
        let (q, v) = row.strobes().next().unwrap().split_at(machine.dof());
        let model = machine.with(&name, row.point()[&*name]).unwrap();
        let single = |tolerance: f64| {
            let settings = lyapunov().count(1).settle(0).flow_tolerance(tolerance);
            let found = settings.run(&model, &State::new(0.0, q, v)).unwrap();
            (found.per_period()[0], found.standard_error()[0])
        };
        let (ours, error) = (row.lyapunov().unwrap(), row.lyapunov_standard_error().unwrap());
        let ((rough, scatter), (exact, _)) = (single(TOLERANCE), single(0.01 * TOLERANCE));
        let what = format!("{name}, point {}: {ours:e}, {rough:e}, {exact:e}", row.index());
        if row.period_multiple().is_some() {
            compared[0] += 1;
            let bound = 10.0 * (TOLERANCE * exact.abs().max(1.0) + (rough - exact).abs());
            assert!((ours - exact).abs() <= bound, "{what}");
        } else {
            compared[1] += 1;
            assert!((ours - rough).abs() <= 2.0 * error.hypot(scatter), "{what}, {error:e}, {scatter:e}");
        }
    }
    assert!(compared[0] >= least && compared[1] >= chaotic, "{name}: {compared:?}");
}

#[test]
fn exponents_of_the_pair_are_those_of_single_runs() {
    let sweep = Sweep::new(axis("wc", 0.15 / 63.0, 0.36 / 63.0, 3)).settle(25).measure(2);
    exponents_agree(&pair(), &Pair::start(), sweep, [2, 0]);
    let nfg = NfgPair::new(&NfgParams::table1()).unwrap();
    let sweep = Sweep::new(axis("speed", 80.0, 150.0, 2)).settle(12).measure(1);
    exponents_agree(&nfg, &nfg.on_drive_flank().unwrap(), sweep, [1, 0]);
}

#[test]
fn exponents_of_rings_and_sets_are_those_of_single_runs() {
    let ring = ring(3, 2.0);
    let omega = ring.speed();
    let sweep = Sweep::new(axis("mesh frequency", 0.5 * omega, omega, 2)).settle(200).measure(3);
    exponents_agree(&ring, &State::at_rest(ring.dof()), sweep, [2, 0]);
    let train = planetary();
    let sweep = Sweep::new(axis("speed", 200.0, 600.0, 2)).settle(200).measure(3);
    exponents_agree(&train, &State::at_rest(train.dof()), sweep, [1, 0]);
}

/// A ball on a table A sin t with one impact a period, restitution e: the multipliers are a complex pair with the
/// product e², so that the exponent is ln e. Elastic stops with damping: exponents of single runs.
#[test]
fn differences_jump_at_stops() {
    let restitution: f64 = 0.8;
    let table = Stops::rigid(&[(true, wave(0.0, 0.0, 0.09, 1))], restitution, 1.0, -0.1);
    let sweep = Sweep::new(axis("pull", -0.096, -0.09, 4)).settle(150).measure(1).rattle();
    let start = State::new(0.0, &[0.2], &[0.3]);
    exponents_agree(&table, &start, sweep.clone(), [4, 0]);
    let long = sweep.lyapunov(Lyapunov::new().align(100).measure(200));
    for row in rows(&long, &LaneTaylor::new(tolerant()), &table, &start).iter() {
        assert_eq!(row.contacts()[0].impacts, [1, 0]);
        let (ours, error) = (row.lyapunov().unwrap(), row.lyapunov_standard_error().unwrap());
        // The mean over a rotating direction converges as 1/periods.
        assert!((ours - restitution.ln()).abs() < 2.0 * error && error < 0.02, "{ours} {error}");
    }
    let jumps = Wave::new(RectangularWave::new(0.8, 1.1, 0.4).unwrap());
    let edges = Stops::machine(&[(false, jumps), (true, wave(-1.0, 0.2, 0.1, 2))], 40.0, 1.0, 1.0, -0.3);
    let sweep = Sweep::new(axis("pull", -0.3, 0.3, 6)).settle(100).measure(1);
    exponents_agree(&edges, &State::new(0.0, &[0.1], &[0.3]), sweep, [3, 2]);
}

/// q'' + c q' + k (q - 1) = 0 on a stop that the mass never leaves, c² < 4 k: both exponents are -c/2. Within a part of
/// a period a direction shrinks by e^(-2π c/32) < 1e-3: the parts are halved.
#[test]
fn parts_are_halved_where_a_direction_shrinks() {
    let machine = |damping| Stops::machine(&[(false, Wave::constant(1.0).unwrap())], 1e4, damping, 1.0, 1e3);
    let dampings = [40.0, 60.0, 100.0];
    let points = Points::from(Axis::of_values("damping", &dampings).unwrap());
    let sweep = Sweep::new(points).settle(0).measure(1).lyapunov(lyapunov());
    let family = |p: &Point<'_>| Ok::<_, ParameterError>(machine(p["damping"]));
    let start =
        |_: &Point<'_>, _: &Machine<Stops>| Ok::<_, ParameterError>(State::new(0.0, &[1.101], &[0.0]));
    let rows = sweep.of(&LaneTaylor::new(tolerant()), family).start(start).run().unwrap();
    for (row, damping) in rows.iter().zip(dampings) {
        let (ours, exact) = (row.lyapunov().unwrap(), -0.5 * damping * TAU);
        // The direction turns: its length after a whole number of parts differs from the mean by up to √k.
        assert!((ours - exact).abs() < 2.0 * row.lyapunov_standard_error().unwrap(), "{ours} {exact}");
        assert!((ours - exact).abs() < 0.02 * exact.abs(), "{ours} {exact}");
    }
}

#[test]
fn the_same_exponents_however_they_are_run() {
    let sweep = Sweep::new(axis("wc", 0.15 / 63.0, 0.36 / 63.0, 11)).settle(0).measure(1);
    let sweep = sweep.lyapunov(lyapunov().align(1).measure(2));
    let (machine, start, engine) = (pair(), Pair::start(), LaneTaylor::new(tolerant()));
    let expected = rows(&sweep, &engine, &machine, &start).fingerprint();
    for set in InstructionSet::available() {
        let rows = rows(&sweep, &engine.clone().instructions(set), &machine, &start);
        assert_eq!(expected, rows.fingerprint(), "{set:?}");
    }
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(expected, pool.install(|| rows(&sweep, &engine, &machine, &start)).fingerprint());
    }
    let family = |p: &Point<'_>| machine.with("wc", p["wc"]);
    let begin = |_: &Point<'_>, _: &_| Ok::<_, ParameterError>(start.clone());
    let runner = sweep.of(&engine, family).start(begin);
    let parts = [2, 0, 1].map(|i| runner.chunk(i, 3).unwrap());
    assert_eq!(expected, Rows::merge(parts.into()).unwrap().fingerprint());
    // Every point alone, without neighbours.
    let alone = (0..11).map(|i| runner.chunk(i, 11).unwrap()).collect();
    assert_eq!(expected, Rows::merge(alone).unwrap().fingerprint());
    // A sweep that is cancelled and resumed.
    let (made, cancel) = (AtomicUsize::new(0), Arc::new(AtomicBool::new(false)));
    let stop = |_: &Row<'_>| cancel.store(made.fetch_add(1, Ordering::Relaxed) == 4, Ordering::Relaxed);
    let partial = sweep
        .of(&engine, family)
        .start(begin)
        .row_callback(stop)
        .watch(Watch::new().cancel(cancel.clone()))
        .run()
        .unwrap();
    assert_eq!(expected, runner.resume(partial).unwrap().fingerprint());
}

/// A row without an exponent keeps its other figures; another method of the flow gives the exponents of single runs.
#[test]
fn budgets_and_other_methods() {
    let sweep = Sweep::new(axis("wc", 0.15 / 63.0, 0.36 / 63.0, 5)).settle(2).measure(1).channels(&["q0"]);
    let (machine, start, engine) = (pair(), Pair::start(), LaneTaylor::new(tolerant()));
    let plain = rows(&sweep, &engine, &machine, &start);
    let short = lyapunov().budget(Budget::new().steps(500));
    let spent = rows(&sweep.clone().lyapunov(short), &engine, &machine, &start);
    assert_eq!(spent.exponent_errors().len(), 5);
    for (row, plain) in spent.iter().zip(plain.iter()) {
        assert_eq!(row.channel("q0"), plain.channel("q0"));
        let Some(PointError::Lyapunov(LyapunovError::Exhausted { exhausted, last })) =
            spent.exponent_errors().get(&row.index())
        else {
            panic!("{:?}", spent.exponent_errors().get(&row.index()))
        };
        assert_eq!(*exhausted, Exhausted::Steps { limit: 500 });
        assert!(last.running(0).len() < 4);
    }
    let other = lyapunov().align(1).measure(1).flow_method(FlowMethod::Dop853);
    let found = rows(&sweep.strobe(1).lyapunov(other.clone()), &engine, &machine, &start);
    let row = found.get(1).unwrap();
    let (q, v) = row.strobes().next().unwrap().split_at(machine.dof());
    let model = machine.with("wc", row.point()["wc"]).unwrap();
    let single = other.count(1).settle(0).run(&model, &State::new(0.0, q, v)).unwrap();
    assert_eq!(row.lyapunov(), Some(single.per_period()[0]));
}
