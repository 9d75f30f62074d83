//! Periodic orbits by multiple shooting against independently computed orbits.

use crate::api::*;
use crate::common::oscillators::{CubicChain, DeadZone, Duffing, Idler};
use crate::data::read;
use gear_dynamics::models::Oscillator;
use num_complex::Complex64;
use serde_json::Value;
use std::f64::consts::{PI, TAU};

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap()
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(number).collect()
}

fn complex(v: &Value) -> Vec<Complex64> {
    v.as_array().unwrap().iter().map(|z| Complex64::new(number(&z[0]), number(&z[1]))).collect()
}

/// Largest distance between the values of two lists, each value paired with its nearest one.
fn apart(ours: &[Complex64], theirs: &[Complex64]) -> f64 {
    assert_eq!(ours.len(), theirs.len());
    let nearest =
        |z: &Complex64, list: &[Complex64]| list.iter().map(|w| (z - w).norm()).fold(f64::INFINITY, f64::min);
    ours.iter().map(|z| nearest(z, theirs)).chain(theirs.iter().map(|z| nearest(z, ours))).fold(0.0, f64::max)
}

fn state(t: f64, y: &[f64]) -> State {
    let (q, v) = y.split_at(y.len() / 2);
    State::new(t, q, v)
}

/// The state with every component changed by 1e-3, with alternating sign.
fn pushed(y: &[f64]) -> State {
    let y: Vec<f64> = y.iter().enumerate().map(|(i, y)| y + if i % 2 == 0 { 1e-3 } else { -1e-3 }).collect();
    state(0.0, &y)
}

/// Numbers as text with one digit.
fn powers(x: &[f64]) -> String {
    x.iter().map(|x| format!(" {x:.0e}")).collect()
}

/// Largest difference between the first state of an orbit and `y`.
fn off(cycle: &ShootingOrbit, y: &[f64]) -> f64 {
    let first = &cycle.states()[0];
    first.q.iter().chain(&first.v).zip(y).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
}

/// Finds every orbit of the reference data from a state near it, and computes the multipliers of every
/// bifurcation at the given state.
fn every_orbit<M: Periodic>(system: &str, model: impl Fn(f64) -> M) {
    let all = &read("periodic_orbits.json")["time_domain"][system];
    for point in all["points"].as_array().unwrap() {
        let (model, x0) = (model(number(&point["Omega"])), numbers(&point["x0"]));
        let cycle = Shooting::new().solve(&model, &[pushed(&x0)]).unwrap();
        let (state, multipliers) =
            (off(&cycle, &x0), apart(cycle.multipliers().values(), &complex(&point["multipliers"])));
        println!(
            "{system} {}: state {state:.1e}, multipliers {multipliers:.1e} (estimate {:.1e}), \
             corrections {}, {} segments",
            point["Omega"],
            cycle.multipliers().value_error(),
            powers(cycle.corrections()),
            cycle.states().len()
        );
        assert!(state < 1e-9 && multipliers < 1e-9);
        assert_eq!(cycle.crossing_count(), point["n_switch"].as_u64().unwrap());
    }
    for point in all["bifurcations"].as_array().unwrap() {
        let (model, x0) = (model(number(&point["Omega"])), numbers(&point["x0"]));
        let turn =
            Variation::new().flow_tolerance(1e-13).run(&model, &state(0.0, &x0), model.period()).unwrap();
        let multipliers = Multipliers::of_monodromy(&turn.matrix, 1e-9).unwrap();
        let error = apart(multipliers.values(), &complex(&point["multipliers"]));
        println!("{system} {} {}: {error:.1e}", point["type"], point["Omega"]);
        // At a fold one multiplier is 1 and the other stays away from it, so that both are accurate.
        assert!(error < 1e-9);
        assert_eq!(turn.crossings, point["n_switch"].as_u64().unwrap());
        if point["type"] != "LP" {
            let cycle = Shooting::new().solve(&model, &[pushed(&x0)]).unwrap();
            println!("    state {:.1e}, corrections {}", off(&cycle, &x0), powers(cycle.corrections()));
            assert!(off(&cycle, &x0) < 1e-9);
            assert_eq!(cycle.stability(), Stability::Undecided);
        }
    }
}

#[test]
fn duffing() {
    every_orbit("duffing_nlvib01", |omega| Duffing { omega });
}

#[test]
fn dead_zone_of_a_spur_pair() {
    every_orbit("deadzone_KS90", |omega| DeadZone {
        omega,
        zeta: 0.05,
        mean: 0.1,
        amplitude: 0.05 * omega * omega,
        stiffness: 0.0,
    });
}

#[test]
fn dead_zone_under_a_strong_force() {
    every_orbit("deadzone_Fm25_Fp25", |omega| DeadZone {
        omega,
        zeta: 0.05,
        mean: 0.25,
        amplitude: 0.25,
        stiffness: 0.0,
    });
}

#[test]
fn cubic_chain() {
    every_orbit("nlvib02_2dof_cubic", |omega| CubicChain { omega });
}

#[test]
fn spur_pairs_of_the_classics() {
    let mut count = 0;
    for (_, case) in read("classic_orbits.json")["sdof_spur_pair"].as_object().unwrap() {
        let equation = &case["equation"];
        for solutions in case["solutions_at_W"].as_object().unwrap().values() {
            for solution in solutions.as_array().unwrap() {
                let omega = number(&solution["W"]);
                let model = DeadZone {
                    omega,
                    zeta: number(&equation["zeta"]),
                    mean: number(&equation["Fm"]),
                    amplitude: number(&equation["Fah"]) * omega * omega,
                    stiffness: numbers(&equation["a"]).first().copied().unwrap_or(0.0),
                };
                let y = [number(&solution["x0"]), number(&solution["v0"])];
                let cycle = Shooting::new().solve(&model, &[pushed(&y)]).unwrap();
                let multipliers = apart(cycle.multipliers().values(), &complex(&solution["floquet"]));
                println!("{omega}: state {:.1e}, multipliers {multipliers:.1e}", off(&cycle, &y));
                assert!(off(&cycle, &y) < 1e-9 && multipliers < 1e-9);
                assert_eq!(cycle.stability() == Stability::Stable, solution["stable"].as_bool().unwrap());
                assert_eq!(cycle.crossing_count(), solution["crossings"].as_u64().unwrap());
                let (mut statistics, mut rattle) =
                    (Statistics::new(&model, &["q0"]).unwrap(), Rattle::new(&model));
                cycle.observe(&model, &mut (&mut statistics, &mut rattle)).unwrap();
                let q = statistics.summary("q0").unwrap();
                let ours = [q.max, q.min, q.mean, q.deviation, rattle.contacts()[0].loss_fraction()];
                // The reference extremes are those of 4000 samples of a period.
                assert!((-1e-9..2e-7).contains(&(ours[0] - number(&solution["max"]))));
                assert!((-1e-9..2e-7).contains(&(number(&solution["min"]) - ours[1])));
                for (ours, key) in ours[2..].iter().zip(["mean", "rms_about_mean", "gap_fraction"]) {
                    assert!((ours - number(&solution[key])).abs() < 1e-9, "{key}: {ours} {}", solution[key]);
                }
                count += 1;
            }
        }
    }
    assert_eq!(count, 14);
}

#[test]
fn idlers_of_the_classics() {
    let (name, phase) = ("idler_inphase", 0.0);
    {
        let case = &read("classic_orbits.json")["multi_dof"][name];
        for point in case["points"].as_array().unwrap() {
            let (model, y) = (Idler { omega: number(&point["W"]), phase }, numbers(&point["state"]));
            let cycle = Shooting::new().solve(&model, &[pushed(&y)]).unwrap();
            let largest = (cycle.multipliers().largest() - number(&point["max_multiplier_modulus"])).abs();
            println!(
                "{name} {}: state {:.1e}, multiplier {largest:.1e}, reference {}",
                model.omega,
                off(&cycle, &y),
                point["n_vs_2n"]
            );
            assert!(off(&cycle, &y) < 1e-9 && largest < 1e-9);
        }
    }
}

/// The face gear pair, reading A (docs/models.md), from a settled state against tests/data/nfg.json.
#[test]
fn face_gear_pair() {
    check_face_gear_pair(&[140.0, 220.0]);
}

#[test]
#[ignore = "a minute without optimisation: cargo test --release --test suite shooting -- --ignored"]
fn face_gear_pair_at_more_speeds() {
    check_face_gear_pair(&[120.0, 148.0, 180.0]);
}

fn check_face_gear_pair(wanted: &[f64]) {
    let file = read("nfg.json");
    let cases = file["cases"].as_array().unwrap();
    for &speed in wanted {
        let case = cases
            .iter()
            .find(|case| {
                let over = case["params_override"].as_object().unwrap();
                over.len() == 1
                    && over["w1"] == speed
                    && case["options"]["rmode"] == "et"
                    && case["options"]["radius"] == "base"
            })
            .unwrap();
        let params = NfgParams { speed, ..NfgParams::table1() };
        let pair = NfgPair::of_reading(&params, NfgReading::published_on_base_radius()).unwrap();
        let settled = Settle::new()
            .tolerance(1e-4)
            .run(&Dop853::new(), &pair, &pair.on_drive_flank().unwrap())
            .unwrap();
        let cycle = Shooting::new().segments(63).solve(&pair, &[settled.state]).unwrap();
        let first = &cycle.states()[0];
        let ppv = number(&case["ppv"]);
        let off = ((first.q[0] - number(&case["q0"])) / ppv)
            .abs()
            .max(((first.v[0] - number(&case["v0"])) / ppv).abs());
        let mut statistics = Statistics::new(&pair, &["q0"]).unwrap();
        cycle.observe(&pair, &mut statistics).unwrap();
        let q = statistics.summary("q0").unwrap();
        println!(
            "{speed}: {off:.1e} ppv {:.1e} mean {:.1e}, {} crossings, corrections {}, \
             multipliers {} {} error {:.1e}",
            q.peak_to_peak() / ppv - 1.0,
            (q.mean - number(&case["mean"])) / ppv,
            cycle.crossing_count(),
            powers(cycle.corrections()),
            cycle.multipliers().values()[0],
            cycle.multipliers().values()[1],
            cycle.multipliers().value_error(),
        );
        assert!(off < 1e-9);
        assert!((q.peak_to_peak() / ppv - 1.0).abs() < 1e-9);
        assert!(((q.mean - number(&case["mean"])) / ppv).abs() < 1e-9);
        assert_eq!(cycle.crossing_count() as f64, number(&case["events_per_period"]));
        assert_eq!(cycle.stability(), Stability::Stable);
        // Liouville: the product of the multipliers is exp(-2 ζ T).
        let product = cycle.multipliers().values().iter().product::<Complex64>().norm();
        let exact = (-2.0 * params.damping_ratio * pair.period()).exp();
        assert!((product - exact).abs() < 1e-9);
    }
}

/// The ring of three gears, set A at 1000 r/min: the orbit agrees with a settled run in all relative
/// coordinates.
#[test]
#[ignore = "minutes without optimisation: cargo test --release --test suite ring_of_three -- --ignored"]
fn ring_of_three() {
    let ring =
        Ring::as_printed(&RingSet::set_a(3, 1000.0).params().unwrap()).unwrap().with_frame(Frame::Rigid);
    // The largest multiplier is 0.9981: transients need 10⁴ periods to fall to 1e-8.
    let settled =
        Dop853::new().rtol(1e-11).atol(1e-15).end(&ring, &State::at_rest(7), 1e4 * ring.period()).unwrap();
    let near =
        Dop853::new().rtol(1e-11).atol(1e-15).end(&ring, &State::at_rest(7), 30.0 * ring.period()).unwrap();
    let cycle = Shooting::new().solve(&ring, &[State { t: 0.0, ..near }]).unwrap();
    let view = ring.relative(2.65e-5, 1000.0).unwrap();
    let (ours, theirs) = (view.of(&cycle.states()[0]), view.of(&State { t: 0.0, ..settled }));
    for (ours, theirs) in [(&ours.0, &theirs.0), (&ours.1, &theirs.1)] {
        let size = theirs.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let off = ours.iter().zip(theirs).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / size;
        println!("relative motion off by {off:.1e}");
        assert!(off < 1e-6);
    }
}

/// At 5000 r/min the orbit is slightly unstable (a complex pair of multipliers outside the unit circle), so
/// that runs in time stay near it without settling. It is compared with another solver over 20 periods. Both
/// frames give the same orbit, and its rigid multipliers are left out.
#[test]
fn ring_of_three_at_speed() {
    let params = RingSet::set_a(3, 5000.0).params().unwrap();
    let ring = Ring::as_printed(&params).unwrap().with_frame(Frame::Rigid);
    let near =
        Dop853::new().rtol(1e-11).atol(1e-15).end(&ring, &State::at_rest(7), 300.0 * ring.period()).unwrap();
    let cycle = Shooting::new().solve(&ring, &[State { t: 0.0, ..near }]).unwrap();
    println!("corrections{}, largest {}", powers(cycle.corrections()), cycle.multipliers().largest());
    assert_eq!(cycle.multipliers().values().len(), 12);
    assert_eq!(cycle.stability(), Stability::Unstable);
    // Pinned: the largest modulus of the multipliers.
    assert!((cycle.multipliers().largest() - 1.008_267_67).abs() < 1e-8);
    assert!(cycle.mean_acceleration().iter().all(|a| a.abs() < 1e-6));

    let start = &cycle.states()[0];
    let later =
        Rk45::new().rtol(1e-11).atol(1e-14).end(&ring, start, start.t + 20.0 * ring.period()).unwrap();
    let ours = cycle.at(&ring, later.t).unwrap();
    let view = ring.relative(2.65e-5, 1000.0).unwrap();
    for (a, b) in view.of(&later).0.iter().zip(view.of(&ours).0) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
    // The angles agree as well, with the drift of the rigid motion.
    for (a, b) in later.q.iter().zip(&ours.q) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }

    let inertial = Ring::as_printed(&params).unwrap();
    let same = Shooting::new().solve(&inertial, start).unwrap();
    for (a, r) in same.mean_acceleration().iter().zip(inertial.rigid_motion()) {
        assert!((a / (r * inertial.rigid_acceleration()) - 1.0).abs() < 1e-9, "{a}");
    }
    assert!(apart_by(cycle.multipliers(), same.multipliers()) < 1e-8);
}

fn apart_by(a: &Multipliers, b: &Multipliers) -> f64 {
    apart(a.values(), b.values())
}

/// An orbit of period 1, computed over two periods, has the least period multiple 1; one after a period
/// doubling has 2.
#[test]
fn least_period_multiple() {
    let model = DeadZone { omega: 0.7, zeta: 0.05, mean: 0.25, amplitude: 0.25, stiffness: 0.0 };
    let once = Shooting::new().solve(&model, &State::new(0.0, &[-0.62], &[0.27])).unwrap();
    let twice =
        Shooting::new().period_multiple(2).solve(&model, &State::new(0.0, &[-0.62], &[0.27])).unwrap();
    assert_eq!(
        (once.least_period_multiple(), twice.period_multiple(), twice.least_period_multiple()),
        (1, 2, 1)
    );
    let squared: Vec<Complex64> = once.multipliers().values().iter().map(|m| m * m).collect();
    assert!(apart(twice.multipliers().values(), &squared) < 1e-9);

    // Beyond the period doubling at Ω = 0.5127 a run settles to the orbit of period 2.
    let model = DeadZone { omega: 0.505, ..model };
    let settled = Settle::new()
        .tolerance(1e-7)
        .max_periods(2000)
        .run(&Dop853::new(), &model, &State::new(0.0, &[2.26], &[0.84]))
        .unwrap();
    println!("settled to {} periods", settled.period_multiple);
    let cycle =
        Shooting::new().period_multiple(settled.period_multiple).solve(&model, &[settled.state]).unwrap();
    assert_eq!(cycle.least_period_multiple(), settled.period_multiple);
    assert_eq!(cycle.stability(), Stability::Stable);
}

/// Guesses from a list of states, from fewer states and from an orbit at another parameter; states of an
/// orbit at any instant.
#[test]
fn guesses_and_instants() {
    let model =
        |omega| DeadZone { omega, zeta: 0.05, mean: 0.1, amplitude: 0.05 * omega * omega, stiffness: 0.0 };
    let at = model(0.75);
    let one = Shooting::new().solve(&at, &State::new(0.0, &[0.834], &[0.164])).unwrap();
    let times = uniform_times(0.0, at.period(), 40).unwrap();
    let run = Dop853::new().sample(&at, &one.states()[0], &times).unwrap();
    let list: Vec<State> = (0..run.len()).map(|i| run.state(i)).collect();
    let many = Shooting::new().solve(&at, &list).unwrap();
    let thin = Shooting::new().segments(7).solve(&at, &list).unwrap();
    assert_eq!((many.states().len(), thin.states().len()), (40, 7));
    assert!(many.first_correction() < 1e-7);
    for t in [0.3, 5.0, -3.0, 40.0] {
        let wanted = one.at(&at, t).unwrap();
        for cycle in [&many, &thin] {
            let here = cycle.at(&at, t).unwrap();
            assert!((here.q[0] - wanted.q[0]).abs() < 1e-11 && (here.v[0] - wanted.v[0]).abs() < 1e-11);
            assert_eq!(here.t, t);
        }
    }
    let next = Shooting::new().solve_from(&model(0.76), &thin).unwrap();
    let direct = Shooting::new().solve(&model(0.76), &State::new(0.0, &[0.834], &[0.164])).unwrap();
    assert!(off(&next, &[direct.states()[0].q[0], direct.states()[0].v[0]]) < 1e-11);
}

/// q'' = cos t - ω² q has no damping: with a whole ω every motion has two multipliers of 1.
#[test]
fn undamped_resonances_are_singular() {
    for omega in [1.0, 2.0, 3.0, 5.0] {
        let swing = from_fn(1, move |t, q, _, a| a[0] = f64::cos(t) - omega * omega * q[0]).unwrap();
        let model = swing.with_period(TAU).unwrap();
        for q in [0.0, 0.3] {
            let found = Shooting::new().solve(&model, &State::new(0.0, &[q], &[0.0])).map(drop);
            assert!(matches!(found, Err(ShootingError::Singular { .. })), "{omega} {q}: {found:?}");
        }
    }
}

#[test]
fn bad_guesses() {
    let model = DeadZone { omega: 0.75, zeta: 0.05, mean: 0.0, amplitude: 0.0, stiffness: 0.0 };
    let (shooting, rest) = (Shooting::new(), State::at_rest(1));
    // On the edge of a gap in which nothing restores it.
    let at_edge = shooting.solve(&model, &State::new(0.0, &[1.0], &[0.0])).map(drop);
    let on_edge = IntegrateError::RestsOnEdge { t: 0.0, contact: 0 };
    assert!(
        matches!(&at_edge, Err(ShootingError::Integrate { error, .. }) if *error == on_edge),
        "{at_edge:?}"
    );
    // Without a guess it starts at the static state, in the middle of the gap.
    let without = shooting.solve(&model, None).map(drop);
    assert!(matches!(without, Err(ShootingError::Singular { component: 0, .. })), "{without:?}");
    assert!(matches!(
        shooting.solve(&model, &State::at_rest(2)),
        Err(ShootingError::Parameter(ParameterError::Length { .. }))
    ));
    assert!(matches!(
        shooting.solve(&model, &State::new(0.0, &[f64::NAN], &[0.0])),
        Err(ShootingError::Parameter(_))
    ));
    for times in [[0.0, 0.0], [0.0, -1.0], [0.0, 100.0]] {
        let guess = times.map(|t| State { t, ..rest.clone() });
        assert!(matches!(shooting.solve(&model, &guess), Err(ShootingError::GuessTime { index: 1, .. })));
    }
    for bad in [
        shooting.clone().period_multiple(0),
        shooting.clone().segments(0),
        shooting.clone().tolerance(0.0),
        shooting.clone().tolerance(1e3),
        shooting.clone().flow_tolerance(f64::NAN),
        shooting.clone().max_iterations(0),
    ] {
        assert!(matches!(bad.solve(&model, &rest), Err(ShootingError::Parameter(_))));
    }
    // Without load nothing restores the position in the gap: component 0 is undetermined.
    match shooting.solve(&model, &rest) {
        Err(ShootingError::Singular { component: 0, last }) => assert_eq!(last.states.len(), 1),
        other => panic!("{other:?}"),
    }
    // A model that fails during the run: the error names the segment.
    struct Breaks;
    impl Model for Breaks {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = if u[0] < 0.5 { -q[0] } else { f64::NAN };
        }
    }
    impl Periodic for Breaks {
        fn period(&self) -> f64 {
            1.0
        }
    }
    assert!(matches!(
        shooting.solve(&Breaks, &State::at_rest(1)),
        Err(ShootingError::Integrate { segment: 0, .. })
    ));
}

/// A recorded orbit replays what an integration observes, at all instants, and gives its series.
#[test]
fn a_recorded_orbit_needs_no_further_integration() {
    let model = DeadZone { omega: 0.75, zeta: 0.05, mean: 0.1, amplitude: 0.05 * 0.5625, stiffness: 0.0 };
    let orbit = Shooting::new().solve(&model, &State::new(0.0, &[1.0], &[0.25])).unwrap();
    assert_eq!(orbit.crossing_count(), 2);
    let recorded = orbit.record(&model).unwrap();
    let figures = |replayed: bool| {
        let (mut statistics, mut rattle) =
            (Statistics::new(&model, &["q0", "mesh force"]).unwrap(), Rattle::new(&model));
        let mut both = (&mut statistics, &mut rattle);
        if replayed {
            recorded.replay(&mut both).unwrap();
        } else {
            orbit.observe(&model, &mut both).unwrap();
        }
        let [q, f] = ["q0", "mesh force"].map(|name| statistics.summary(name).unwrap());
        [q.mean, q.rms, q.max, q.min, f.mean, f.rms, rattle.contacts()[0].loss_fraction()]
    };
    for (a, b) in figures(true).into_iter().zip(figures(false)) {
        assert!((a - b).abs() < 1e-11, "{a} {b}");
    }
    for i in 0..200 {
        let t = 0.3 + 0.171 * f64::from(i);
        let (a, b) = (recorded.at(t).unwrap(), orbit.at(&model, t).unwrap());
        assert!((a.q[0] - b.q[0]).abs() < 1e-11 && (a.v[0] - b.v[0]).abs() < 1e-11, "{t}: {a:?} {b:?}");
    }
    let crossings = recorded.crossings();
    assert_eq!(crossings.len(), 2);
    for (t, _) in crossings {
        assert!((recorded.at(t).unwrap().q[0] - 1.0).abs() < 1e-12);
    }
    let series = recorded.fourier(&Harmonics::up_to(40)).unwrap();
    let mean = figures(true)[0];
    assert!((series.coefficients(0)[0] - mean).abs() < 1e-9);
    assert!(recorded.at(f64::NAN).is_err());
}

/// A body without support that a mean torque accelerates has no periodic orbit; one that turns evenly has.
#[test]
fn bodies_that_accelerate_freely_have_no_orbit() {
    use gear_dynamics::model::from_fn;
    use std::f64::consts::TAU;
    let one = from_fn(1, |_, _, _, a| a[0] = 1.0).unwrap().with_period(TAU).unwrap();
    let error = Shooting::new().solve(&one, &State::at_rest(1)).unwrap_err();
    let ShootingError::Accelerates { coordinate: 0, gain, .. } = error else { panic!("{error}") };
    assert!((gain - TAU).abs() < 1e-9);
    let two = from_fn(2, |t, _, _, a| (a[0], a[1]) = (t.cos(), -0.3)).unwrap().with_period(TAU).unwrap();
    let error = Shooting::new().solve(&two, &State::at_rest(2)).unwrap_err();
    assert!(matches!(error, ShootingError::Accelerates { coordinate: 1, .. }), "{error}");
    let even = from_fn(1, |t, _, _, a| a[0] = t.cos()).unwrap().with_period(TAU).unwrap();
    assert!(Shooting::new().solve(&even, &State::at_rest(1)).is_ok());
}

/// A body that nothing connects must not accelerate beside an oscillator either; it may turn at a constant mean
/// speed, and a pair that is connected may accelerate.
#[test]
fn an_unconnected_body_that_accelerates_has_no_orbit() {
    use gear_dynamics::model::from_fn;
    use std::f64::consts::TAU;
    let beside = |mean: f64, speed: f64| {
        let model = from_fn(2, move |t, q, v, a| {
            (a[0], a[1]) = (mean + (2.0 * t).cos(), t.cos() - 4.0 * q[1] - 0.1 * v[1]);
        });
        let model = model.unwrap().with_period(TAU).unwrap();
        Shooting::new().solve(&model, &State::new(0.0, &[0.0, 0.0], &[speed, 0.0]))
    };
    for mean in [1.0, -1e-3] {
        let error = beside(mean, 0.0).unwrap_err();
        let ShootingError::Accelerates { coordinate: 0, gain, .. } = error else { panic!("{error}") };
        assert!((gain - mean * TAU).abs() < 1e-9);
    }
    let turning = beside(0.0, 50.0).unwrap();
    assert!((turning.drift().0[0] - 50.0 * TAU).abs() < 1e-9 && turning.drift().1[0].abs() < 1e-9);
    let pair = from_fn(3, |t, q, v, a| {
        let shaft = 4.0 * (q[1] - q[2]) + 0.1 * (v[1] - v[2]);
        (a[0], a[1], a[2]) = (0.0, t.cos() + 0.5 - shaft, shaft);
    });
    let pair = pair.unwrap().with_period(TAU).unwrap();
    let orbit = Shooting::new().solve(&pair, &State::at_rest(3)).unwrap();
    assert!((orbit.mean_acceleration()[1] - 0.25).abs() < 1e-9);
}

/// The motion of a far guess is far larger than that of the orbit: corrections below its rounding were taken for an orbit.
#[test]
fn orbits_from_far_guesses_close() -> std::result::Result<(), Box<dyn std::error::Error>> {
    let pair = gear_dynamics::trains::SpurPair::of_numbers(0.05, 0.1, &[0.2], &[0.05])?
        .parts()?
        .build("driver", 0.5)?;
    let mut found = 0;
    for q in [0.8, 0.9, 1.0, 1.1, 1.2, 3e8, 1e9, 1e10, 1e12, 1e15, 1e30] {
        let Ok(orbit) = Shooting::new().solve(&pair, &State::new(0.0, &[q], &[0.0])) else { continue };
        let start = &orbit.states()[0];
        let end = Taylor::new().end(&pair, start, start.t + pair.period())?;
        assert!(
            (end.q[0] - start.q[0]).abs() < 1e-8 && (end.v[0] - start.v[0]).abs() < 1e-8,
            "{q:e}: {start:?} {end:?}"
        );
        assert!(orbit.accuracy() < 1e-9 && orbit.range()[0] < 100.0, "{q:e}: {:?}", orbit.range());
        found += 1;
    }
    assert!(found > 0, "no guess leads to an orbit");
    Ok(())
}

#[test]
fn a_wrong_period_is_refused() {
    let motion = |t: f64, q: &[f64], v: &[f64], a: &mut [f64]| a[0] = t.cos() - 2.0 * q[0] - 0.1 * v[0];
    let of = |period: f64| from_fn(1, motion).and_then(|model| model.with_period(period)).unwrap();
    let start = State::new(0.0, &[0.9], &[0.0]);
    for period in [5.0, PI, 6.3, 1.0] {
        let error = Shooting::new().solve(&of(period), &start).unwrap_err();
        let wrong =
            ParameterError::Wrong { name: "period of the model".into(), value: period, must: String::new() };
        assert!(error.to_string().contains(&wrong.to_string()), "{error}");
    }
    for multiple in [1.0, 3.0] {
        assert!(Shooting::new().solve(&of(multiple * TAU), &start).is_ok());
    }
}

/// Without a force a damped motion comes to rest, at 0 too, where no motion is left to correct.
#[test]
fn damped_motions_without_a_force_come_to_rest() {
    for (load, period) in [(0.0, 0.1), (0.0, 1.0), (0.0, 30.0), (1e-3, 0.1), (1.0, 0.1), (1.0, 30.0)] {
        let model = Oscillator::new(&[
            ("speed", TAU / period),
            ("damping", 0.1),
            ("linear stiffness", 1.0),
            ("mean force", load),
        ]);
        let model = model.unwrap();
        for start in [Some(State::new(0.0, &[0.3], &[0.0])), None] {
            let orbit = Shooting::new().solve(&model, start.as_ref()).unwrap();
            let state = &orbit.states()[0];
            assert!(
                (state.q[0] - load).abs() < 1e-12 && state.v[0].abs() < 1e-12,
                "{load} {period} {state:?}"
            );
            let largest = (-0.05 * period).exp();
            assert!((orbit.multipliers().largest() - largest).abs() < 1e-9, "{load} {period}");
        }
    }
}
