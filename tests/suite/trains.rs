//! Gear trains from parts: published frequencies and orbits, the ring of parts.

use crate::api::*;
use crate::common::planets::{on_bearings, ring_held, ring_locked};
use crate::data::read;
use gear_dynamics::linear::{Campbell, Modes, static_state};
use gear_dynamics::trains::*;
use gear_dynamics::{Ring, Wave};
use serde_json::Value;

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap()
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(number).collect()
}

/// The planetary set of Lin and Parker 1999 with N planets, whose paper gives I/r² and torsional stiffnesses at the
/// base circles. The tooth numbers are any that assemble.
fn planetary(
    mass: &Value,
    inertia: &Value,
    alpha: f64,
    mesh: f64,
    bearings: [f64; 4],
    turn: [f64; 3],
    n: u32,
) -> Train {
    let radii = [0.03, 0.03, 0.09, 0.06 / alpha.to_radians().cos()];
    let inertias =
        [("s", 0), ("p", 1), ("r", 2), ("c", 3)].map(|(key, i)| number(&inertia[key]) * radii[i] * radii[i]);
    let bearing = |key: &str, k: f64| Bearing::new(number(&mass[key]), k);
    let [ks, kp, kr, kc] = bearings;
    let k = || Wave::constant(mesh).unwrap();
    let bearings = [bearing("s", ks), bearing("p", kp), bearing("r", kr), bearing("c", kc)];
    let mut members = on_bearings(ring_held([30, 30, 90], inertias, turn[1] * radii[2].powi(2)), bearings);
    members.sun.1 = members.sun.1.restrained(turn[0] * radii[0].powi(2), 0.0);
    members.carrier = members.carrier.restrained(turn[2] * radii[3].powi(2), 0.0);
    let set = Planetary::new(n, radii[0], members, [k(), k()]).unwrap().pressure_angle(alpha.to_radians());
    set.parts().build("sun", 100.0).unwrap()
}

fn lin_parker(n: u32) -> Train {
    let data = read("gear_trains.json");
    let p = &data["lin_parker_params"]["params"];
    let of = |key: &str| number(&p[key]);
    let bearings = [of("ks"), of("kp"), of("kr"), of("kc")];
    assert_eq!(p["ksp"], p["krp"]);
    planetary(&p["m"], &p["I"], of("alpha"), of("ksp"), bearings, [of("ksu"), of("kru"), of("kcu")], n)
}

fn cooley_parker(n: u32) -> Train {
    let data = read("gear_trains.json");
    let p = &data["cooley_parker_2012"]["params"];
    let of = |key: &str| number(&p[key]);
    let bearings = [of("k_s"), of("k_p"), of("k_r"), of("k_c")];
    let turn = [of("k_su"), of("k_ru"), of("k_cu")];
    planetary(&p["m_kg"], &p["I_over_r2_kg"], of("alpha_deg"), of("k_sp=k_rp"), bearings, turn, n)
}

#[test]
fn lin_and_parker_three_planets() {
    let train = lin_parker(3);
    let modes = Modes::in_contact(&train, 0.0).unwrap();
    let (kinds, hertz) = (train.kinds(&modes), modes.hertz());
    let data = &read("gear_trains.json")["lin_parker_params"]["computed_Hz"]["3"];
    let of = |kind: ModeKind| -> Vec<f64> {
        hertz.iter().zip(&kinds).filter(|(_, own)| **own == kind).map(|(f, _)| *f).collect()
    };
    let rotational = of(ModeKind::Rotational);
    let translational = of(ModeKind::Translational);
    assert!(rotational[0] < 1e-3, "{rotational:?}");
    let mut worst = 0.0f64;
    for (ours, theirs) in rotational[1..].iter().zip(&numbers(&data["rot"])[1..]) {
        worst = worst.max((ours / theirs - 1.0).abs());
    }
    assert_eq!((rotational.len(), translational.len(), modes.rigid_count()), (6, 12, 1));
    for (pair, theirs) in translational.chunks(2).zip(numbers(&data["trans"])) {
        worst = worst.max((pair[0] / theirs - 1.0).abs()).max((pair[1] / theirs - 1.0).abs());
    }
    println!("largest deviation {worst:.1e}");
    assert!(worst < 1e-9);
}

#[test]
fn cooley_and_parker_three_planets() {
    let train = cooley_parker(3);
    let modes = Modes::in_contact(&train, 0.0).unwrap();
    let data = &read("gear_trains.json")["cooley_parker_2012"];
    let scale = (1e7f64 / 1.86).sqrt();
    let ours: Vec<f64> = modes.frequencies().iter().map(|w| w / scale).collect();
    let theirs = numbers(&data["computed_nondimensional"]["3"]);
    let worst = ours.iter().zip(&theirs).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    println!("largest deviation {worst:.1e}");
    assert!(ours.len() == theirs.len() && worst < 1e-9);
    let kinds = train.kinds(&modes);
    for (value, kind) in ours.iter().zip(kinds) {
        let list = if kind == ModeKind::Rotational { "rot" } else { "trans_x2" };
        let published = numbers(&data["published_nondimensional"]["3"][list]);
        let unit = if *value < 1.0 { 1e-4 } else { 1e-3 };
        assert!(published.iter().any(|p| (p - value).abs() < 0.6 * unit), "{value} {kind:?}");
    }
}

/// With four planets one planet mode of each of three shapes, with five a pair of each: N - 3 planet modes a shape.
#[test]
fn counts_of_modes_by_kind() {
    for train in [lin_parker, cooley_parker] {
        for n in [3usize, 4, 5, 6] {
            let train = train(n as u32);
            let modes = Modes::in_contact(&train, 0.0).unwrap();
            let kinds = train.kinds(&modes);
            let count = |kind: ModeKind| kinds.iter().filter(|own| **own == kind).count();
            let counts = [ModeKind::Rotational, ModeKind::Translational, ModeKind::Planet].map(count);
            assert_eq!(counts, [6, 12, 3 * (n - 3)], "{n} planets");
            for mode in modes.all().iter().skip(modes.rigid_count()) {
                let energies = train.strain_energy(mode, 0.0);
                assert!((energies.iter().map(|energy| energy.1).sum::<f64>() - 1.0).abs() < 1e-12);
            }
        }
    }
}

/// Central gears without a stated centre stand at that of their carrier: the place of a set has no effect.
#[test]
fn a_set_has_the_same_modes_at_any_place() {
    let frequencies = |centre: [f64; 2]| -> Vec<f64> {
        let members = on_bearings(ring_locked([30, 30, 90], [1e-3; 4]), [Bearing::new(1.0, 1e8); 4]);
        let members = Members { carrier: members.carrier.clone().centre(centre), ..members };
        let train =
            Planetary::new(3, 0.03, members, [k(), k()]).unwrap().parts().build("sun", 100.0).unwrap();
        Modes::in_contact(&train, 0.0).unwrap().all().iter().map(|mode| mode.frequency()).collect()
    };
    let (here, there) = (frequencies([0.0, 0.0]), frequencies([0.3, -0.2]));
    let most = here[here.len() - 1];
    assert!(here.iter().zip(&there).all(|(one, other)| (one - other).abs() < 1e-9 * most));
}

#[test]
fn kahraman_fixed_ring() {
    let p = &read("gear_trains.json")["kahraman_1994_fixed_ring"];
    let k = |key: &str| Wave::constant(number(&p["params"][key])).unwrap();
    let inertias = numbers(&p["params"]["inertia_diag"]);
    let members = ring_locked([30, 30, 90], [inertias[4], inertias[1], 1.0, inertias[0]]);
    let mut parts = Planetary::new(3, 0.5, members, [k("k_sp"), k("k_rp")]).unwrap().parts();
    let train = parts.accept(Warning::UnusualValue).build("sun", 1.0).unwrap();
    let modes = Modes::in_contact(&train, 0.0).unwrap();
    for (ours, theirs) in modes.hertz().iter().zip(numbers(&p["published_Hz"])) {
        println!("{ours} {theirs}");
        assert!((ours - theirs).abs() < 1e-8);
    }
}

fn state(y: &[f64]) -> State {
    let (q, v) = y.split_at(y.len() / 2);
    State::new(0.0, q, v)
}

/// The orbit of a train from a state near the one given, and its distance from it.
fn orbit(train: &Train, y: &[f64]) -> (ShootingOrbit, f64) {
    let near: Vec<f64> =
        y.iter().enumerate().map(|(i, y)| y + if i % 2 == 0 { 1e-3 } else { -1e-3 }).collect();
    let cycle = Shooting::new().solve(train, &[state(&near)]).unwrap();
    let first = &cycle.states()[0];
    let off = first.q.iter().chain(&first.v).zip(y).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
    (cycle, off)
}

/// Two bodies of inertia 2 and radius 1: one relative coordinate with the mass 1.
#[test]
fn spur_pairs_of_the_classics_from_parts() {
    let mut count = 0;
    for case in read("classic_orbits.json")["sdof_spur_pair"].as_object().unwrap().values() {
        let equation = &case["equation"];
        let of = |key: &str| number(&equation[key]);
        let k = numbers(&equation["a"]).first().map_or(vec![], |a| vec![[*a, 0.0]]);
        for solution in
            case["solutions_at_W"].as_object().unwrap().values().flat_map(|v| v.as_array().unwrap())
        {
            // x'' = y'' - e'' with e = F_ah cos φ: the force F_ah W² cos φ of the equation.
            let mut parts = Parts::new();
            parts.body("driver", Body::new(2.0)).body("driven", Body::new(2.0));
            let mesh = MeshPart::external([1, 1], [1.0, 1.0], Wave::new(Fourier::new(1.0, &k).unwrap()))
                .error(Wave::new(Fourier::new(0.0, &[[of("Fah"), 0.0]]).unwrap()))
                .damping(2.0 * of("zeta"))
                .half_backlash(1.0);
            parts.mesh("mesh", "driver", "driven", mesh);
            parts.torque("drive", "driver", of("Fm")).torque("load", "driven", -of("Fm"));
            parts.coordinates(Coordinates::Relative).accept(Warning::UnusualValue);
            let train = parts.build("driver", number(&solution["W"])).unwrap();
            let y = [number(&solution["x0"]) + of("Fah"), number(&solution["v0"])];
            let (cycle, off) = orbit(&train, &y);
            assert!(off < 1e-9, "{off:e}");
            assert_eq!(cycle.crossing_count(), solution["crossings"].as_u64().unwrap());
            count += 1;
        }
    }
    assert_eq!(count, 14);
}

#[test]
fn idlers_of_the_classics_from_parts() {
    let case = &read("classic_orbits.json")["multi_dof"]["idler_inphase"];
    for point in case["points"].as_array().unwrap() {
        let mut parts = Parts::new();
        for (name, inertia) in [("first", 1.0), ("idler", 1.5), ("last", 0.8)] {
            parts.body(name, Body::new(inertia));
        }
        for (name, ends, a) in [("one", ["first", "idler"], 0.2), ("two", ["idler", "last"], 0.15)] {
            let stiffness = Wave::new(Fourier::new(1.0, &[[a, 0.0]]).unwrap());
            let mesh = MeshPart::external([1, 1], [1.0, 1.0], stiffness).damping(0.06).half_backlash(1.0);
            parts.mesh(name, ends[0], ends[1], mesh.phase(0.0)); // in phase, as published
        }
        // Mean mesh forces 0.1 and 0.12.
        parts.torque("t1", "first", 0.1).torque("t2", "idler", 0.02).torque("t3", "last", -0.12);
        parts.coordinates(Coordinates::Relative).accept(Warning::UnusualValue);
        let train = parts.build("first", number(&point["W"])).unwrap();
        // Coordinates relative to the last gear: p_1 = y_1 - y_2, p_2 = y_2.
        let p = numbers(&point["state"]);
        let (_, off) = orbit(&train, &[p[0] + p[1], p[1], p[2] + p[3], p[3]]);
        println!("{}: {off:.1e}", point["W"]);
        assert!(off < 1e-8);
    }
}

fn ring_of_parts(params: &RingParams) -> Train {
    let mut parts = ring_parts(params, 20).unwrap();
    parts.accept(Warning::Unbalanced).build("gear 1", params.omega / 20.0).unwrap()
}

#[test]
fn a_ring_of_parts_is_the_ring() {
    for n in [3, 4, 16] {
        let params = RingSet::set_a(n, 1000.0).params().unwrap();
        let (ring, train) = (Ring::as_printed(&params).unwrap(), ring_of_parts(&params));
        assert_eq!((ring.dof(), ring.contacts()), (train.dof(), train.contacts()));
        assert!((ring.period() / train.period() - 1.0).abs() < 1e-14);
        let mut worst = 0.0f64;
        for look in 0..50 {
            let part = |i: usize| ((look * 37 + i * 101) as f64 * 0.618).fract() - 0.5;
            let q: Vec<f64> = (0..ring.dof()).map(|i| 1e-3 * part(i)).collect();
            let v: Vec<f64> = (0..ring.dof()).map(|i| part(i + 500)).collect();
            let acceleration = |model: &dyn Model| {
                let (mut u, mut a) = (vec![0.0; model.drives()], q.clone());
                model.drive(1e-4 * look as f64, Side::After, &mut u);
                model.accel(&u, &q, &v, &mut a);
                a
            };
            let (ours, theirs) = (acceleration(&train), acceleration(&ring));
            let size = theirs.iter().fold(0.0f64, |m, a| m.max(a.abs()));
            for (a, b) in ours.iter().zip(&theirs) {
                worst = worst.max((a - b).abs() / size);
            }
        }
        println!("n = {n}: {worst:.1e}");
        assert!(worst < 2e-15);
    }
}

pub(crate) fn k() -> Wave {
    Wave::constant(2e8).unwrap()
}

/// A pair of gears of 20 and 40 teeth.
pub(crate) fn pair() -> Parts {
    let mut parts = Parts::new();
    parts.body("pinion", Body::new(2e-3)).body("wheel", Body::new(8e-3));
    parts.mesh("mesh", "pinion", "wheel", MeshPart::external([20, 40], [0.03, 0.06], k()));
    parts
}

#[test]
fn phases_of_planets_follow_from_teeth() {
    let wave = || Wave::new(Fourier::new(2e8, &[[4e7, 0.0]]).unwrap());
    let stated = |phase: f64| {
        let mut parts = Parts::new();
        parts.body("sun", Body::new(1e-3)).body("carrier", Body::new(1e-2));
        parts.body("ring", Body::new(1e-2).locked());
        // 19 teeth at 120 degrees: 19/3 mesh cycles behind, that is 2/3 ahead.
        parts.body("planet", Body::new(1e-3).carried_by("carrier", std::f64::consts::TAU / 3.0));
        let radii = [19, 17].map(|z| 1.5e-3 * f64::from(z));
        parts.mesh("inner", "sun", "planet", MeshPart::external([19, 17], radii, wave()).stated_phase(phase));
        let radii = [17, 53].map(|z| 1.5e-3 * f64::from(z));
        parts.mesh("outer", "planet", "ring", MeshPart::internal([17, 53], radii, wave()));
        parts.build("sun", 10.0)
    };
    assert!(stated(2.0 / 3.0).is_ok());
    let error = stated(0.25).unwrap_err();
    let TrainError::PhaseContradicts { computed, .. } = error else { panic!("{error}") };
    assert!((computed - 2.0 / 3.0).abs() < 1e-12);
}

/// Everything that a train can consist of, apart from what relative coordinates and a rotating frame exclude.
fn elaborate(clearance: f64) -> Parts {
    let wave = |mean: f64, a: f64| Wave::new(Fourier::new(mean, &[[a, 0.3 * a]]).unwrap());
    let bearing = |mass: f64| Bearing::new(mass, 1e8).damping(300.0);
    let bearings = [
        bearing(1.0).half_clearance(clearance),
        bearing(0.6).half_clearance(2.0 * clearance),
        bearing(3.0),
        bearing(4.0),
    ];
    let members = on_bearings(ring_held([30, 30, 90], [1e-3, 1e-3, 5e-2, 3e-2], 1e6), bearings);
    let set = Planetary::new(3, 0.03, members, [wave(2e8, 4e7), wave(3e8, 3e7)])
        .unwrap()
        .error([wave(0.0, 2e-6), wave(0.0, 1e-6)])
        .angles(&[0, 39, 82].map(|place| std::f64::consts::TAU * f64::from(place) / 120.0))
        .damping(2000.0)
        .half_backlash(3e-5);
    let mut parts = Parts::new();
    parts.join("set", set.parts());
    parts
        .body("motor", Body::new(2e-2).drag(0.2))
        .body("load", Body::new(0.5))
        .body("flange", Body::new(1e-2));
    parts.shaft("input shaft", "motor", "set sun", ShaftPart::new(5e4).damping(2.0).half_clearance(1e-4));
    parts.shaft("output shaft", "set carrier", "load", ShaftPart::new(1e6).damping(50.0));
    let mesh = MeshPart::external([40, 60], [0.04, 0.06], wave(2e8, 5e7))
        .damping(1000.0)
        .half_backlash(2e-5)
        .friction(0.08)
        .error_of_turn(OfMesh::Driven, wave(0.0, 5e-6))
        .stiffness_of_turn(OfMesh::Driver, wave(1.0, 0.1));
    parts.body("pinion", Body::new(2e-2).bearing(bearing(2.0)).centre([0.5, 0.0]));
    parts
        .shaft("pinion shaft", "load", "pinion", ShaftPart::new(1e6).damping(20.0))
        .mesh("output", "pinion", "flange", mesh);
    parts.motor(
        "motor torque",
        "motor",
        InductionMotor { breakdown_torque: 80.0, breakdown_slip: 0.2, synchronous_speed: 160.0 },
    );
    parts.torque_of_angle("pulse", "motor", 2.0, wave(0.0, 1.0));
    parts.torque("load torque", "flange", -60.0);
    parts
}

#[test]
fn an_elaborate_train_is_consistent() {
    let train = elaborate(0.0).build("motor", 150.0).unwrap();
    let q: Vec<f64> = (0..train.dof()).map(|i| 1e-5 * (1.0 + (i as f64).sin())).collect();
    let findings = check_periodic(&train, &State::new(0.0, &q, &vec![1e-3; q.len()]));
    assert!(findings.is_empty(), "{findings:?}");
    // The check expects forces of constant direction. That of a radial clearance turns.
    let train = elaborate(1e-5).build("motor", 150.0).unwrap();
    // Constants that the algebra reads as they are have slots, at which random processes add to them.
    for name in ["output damping", "output half backlash", "output friction", "load torque", "motor torque"] {
        assert!(train.slot(name).is_ok(), "{name}");
    }
    assert_eq!(train.contacts(), 3 + 3 + 1 + 1 + 4);
    // Two integrators that have nothing in common but the model.
    let start = State::at_rest(train.dof());
    let end = |solver: &dyn Fn() -> State| solver();
    let one = end(&|| Dop853::new().rtol(1e-11).atol(1e-16).end(&train, &start, 0.02).unwrap());
    let two = end(&|| Taylor::new().rtol(1e-12).atol(1e-17).end(&train, &start, 0.02).unwrap());
    let size = one.q.iter().fold(0.0f64, |m, q| m.max(q.abs()));
    let apart = one.q.iter().zip(&two.q).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
    println!("largest coordinate {size:.2e}, difference {apart:.1e}");
    assert!(apart < 1e-8 * size);
}

#[test]
fn planetary_maps_in_lanes_are_those_one_by_one() {
    let wave = || Wave::new(Fourier::new(2e8, &[[4e7, 0.0]]).unwrap());
    let members = ring_locked([30, 30, 90], [1e-3, 1e-3, 5e-2, 3e-2]);
    let set = Planetary::new(3, 0.03, members, [wave(), wave()]).unwrap();
    let mut parts = set.damping(2000.0).half_backlash(3e-5).parts();
    parts.torque("drive", "sun", 30.0).torque("load", "carrier", -120.0).coordinates(Coordinates::Relative);
    let train = parts.build("sun", 100.0).unwrap();
    let speeds = Axis::linear("speed", 80.0, 200.0, 12).unwrap();
    let sweep = Sweep::new(speeds).settle(3).measure(3).channels(&["deflection 0"]);
    let model = |p: &Point<'_>| train.with("speed", p["speed"]);
    let start =
        |_: &Point<'_>, train: &Train| Ok::<_, gear_dynamics::ParameterError>(State::at_rest(train.dof()));
    let lanes = sweep.of(&LaneRk4::new(64).lanes::<8>(), model).start(start).run().unwrap();
    let single = sweep.of(&TableRk4::new(64), model).start(start).run().unwrap();
    assert_eq!(lanes.iter().count(), 12);
    for (a, b) in lanes.iter().zip(single.iter()) {
        let [a, b] = [a, b].map(|row| row.channel("deflection 0").unwrap());
        assert!((a.max - b.max).abs() + (a.min - b.min).abs() < 1e-12 * a.max.abs(), "{a:?} {b:?}");
    }
}

/// A mass on an isotropic bearing, seen from a frame with the speed Ω, has the frequencies ω ± Ω.
#[test]
fn rotating_frames_split_frequencies() {
    let mut parts = Parts::new();
    parts.body("carrier", Body::new(1.0).bearing(Bearing::new(2.0, 8e6))).rotating_with("carrier");
    let train = parts.build("carrier", 300.0).unwrap();
    let found: Vec<f64> =
        Modes::in_contact(&train, 0.0).unwrap().eigenvalues().iter().map(|l| l.norm()).collect();
    for (found, exact) in found.iter().zip([1700.0, 2300.0]) {
        assert!((found / exact - 1.0).abs() < 1e-12, "{found}");
    }
    assert_eq!(found.len(), 2);
    // A damper at rest damps both by c/(2 m) at speed 0; the sum of all real parts does not depend on the speed.
    let mut damped = Parts::new();
    damped
        .body("carrier", Body::new(1.0).bearing(Bearing::new(2.0, 8e6).damping(40.0)))
        .rotating_with("carrier");
    let modes = Modes::in_contact(&damped.build("carrier", 300.0).unwrap(), 0.0).unwrap();
    let exact = num_complex::Complex64::new(-10.0, (4e6f64 - 100.0).sqrt());
    for (found, turn) in modes.eigenvalues().iter().zip([-300.0, 300.0]) {
        let expected = exact + num_complex::Complex64::new(0.0, turn);
        assert!((found - expected).norm() < 1e-9 * exact.norm(), "{found} {expected}");
    }
}

/// Forces of the parts in closed form.
#[test]
fn forces_of_bearings_friction_and_motors() {
    let at = |train: &Train, q: &[f64], v: &[f64]| {
        let (mut u, mut a) = (vec![0.0; train.drives()], vec![0.0; train.dof()]);
        train.drive(0.0, Side::After, &mut u);
        train.accel(&u, q, v, &mut a);
        a
    };
    let near = |found: f64, exact: f64| {
        assert!((found - exact).abs() <= 1e-12 * exact.abs().max(1e-3), "{found} {exact}")
    };
    // A shaft in a bearing of radial clearance: r = 5e-5 at (3e-5, 4e-5), 3e-5 past the clearance.
    let mut parts = Parts::new();
    parts.body("rotor", Body::new(1.0).bearing(Bearing::new(2.0, 1e8).half_clearance(2e-5)));
    let rotor = parts.build("rotor", 100.0).unwrap();
    let a = at(&rotor, &[0.0, 3e-5, 4e-5], &[0.0; 3]);
    near(a[1], -1e8 * 3e-5 * 0.6 / 2.0);
    near(a[2], -1e8 * 3e-5 * 0.8 / 2.0);
    assert_eq!(at(&rotor, &[0.0, 1e-5, 0.0], &[0.0; 3])[1], 0.0);
    // An induction motor at its breakdown slip, and at the synchronous speed.
    let mut parts = Parts::new();
    parts.body("rotor", Body::new(0.5)).motor(
        "torque",
        "rotor",
        InductionMotor { breakdown_torque: 40.0, breakdown_slip: 0.2, synchronous_speed: 100.0 },
    );
    near(at(&parts.build("rotor", 80.0).unwrap(), &[0.0], &[0.0])[0], 40.0 / 0.5);
    near(at(&parts.build("rotor", 80.0).unwrap(), &[0.0], &[20.0])[0], 0.0);
    // A direct-current motor, 30 N m (1 - Ω/200), and a fan, -5 N m (Ω/100)², on one rotor.
    let mut parts = Parts::new();
    parts.body("rotor", Body::new(0.5)).torque_of_speed("motor", "rotor", 30.0, &[1.0, -1.0 / 200.0]);
    parts.torque_of_speed("fan", "rotor", -5.0, &[0.0, 0.0, 1e-4]);
    near(at(&parts.build("rotor", 80.0).unwrap(), &[0.0], &[20.0])[0], (15.0 - 5.0) / 0.5);
    // Friction at the pitch point: μ W r tan α on both gears against the drive, and μ W along the line of centres.
    let mut parts = Parts::new();
    parts
        .body("one", Body::new(1e-3).bearing(Bearing::new(2.0, 0.0)))
        .body("two", Body::new(2e-3).centre([0.1, 0.0]));
    parts.mesh("mesh", "one", "two", MeshPart::external([20, 30], [0.02, 0.03], k()).friction(0.1));
    let train = parts.accept(Warning::Unsupported).build("one", 10.0).unwrap();
    let without = at(&train.with("mesh friction", 0.0).unwrap(), &[1e-3, 0.0, 0.0, 0.0], &[0.0; 4]);
    let with = at(&train, &[1e-3, 0.0, 0.0, 0.0], &[0.0; 4]);
    let (w, tan) = (2e8 * 1e-3 * 0.02, 20f64.to_radians().tan());
    let (sin, cos) = 20f64.to_radians().sin_cos();
    near(without[0], -w * 0.02 / 1e-3);
    near(without[1], -w * sin / 2.0); // the line of action n = (sin α, cos α)
    near(without[2], -w * cos / 2.0);
    // At the mesh angle 0 the teeth approach the pitch point: s = -1.
    near(with[0] - without[0], 0.1 * w * 0.02 * tan / 1e-3);
    // The second gear turns clockwise and counts its angle so.
    near(with[3] - without[3], -0.1 * w * 0.03 * tan / 2e-3);
    near(with[1] - without[1], -0.1 * w * cos / 2.0);
    near(with[2] - without[2], 0.1 * w * sin / 2.0);
}

/// Harmonic l of the transmission error drives the kinds of modes that the rule of Parker 2000 names, and no others.
#[test]
fn mesh_phasing_of_planets() {
    for case in read("gear_trains.json")["mesh_phasing"]["values"].as_array().unwrap() {
        let of = |key: &str| case[key].as_u64().unwrap() as u32;
        if !case["assembles"].as_bool().unwrap() {
            let teeth = [of("Zs"), (of("Zr") - of("Zs")) / 2, of("Zr")];
            let members = ring_held(teeth, [1e-3; 4], 1e6);
            let set = Planetary::new(of("N"), 0.03, members, [k(), k()]).unwrap();
            let error = set.parts().build("sun", 10.0).unwrap_err();
            assert!(matches!(error, TrainError::DoesNotAssemble { .. }), "{error}");
            continue;
        }
        let error = || {
            Wave::new(Fourier::new(0.0, &[[1e-6, 5e-7], [3e-7, 2e-7], [1e-7, 4e-7], [2e-7, 1e-7]]).unwrap())
        };
        let bearing = |mass: f64| Bearing::new(mass, 1e8);
        let teeth = [of("Zs"), of("Zp"), of("Zr")];
        let bearings = [bearing(0.4), bearing(0.7), bearing(2.0), bearing(5.0)];
        let members = on_bearings(ring_held(teeth, [3e-4, 5e-4, 2e-2, 3e-2], 1e6), bearings);
        let set = Planetary::new(of("N"), 0.03, members, [k(), k()])
            .unwrap()
            .pressure_angle(if of("Zs") == 19 { 0.49075 } else { 25f64.to_radians() })
            .error([error(), error()]);
        let train = set.parts().build("sun", 10.0).unwrap();
        let modes = Modes::in_contact(&train, 0.0).unwrap();
        let kinds = train.kinds(&modes);
        // Accelerations at q = 0 over one mesh cycle, weighted with the inertias: the forces along each mode.
        let samples = 64;
        let (mut u, rest) = (vec![0.0; train.drives()], vec![0.0; train.dof()]);
        let inertias: Vec<f64> = inertias_of(&train);
        let forces: Vec<Vec<f64>> = (0..samples)
            .map(|i| {
                let mut a = rest.clone();
                train.drive(train.period() * i as f64 / samples as f64, Side::After, &mut u);
                train.accel(&u, &rest, &rest, &mut a);
                let along = |mode: &gear_dynamics::linear::Mode| {
                    let work = a.iter().zip(mode.shape()).zip(&inertias).map(|((a, x), m)| a * x * m);
                    let size: f64 = mode.shape().iter().zip(&inertias).map(|(x, m)| x * x * m).sum();
                    work.sum::<f64>() / size.sqrt()
                };
                modes.all().iter().map(along).collect()
            })
            .collect();
        for (harmonic, kind) in case["excited_by_harmonic"].as_object().unwrap() {
            let l: u32 = harmonic.parse().unwrap();
            let expected = ModeKind::of_harmonic(of("Zs"), of("N"), l);
            assert_eq!(format!("{expected:?}").to_lowercase(), kind.as_str().unwrap());
            let size = |mode: usize| {
                let part = |trig: fn(f64) -> f64| -> f64 {
                    let angle = |i: usize| {
                        std::f64::consts::TAU * f64::from(l) * i as f64 / f64::from(samples as u32)
                    };
                    forces.iter().enumerate().map(|(i, f)| f[mode] * trig(angle(i))).sum()
                };
                part(f64::cos).hypot(part(f64::sin))
            };
            let most = (0..kinds.len()).map(size).fold(0.0, f64::max);
            for (mode, kind) in kinds.iter().enumerate() {
                assert!(
                    *kind == expected || size(mode) < 1e-9 * most,
                    "harmonic {l}: {kind:?} {:e}",
                    size(mode) / most
                );
            }
        }
    }
}

/// Inertias by coordinate, from unit torques: for the bodies of `mesh_phasing_of_planets`.
fn inertias_of(train: &Train) -> Vec<f64> {
    let inertia = |name: &str| match name.split_once(' ').unwrap() {
        ("sun", "angle") => 3e-4,
        ("ring", "angle") => 2e-2,
        ("carrier", "angle") => 3e-2,
        ("sun", _) => 0.4,
        ("ring", _) => 2.0,
        ("carrier", _) => 5.0,
        (_, place) if place.ends_with("angle") => 5e-4,
        _ => 0.7,
    };
    train.shape().coordinates().iter().map(|channel| inertia(&channel.name)).collect()
}

/// Two stages with friction: the second pinion turns clockwise. The power of friction is negative on both stages: a train
/// that coasts without load loses energy, whichever way it turns and whichever gear is stated first.
#[test]
fn friction_resists_in_every_sense_of_rotation() {
    let at = |first_turns_clockwise: bool| {
        let mesh = |teeth: [u32; 2]| {
            MeshPart::external(teeth, teeth.map(|z| 1e-3 * f64::from(z)), k()).friction(0.1)
        };
        let mut parts = Parts::new();
        parts
            .body("in", Body::new(1e-3))
            .body("one", Body::new(1e-3).bearing(Bearing::new(2.0, 0.0)).centre([0.05, 0.0]));
        parts.body("two", Body::new(2e-3).centre([0.1, 0.0]));
        // A first mesh upstream turns gear one clockwise.
        parts.mesh("upstream", "in", "one", MeshPart::external([20, 20], [0.02, 0.02], k()));
        parts.mesh("mesh", "one", "two", mesh([20, 30]));
        let reference = if first_turns_clockwise { "in" } else { "one" };
        let train = parts.accept(Warning::Unsupported).build(reference, 10.0).unwrap();
        let (mut u, mut a) = (vec![0.0; train.drives()], vec![0.0; train.dof()]);
        // Only the second mesh carries: gear one ahead of gear two, with the input gear beside it.
        let q = [1e-3, 1e-3, 0.0, 0.0, 0.0];
        train.drive(0.0, Side::After, &mut u);
        train.accel(&u, &q, &[0.0; 5], &mut a);
        let with = a.clone();
        let none = train.with("mesh friction", 0.0).unwrap();
        none.drive(0.0, Side::After, &mut u);
        none.accel(&u, &q, &[0.0; 5], &mut a);
        (with[1] - a[1], with[4] - a[4], with[2] - a[2])
    };
    let (upright, mirrored) = (at(false), at(true));
    // Angles along the own rotation feel the same torque; the force along the line of centres is the same.
    assert!((upright.0 - mirrored.0).abs() < 1e-9 * upright.0.abs(), "{upright:?} {mirrored:?}");
    assert!((upright.1 - mirrored.1).abs() < 1e-9 * upright.1.abs(), "{upright:?} {mirrored:?}");
    assert!((upright.2 - mirrored.2).abs() < 1e-9 * upright.2.abs(), "{upright:?} {mirrored:?}");
}

#[test]
fn static_states_find_the_loaded_flank() {
    let loaded = |torque: f64, relative: bool| {
        let mut parts = Parts::new();
        parts.body("pinion", Body::new(2e-3)).body("wheel", Body::new(8e-3));
        parts.mesh(
            "mesh",
            "pinion",
            "wheel",
            MeshPart::external([20, 40], [0.03, 0.06], k()).half_backlash(4e-5),
        );
        parts.torque("drive", "pinion", torque).torque("load", "wheel", -2.0 * torque);
        if relative {
            parts.coordinates(Coordinates::Relative);
        }
        static_state(&parts.build("pinion", 100.0).unwrap(), 0.0).unwrap()
    };
    for relative in [false, true] {
        for torque in [30.0, -30.0] {
            let state = loaded(torque, relative);
            let (w, d) = (torque / 0.03, torque.signum() * 4e-5 + torque / 0.03 / 2e8);
            assert!((state.contacts[0].force - w).abs() < 1e-9 * w.abs());
            assert!((state.contacts[0].deflection - d).abs() < 1e-12 * d.abs());
        }
    }
    // An idler whose last mesh is loaded backwards.
    let mesh = |teeth: [u32; 2]| {
        MeshPart::external(teeth, teeth.map(|z| 1e-3 * f64::from(z)), k()).half_backlash(5e-5)
    };
    let mut parts = idler([1e-3, 3e-3, 8e-3], [mesh([20, 30]), mesh([30, 40])]);
    parts.torque("t1", "driver", 30.0).torque("t2", "idler", -52.5).torque("t3", "driven", 10.0);
    let state = static_state(&parts.build("driver", 100.0).unwrap(), 0.0).unwrap();
    assert_eq!(state.pieces, [Piece::Upper, Piece::Lower]);
    assert!((state.contacts[1].force + 250.0).abs() < 1e-6);
    // A body that nothing holds in space accelerates under the mesh force.
    let mut parts = Parts::new();
    parts
        .body("one", Body::new(1e-3).bearing(Bearing::new(1.0, 0.0)))
        .body("two", Body::new(2e-3).centre([0.1, 0.0]));
    parts.mesh("mesh", "one", "two", MeshPart::external([20, 30], [0.02, 0.03], k()));
    parts.torque("drive", "one", 10.0).torque("load", "two", -15.0).accept(Warning::Unsupported);
    let state = static_state(&parts.build("one", 1.0).unwrap(), 0.0).unwrap();
    assert!(state.acceleration[1].abs() > 1.0, "{:?}", state.acceleration);
}

/// Planets whose tooth errors differ: at a small torque some planets alone carry it. At rest no acceleration is left, and
/// the forces of the sun balance its torque.
#[test]
fn static_states_find_the_planets_that_carry_a_small_torque() {
    for planets in [3, 4, 5] {
        let members = Members {
            sun: (31, Body::new(8e-4)),
            planet: (29, Body::new(7e-4)),
            ring: (89, Body::new(5e-2).locked()),
            carrier: Body::new(6e-2),
        };
        let error = || Wave::new(Fourier::new(0.0, &[[0.0, 1e-6]]).unwrap());
        let set = Planetary::new(planets, 0.04, members, [k(), k()]);
        let set = set.unwrap().error([error(), error()]).damping(700.0).half_backlash(3e-5);
        let mut parts = set.parts();
        parts.torque("drive", "sun", 1.0).load("carrier");
        let train = parts.build("carrier", 20.0).unwrap();
        let mut carried = Vec::new();
        for torque in [0.01, 0.1, 1.0, 3.0, 10.0, 100.0, -0.03, -3.0] {
            let train = train.with("drive", torque).unwrap();
            for t in [0.0, 1e-4, 3e-4] {
                let rest = static_state(&train, t).unwrap();
                let largest = rest.acceleration.iter().fold(0.0f64, |most, a| most.max(a.abs()));
                assert!(largest < 1e-6 * torque.abs() / 7e-4, "{planets} planets, {torque}, {t}: {largest}");
                let (mut u, mut a) = (vec![0.0; train.drives()], vec![0.0; train.dof()]);
                train.drive(t, Side::After, &mut u);
                train.accel(&u, &rest.state.q, &rest.state.v, &mut a);
                let largest = a.iter().fold(0.0f64, |most, a| most.max(a.abs()));
                assert!(largest < 1e-6 * torque.abs() / 7e-4, "by deflection: {largest}");
                carried.push(rest.pieces.iter().filter(|&&piece| piece != Piece::Gap).count());
            }
        }
        assert!(carried.iter().any(|&n| n < 2 * planets as usize), "{carried:?}");
    }
}

#[test]
fn modes_without_stiffness_unstable_and_one_way() {
    let train = pair().build("pinion", 100.0).unwrap();
    let free = Modes::about(&train, &State::at_rest(2), Some(&[Piece::Gap])).unwrap();
    assert_eq!((free.rigid_count(), free.eigenvalues().len()), (2, 0));
    /// q_0'' = -q_0 - 5 q_1, q_1'' = s q_1: coupled one way.
    struct OneWay(f64);
    impl Model for OneWay {
        fn dof(&self) -> usize {
            2
        }
        fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            (a[0], a[1]) = (-q[0] - 5.0 * q[1], self.0 * q[1]);
        }
    }
    let modes = Modes::in_contact(&OneWay(-4.0), 0.0).unwrap();
    assert!(!modes.is_symmetric());
    assert!((modes.frequencies()[0] - 1.0).abs() < 1e-9 && (modes.frequencies()[1] - 2.0).abs() < 1e-9);
    let unstable = Modes::in_contact(&OneWay(3.0), 0.0).unwrap();
    assert_eq!((unstable.unstable_count(), unstable.rigid_count()), (1, 0));
    assert!((unstable.all()[0].square() + 3.0).abs() < 1e-9);
}

/// The stiffness that a lost sun tooth leaves: each planet meets the tooth a third of a turn after the one before.
#[test]
fn a_cracked_sun_tooth_meets_the_planets_in_turn() {
    let loss = Wave::new(gear_dynamics::teeth::ToothLoss::new(30, 0, 0.5).unwrap());
    let mut parts = Parts::new();
    parts
        .body("sun", Body::new(1e-3))
        .body("carrier", Body::new(1e-2))
        .body("ring", Body::new(1e-2).locked());
    for p in 0..3 {
        let planet = format!("planet {p}");
        let angle = std::f64::consts::TAU * f64::from(p) / 3.0;
        parts.body(&planet, Body::new(1e-3).carried_by("carrier", angle));
        let inner =
            MeshPart::external([30, 30], [0.03, 0.03], k()).stiffness_of_turn(OfMesh::Driver, loss.clone());
        parts.mesh(&format!("sun {p}"), "sun", &planet, inner);
        parts.mesh(&format!("ring {p}"), &planet, "ring", MeshPart::internal([30, 90], [0.03, 0.09], k()));
    }
    let train = parts.build("sun", 10.0).unwrap();
    // The sun turns 3/4 against the carrier: a period is 4/3 turns.
    let low: Vec<f64> = (0..3)
        .map(|p| {
            let mut u = vec![0.0; train.drives()];
            let mut sum = nalgebra::Complex::new(0.0, 0.0);
            for i in 0..3000 {
                train.drive(train.period() * (f64::from(i) + 0.5) / 3000.0, Side::After, &mut u);
                let mut contacts = vec![Contact::default(); 6];
                let mut q = vec![0.0; train.dof()];
                q[0] = 1e-3;
                train.contact(&u, &q, &vec![0.0; train.dof()], &mut contacts);
                let force = contacts[2 * p].force;
                if force < 0.9 * 2e8 * 0.03 * 1e-3 {
                    sum += nalgebra::Complex::from_polar(1.0, std::f64::consts::TAU * f64::from(i) / 3000.0);
                }
            }
            sum.arg() / std::f64::consts::TAU
        })
        .collect();
    let after = |p: usize| (low[p] - low[0]).rem_euclid(1.0);
    assert!((after(1) - 1.0 / 3.0).abs() < 2e-3 && (after(2) - 2.0 / 3.0).abs() < 2e-3, "{low:?}");
}

#[test]
fn joined_sets_have_kinds_of_their_own() {
    let set = |n: u32| {
        let members = ring_locked([30, 30, 90], [1e-3, 1e-3, 5e-2, 3e-2]);
        Planetary::new(n, 0.03, members, [k(), k()]).unwrap().parts()
    };
    let mut parts = Parts::new();
    parts.join("a", set(3)).join("b", set(4)).shaft("shaft", "a carrier", "b sun", ShaftPart::new(1e5));
    let train = parts.build("a sun", 100.0).unwrap();
    let kinds = train.kinds(&Modes::in_contact(&train, 0.0).unwrap());
    let count = |kind: ModeKind| kinds.iter().filter(|own| **own == kind).count();
    // Two planet modes of the first set; everything else belongs to the second set or to both.
    assert_eq!((count(ModeKind::Planet), count(ModeKind::Mixed)), (2, train.dof() - 2));
}

#[test]
fn resonances_lie_on_orders() {
    let train = pair().build("pinion", 100.0).unwrap();
    let frequency = Modes::in_contact(&train, 0.0).unwrap().frequencies()[1];
    let diagram = Campbell::of(&train, &[10.0, 500.0, 1500.0], &[20.0]).unwrap();
    assert_eq!(diagram.resonances().len(), 1);
    let meeting = diagram.resonances()[0];
    assert!(
        (meeting.frequency / frequency - 1.0).abs() < 1e-9
            && (20.0 * meeting.speed / frequency - 1.0).abs() < 1e-9
    );
    assert!(Campbell::of(&train, &[10.0, 5.0], &[20.0]).is_err());
    assert!(Campbell::of(&train, &[f64::NAN], &[20.0]).is_err());
}

/// With the centres on x and the line of action along y, a bearing clearance has two sides, as a mesh has.
#[test]
fn clearances_along_the_line_of_action_have_static_states_and_modes() {
    let mesh = MeshPart::external([28, 28], [0.0445, 0.0445], k()).half_backlash(5e-5);
    let mut parts = geared_rotor([1.15e-3; 2], [Bearing::new(1.84, 1e8).half_clearance(1e-5); 2], mesh);
    parts.torque("drive", "driver", 44.5).torque("load", "driven", -44.5);
    let rotor = parts.build("driver", 100.0).unwrap();
    let state = static_state(&rotor, 0.0).unwrap();
    // 1000 N on the mesh, and on each bearing 1e-5 past half of its clearance, on opposite sides.
    assert_eq!(state.pieces, [Piece::Upper, Piece::Lower, Piece::Upper]);
    for (contact, (force, depth)) in
        state.contacts.iter().zip([(1000.0, 5.5e-5), (-1000.0, -2e-5), (1000.0, 2e-5)])
    {
        assert!(
            (contact.force - force).abs() < 1e-6 && (contact.deflection - depth).abs() < 1e-12,
            "{contact:?}"
        );
    }
    let modes = Modes::in_contact(&rotor, 0.0).unwrap();
    assert_eq!((modes.unstable_count(), modes.rigid_count(), modes.all().len()), (0, 0, 3));
}

/// The load balances a torque over the angle, one over the speed and constant ones, at any values of their constants.
#[test]
fn a_load_balances_all_torques() {
    let mut parts = Parts::new();
    parts.body("pinion", Body::new(1e-3)).body("wheel", Body::new(4e-3));
    parts.mesh("mesh", "pinion", "wheel", MeshPart::external([20, 40], [0.03, 0.06], k()));
    parts.torque("drive", "pinion", 30.0).load("wheel");
    let train = parts.build("pinion", 100.0).unwrap();
    assert_eq!((train.dof(), train.names().len()), (1, 4)); // relative; no constant of the load
    let inertial = parts.clone().coordinates(Coordinates::Inertial).build("pinion", 100.0).unwrap();
    for drive in [30.0, -12.0] {
        for train in [&train, &inertial] {
            let rest = static_state(&train.with("drive", drive).unwrap(), 0.0).unwrap();
            assert!((rest.contacts[0].force - drive / 0.03).abs() < 1e-9 * drive.abs() / 0.03);
            assert!(rest.acceleration.iter().all(|a| a.abs() < 1e-6));
        }
    }
    // A mean of 1 over the turn, and half of the breakdown torque at a slip of 2 + √3 times the breakdown slip.
    let over_turn = Wave::new(Fourier::new(1.0, &[[0.5, 0.0]]).unwrap());
    let slip = 0.01 * (2.0 + 3f64.sqrt());
    parts.torque_of_angle("engine", "pinion", 10.0, over_turn);
    parts.motor(
        "motor",
        "pinion",
        InductionMotor {
            breakdown_torque: 40.0,
            breakdown_slip: 0.01,
            synchronous_speed: 100.0 / (1.0 - slip),
        },
    );
    let train = parts.build("pinion", 100.0).unwrap();
    let (mut u, mut a) = (vec![0.0; train.drives()], [0.0; 2]);
    train.drive(0.25 * train.period(), Side::After, &mut u); // cos φ = 0: the engine has its mean torque
    train.accel(&u, &[0.0; 2], &[0.0; 2], &mut a);
    let torque = 30.0 + 10.0 + 0.5 * 40.0;
    assert!(
        (a[0] - torque / 1e-3).abs() < 1e-9 * a[0] && (a[1] + 2.0 * torque / 4e-3).abs() < 1e-9 * a[0],
        "{a:?}"
    );
    let error = pair().load("nobody").build("pinion", 100.0).unwrap_err();
    assert!(error.to_string().starts_with("\"the load\" refers to the body \"nobody\""), "{error}");
}

/// A torque may be changed alone, as derivatives with respect to it require, or together with those that balance it.
#[test]
fn torques_are_changed_one_by_one_or_together() {
    let mut parts = Parts::new();
    parts.body("pinion", Body::new(1e-3)).body("wheel", Body::new(4e-3));
    parts.mesh("mesh", "pinion", "wheel", MeshPart::external([20, 40], [0.03, 0.06], k()));
    parts.torque("drive", "pinion", 30.0).torque("brake", "wheel", -60.0);
    let train = parts.build("pinion", 100.0).unwrap();
    let force = |train: &Train| static_state(train, 0.0).unwrap().contacts[0].force;
    let doubled = train.with_all(&[("drive", 60.0), ("brake", -120.0)]).unwrap();
    assert!((force(&doubled) / force(&train) - 2.0).abs() < 1e-12);
    let one = train.with("drive", 60.0).unwrap();
    assert_eq!(one.with("brake", -120.0).unwrap().values(), doubled.values());
}

/// The kinds of modes do not depend on the coordinates.
#[test]
fn kinds_in_relative_coordinates() {
    let members = ring_locked([30, 30, 90], [1e-3, 1e-3, 5e-2, 3e-2]);
    let set = Planetary::new(4, 0.03, members, [k(), k()]).unwrap();
    let mut parts = set.parts();
    parts.torque("drive", "sun", 30.0).load("carrier");
    let kinds = |parts: &Parts| {
        let train = parts.build("sun", 100.0).unwrap();
        let modes = Modes::in_contact(&train, 0.0).unwrap();
        let rigid = modes.rigid_count();
        (rigid, train.kinds(&modes).split_off(rigid))
    };
    let (none, relative) = kinds(&parts);
    let (one, inertial) = kinds(parts.coordinates(Coordinates::Inertial));
    assert_eq!((none, one, relative), (0, 1, inertial));
}

/// The pair of a drawing is the train of its parts, whatever the torque.
#[test]
fn a_spur_pair_of_teeth_is_the_train_of_its_parts() {
    use gear_dynamics::teeth::{
        GearPair, InvoluteGear, PotentialEnergy, QualityGrade, TeethError, TransmissionError,
    };
    let gear = |z| InvoluteGear::external(z, 0.003).unwrap().with_face_width(0.02).unwrap();
    let teeth = GearPair::at_centre_distance(&gear(40), &gear(60), 0.150_117).unwrap();
    let (bores, grades) = ([0.03, 0.05], [5, 7]);
    let pair = SpurPair::of_teeth(&teeth, bores, grades, 3).unwrap().damping(2000.0).drive_torque(300.0);

    let stiffness = PotentialEnergy::ma_2014(bores).unwrap().wave(&teeth).unwrap().fourier_series(3).unwrap();
    let error =
        TransmissionError::of_grade(&teeth, grades.map(|grade| QualityGrade::new(grade).unwrap())).unwrap();
    let mesh =
        MeshPart::of_pair(&teeth, Wave::new(stiffness.clone())).error(Wave::new(error.tooth().clone()));
    let inertias = [0, 1].map(|i| teeth.gears()[i].blank(bores[i], 7850.0).unwrap().polar_inertia);
    let law = gear_dynamics::contact::AsymmetricBacklash::new(-3e-5, 4e-5).unwrap();
    let bodies = [("driver", Body::new(inertias[0])), ("driven", Body::new(inertias[1]))];
    let mut parts = Parts::new();
    let mut with_law = Parts::default();
    for (name, body) in bodies {
        parts.body(name, body.clone());
        with_law.body(name, body);
    }
    parts.mesh("mesh", "driver", "driven", mesh.clone().damping(2000.0));
    with_law.mesh("mesh", "driver", "driven", mesh.damping(2000.0).law(law));
    parts.torque("drive", "driver", 300.0).load("driven");
    with_law.torque("drive", "driver", 300.0).load("driven");

    fn compare(one: &dyn Periodic, other: &dyn Periodic) {
        assert_eq!((one.dof(), other.dof(), one.period()), (1, 1, other.period()));
        let mut pieces = std::collections::BTreeSet::new();
        for i in 0..40 {
            let (t, q) = (one.period() * 0.37 * f64::from(i), 4e-5 * (f64::from(i) - 20.0) / 0.56);
            let accelerations = [one, other].map(|model| {
                let (mut u, mut a) = (vec![0.0; model.drives()], [0.0]);
                model.drive(t, Side::After, &mut u);
                model.accel(&u, &[q / 10.0], &[0.1 * q], &mut a);
                a[0]
            });
            pieces.insert(if q.abs() < 5e-4 { 0 } else { q.signum() as i32 });
            let [a, b] = accelerations;
            assert!((a - b).abs() < 1e-12 * a.abs().max(1e3), "{a} {b}");
        }
        assert_eq!(pieces.len(), 3);
    }
    for torque in [300.0, -120.0] {
        let one = pair.parts().unwrap().build("driver", 250.0).unwrap().with("drive torque", torque).unwrap();
        let other = parts.build("driver", 250.0).unwrap().with("drive", torque).unwrap();
        compare(&one, &other);
        let one = pair.parts_with_law(law).unwrap().build_with_laws("driver", 250.0).unwrap();
        let one = one.with("drive torque", torque).unwrap();
        compare(&one, &with_law.build_with_laws("driver", 250.0).unwrap().with("drive", torque).unwrap());
    }

    // In numbers: F/(b k), ζ = c/(2 √(m k)), and back to the damping.
    let (numbers, k) = (pair.dimensionless().unwrap(), stiffness.mean());
    let b = 0.5 * teeth.backlash() * teeth.working_pressure_angle().cos();
    assert!((numbers.half_backlash / b - 1.0).abs() < 1e-12);
    let force = 300.0 / teeth.gears()[0].base_radius();
    assert!((numbers.mean_force / (force / (b * k)) - 1.0).abs() < 1e-12);
    assert!((numbers.damping_ratio * 2.0 * (numbers.mass * k).sqrt() / 2000.0 - 1.0).abs() < 1e-12);
    let ratio = pair.clone().damping_ratio(numbers.damping_ratio).parts().unwrap();
    let damping = ratio.build("driver", 250.0).unwrap().constant("mesh damping").unwrap();
    assert!((damping / 2000.0 - 1.0).abs() < 1e-12);

    // Without a load there are no torques.
    let free = SpurPair::of_teeth(&teeth, bores, grades, 3).unwrap();
    assert!(free.parts().unwrap().build("driver", 250.0).unwrap().constant("drive torque").is_err());
    assert!(free.dimensionless().unwrap().mean_force == 0.0);
    let infinite = pair.clone().damping(1e300).dimensionless().unwrap_err().to_string();
    assert_eq!(infinite, "damping is 1e300: it must lie in [-1e50, 1e50]");

    let refused =
        |bores, grades, harmonics| SpurPair::of_teeth(&teeth, bores, grades, harmonics).unwrap_err();
    assert_eq!(refused(bores, [0, 6], 3).to_string(), "quality grade is 0: at least 1 are needed");
    assert!(refused(bores, [6, 12], 3).to_string().starts_with("quality grade is 12"));
    assert!(refused(bores, [6, 6], 1001).to_string().starts_with("order of the series is 1001"));
    assert!(matches!(refused([0.0, 0.03], [6, 6], 3), TeethError::Parameter(_)));
    let error = pair.clone().damping(-1.0).parts().unwrap_err();
    assert_eq!(error.to_string(), "damping is -1.0: it must not be negative");
    let error = pair.damping_ratio(f64::NAN).parts().unwrap_err();
    assert!(error.to_string().starts_with("damping ratio is NaN"), "{error}");
}
