//! Multipliers of the orbits in which runs settle: those of shooting from the same state, closed forms, the same bits for
//! any way of running, motions without an orbit.

use crate::api::*;
use crate::benchmarks::Pair;
use crate::lane_taylor::{Stops, axis, pair, planetary, rows, tolerant, wave};
use gear_dynamics::periodic::{FlowMethod, ShootingError, Stability};

/// Multipliers in lanes are those of shooting from the last state of the run, within the error that both estimate.
fn multipliers_agree<G: Shape + Send + Sync>(
    machine: &Machine<G>,
    start: &State,
    sweep: Sweep,
    least: usize,
) {
    let sweep = sweep.periodic_tolerance(1e-6).strobe(1).multipliers(Shooting::new());
    let name = sweep.points().names()[0].clone();
    let lanes = rows(&sweep, &LaneTaylor::new(tolerant()), machine, start);
    assert!(lanes.errors().is_empty() && lanes.exponent_errors().is_empty(), "{:?}", lanes.exponent_errors());
    let mut compared = 0;
    for row in lanes.iter() {
        let Some(multiple) = row.period_multiple() else {
            assert_eq!(row.multipliers(), None);
            continue;
        };
        compared += 1;
        let (q, v) = row.strobes().next().unwrap().split_at(machine.dof());
        let model = machine.with(&name, row.point()[&*name]).unwrap();
        let guess = State::new(0.0, q, v);
        let single = Shooting::new().period_multiple(multiple).solve(&model, [&guess]).unwrap();
        let (ours, single) = (row.multipliers().unwrap(), single.multipliers());
        let what = format!("{name}, point {}: {ours:?}, {single:?}", row.index());
        println!("{what}");
        assert_eq!(ours.values().len(), single.values().len());
        let bound = 10.0 * (1e-12 * single.largest().max(1.0) + single.value_error().max(ours.value_error()));
        assert!(bound < 1e-4, "{what}");
        for (a, b) in ours.values().iter().zip(single.values()) {
            assert!((a.norm() - b.norm()).abs() <= bound, "{what}");
        }
        assert_eq!(ours.stability(), single.stability(), "{what}");
    }
    assert!(compared >= least, "{name}: {compared}");
}

#[test]
fn multipliers_of_pairs_are_those_of_shooting() {
    let sweep = Sweep::new(axis("wc", 0.15 / 63.0, 0.36 / 63.0, 5)).settle(30).measure(2);
    multipliers_agree(&pair(), &Pair::start(), sweep, 2);
    let nfg = NfgPair::new(&NfgParams::table1()).unwrap();
    let sweep = Sweep::new(axis("speed", 80.0, 150.0, 4)).settle(12).measure(1);
    multipliers_agree(&nfg, &nfg.on_drive_flank().unwrap(), sweep, 2);
}

#[test]
fn multipliers_of_a_planetary_set_are_those_of_shooting() {
    let train = planetary();
    let sweep = Sweep::new(axis("speed", 200.0, 600.0, 2)).settle(400).measure(3);
    multipliers_agree(&train, &State::at_rest(train.dof()), sweep, 1);
}

/// A ball on a table A sin t with one impact a period, restitution e: the multipliers are a complex pair with the
/// product e². The runs end while the state still moves by 1e-5: Newton's method closes them.
#[test]
fn multipliers_of_a_bouncing_ball_are_exact() {
    let restitution: f64 = 0.8;
    let table = Stops::rigid(&[(true, wave(0.0, 0.0, 0.09, 1))], restitution, 1.0, -0.1);
    let sweep = Sweep::new(axis("pull", -0.096, -0.09, 4)).settle(60).measure(1).periodic_tolerance(1e-3);
    let found = rows(
        &sweep.multipliers(Shooting::new()),
        &LaneTaylor::new(tolerant()),
        &table,
        &State::new(0.0, &[0.2], &[0.3]),
    );
    for row in found.iter() {
        let multipliers = row.multipliers().unwrap();
        let product: f64 = multipliers.values().iter().map(|value| value.norm()).product();
        assert!((product - restitution.powi(2)).abs() < 1e-9, "{multipliers:?}");
        assert!((multipliers.largest() - restitution).abs() < 1e-9, "{multipliers:?}");
        assert_eq!(multipliers.stability(), Stability::Stable);
    }
    assert_eq!(found.iter().count(), 4);
}

#[test]
fn the_same_multipliers_however_they_are_found() {
    let sweep = Sweep::new(axis("speed", 80.0, 100.0, 5)).settle(4).measure(1).periodic_tolerance(1e-4);
    let sweep = sweep.multipliers(Shooting::new());
    let machine = NfgPair::new(&NfgParams::table1()).unwrap();
    let (start, engine) = (machine.on_drive_flank().unwrap(), LaneTaylor::new(tolerant()));
    let whole = rows(&sweep, &engine, &machine, &start);
    assert!(whole.iter().filter(|row| row.multipliers().is_some()).count() >= 3);
    let expected = whole.fingerprint();
    // Every point alone, without neighbours.
    let family = |p: &Point<'_>| machine.with("speed", p["speed"]);
    let runner = sweep.of(&engine, family).start(|_, _| Ok::<_, ParameterError>(start.clone()));
    let alone = (0..5).map(|i| runner.chunk(i, 5).unwrap()).collect();
    assert_eq!(expected, Rows::merge(alone).unwrap().fingerprint());
    for set in InstructionSet::available() {
        let rows = rows(&sweep, &engine.clone().instructions(set), &machine, &start);
        assert_eq!(expected, rows.fingerprint(), "{set:?}");
    }
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(expected, pool.install(|| rows(&sweep, &engine, &machine, &start)).fingerprint());
    }
    let table = whole.table().unwrap();
    let largest = table.column("largest multiplier").unwrap();
    for (row, largest) in whole.iter().zip(largest) {
        assert_eq!(row.multipliers().map(|found| found.largest()), Some(largest).filter(|x| !x.is_nan()));
    }
}

/// The settings of the shooting are those that are stated; the period multiple is measured.
#[test]
fn a_sweep_shoots_with_its_settings() {
    let sweep = Sweep::new(axis("speed", 90.0, 100.0, 2)).settle(4).measure(1).periodic_tolerance(1e-4);
    let machine = NfgPair::new(&NfgParams::table1()).unwrap();
    let (start, engine) = (machine.on_drive_flank().unwrap(), LaneTaylor::new(tolerant()));
    let other = Shooting::new().flow_method(FlowMethod::Dop853).segments(2);
    let found = rows(&sweep.clone().strobe(1).multipliers(other.clone()), &engine, &machine, &start);
    let row = found.get(1).unwrap();
    let (q, v) = row.strobes().next().unwrap().split_at(1);
    let model = machine.with("speed", 100.0).unwrap();
    let single = other.solve(&model, [&State::new(0.0, q, v)]).unwrap();
    assert_eq!(row.multipliers().as_ref(), Some(single.multipliers()));
    let refused = sweep.clone().multipliers(Shooting::new().period_multiple(2));
    assert!(refused.over(&engine, &machine).unwrap().run().is_err());
    let few = sweep.multipliers(Shooting::new().max_iterations(1).tolerance(1e-15));
    let failed = rows(&few, &engine, &machine, &start);
    let errors: Vec<_> = failed.exponent_errors().values().map(ToString::to_string).collect();
    assert!(errors.len() == 2 && errors.iter().all(|error| error.contains("converge")), "{errors:?}");
}

/// A mass without force rests anywhere in its gap: its orbit is not determined. Its neighbours keep their multipliers.
#[test]
fn an_orbit_that_is_not_determined_fails_alone() {
    let machine = Stops::machine(&[(false, Wave::constant(1.0).unwrap())], 40.0, 1.0, 1.0, 0.0);
    let pulls = Points::from(Axis::of_values("pull", &[0.3, 0.0, 0.4]).unwrap());
    let sweep = Sweep::new(pulls).settle(40).measure(2).periodic_tolerance(1e-4).multipliers(Shooting::new());
    let start = State::at_rest(1);
    let found = rows(&sweep, &LaneTaylor::new(tolerant()), &machine, &start);
    let single = rows(&sweep, &Located(tolerant()), &machine, &start);
    for rows in [&found, &single] {
        assert!(rows.errors().is_empty(), "{:?}", rows.errors());
        let errors: Vec<_> = rows.exponent_errors().iter().collect();
        let [(1, PointError::Multipliers(ShootingError::Singular { component: 0, .. }))] = errors[..] else {
            panic!("{errors:?}")
        };
        let some: Vec<bool> = rows.iter().map(|row| row.multipliers().is_some()).collect();
        assert_eq!(some, [true, false, true]);
    }
}
