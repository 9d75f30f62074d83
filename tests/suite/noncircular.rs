//! Noncircular gears in trains: the face gear pair from parts, bodies that turn unevenly, refusals.

use crate::api::*;
use crate::common::planets::ring_locked;
use gear_dynamics::excitation::{InstantCentre, Jet};
use gear_dynamics::linear::Modes;
use gear_dynamics::trains::*;
use gear_dynamics::{ParameterError, Wave};
use std::f64::consts::TAU;

/// 1 + a cos φ.
fn cosine(a: f64) -> Wave {
    Wave::new(Fourier::new(1.0, &[[a, 0.0]]).unwrap())
}

fn steel() -> Wave {
    Wave::constant(2e8).unwrap()
}

/// A mesh that turns its second gear by dθ_2/dφ = (1 - ε²)/(1 + 2 ε cos φ + ε²) times the mean.
fn centre_mesh(eccentric: f64) -> MeshPart {
    let radius = InstantCentre::new(eccentric).unwrap().radius(1.0).unwrap();
    let mean = (1.0 + eccentric * eccentric) / (1.0 - eccentric * eccentric);
    MeshPart::external([20, 40], [0.03, 0.06 * mean], steel())
        .radius_of_turn(OfMesh::Driven, Wave::new(radius))
}

fn accelerations<M: Model>(model: &M, t: f64, q: &[f64], v: &[f64]) -> Vec<f64> {
    let (mut u, mut a) = (vec![0.0; model.drives()], vec![0.0; model.dof()]);
    model.drive(t, Side::After, &mut u);
    model.accel(&u, q, v, &mut a);
    a
}

/// The face gear pair from parts and the pair of its own algebra, with the same constant torque on the pinion.
fn pairs(params: &NfgParams) -> (Train, NfgPair2) {
    let train =
        nfg_parts(params, 0.01).unwrap().accept(Warning::Drifts).build("pinion", params.speed).unwrap();
    let torque = params.load_torque / params.ratio;
    (train, NfgPair2::new(params, 0.01).unwrap().with_torque(torque).unwrap())
}

fn rich() -> NfgParams {
    NfgParams {
        error: 3e-6,
        error_harmonics: vec![[1e-5, 4e-6], [2e-6, 0.0]],
        stiffness_harmonics: vec![[9e6, 2e6], [1e6, -3e6]],
        ..NfgParams::table1()
    }
}

#[test]
fn the_face_gear_pair_of_parts_is_the_pair() {
    for params in [NfgParams::table1(), rich(), NfgParams { eccentric_ratio: 0.0, ..rich() }] {
        let (train, pair) = pairs(&params);
        assert!((train.period() / pair.period() - 1.0).abs() < 1e-14);
        let (mut worst, mut pieces) = (0.0f64, [0; 3]);
        for look in 0..200 {
            let part = |i: usize| (0.618_034 * (3 * look + i) as f64).fract() - 0.5;
            let q = [6e-3 * part(1), 2e-3 * part(2)];
            let v = [3.0 * part(4), part(5)];
            let t = 1e-3 * look as f64;
            let [ours, theirs] = [accelerations(&train, t, &q, &v), accelerations(&pair, t, &q, &v)];
            for (a, b) in ours.iter().zip(&theirs) {
                worst = worst.max((a - b).abs() / b.abs().max(1e4));
            }
            let [one, other] = [&train as &dyn Model, &pair].map(|model| {
                let (mut u, mut out) = (vec![0.0; model.drives()], [Contact::default()]);
                model.drive(t, Side::After, &mut u);
                model.contact(&u, &q, &v, &mut out);
                out[0]
            });
            assert_eq!(one.piece(), other.piece());
            pieces[one.piece() as usize] += 1;
            assert!(
                (one.rate - other.rate).abs() < 1e-12 && (one.deflection - other.deflection).abs() < 1e-16
            );
        }
        assert!(worst < 1e-12 && pieces.iter().all(|count| *count > 0), "{worst:e} {pieces:?}");
    }
}

/// The end of a run, and the share of time without contact.
fn rattling<M: Model>(model: &M, start: &State, end: f64) -> (State, f64) {
    let mut rattle = Rattle::new(model);
    let end = Dop853::new().rtol(1e-12).atol(1e-16).run(model, start, end, &mut rattle).unwrap();
    (end.state, rattle.contacts()[0].loss_fraction())
}

/// Through contact losses: by DOP853 in both models, by Taylor series in the train.
#[test]
fn the_face_gear_pair_of_parts_rattles_as_the_pair() {
    let (train, pair) = pairs(&NfgParams { speed: 140.0, ..NfgParams::table1() });
    let start = State::at_rest(2);
    let end = 0.5 * pair.period();
    let (of_pair, lost) = rattling(&pair, &start, end);
    let (of_train, also) = rattling(&train, &start, end);
    let series = Taylor::new().rtol(1e-13).atol(1e-17).end(&train, &start, end).unwrap();
    let size = of_pair.q[1].abs();
    assert!(lost > 0.0 && (lost - also).abs() < 1e-8);
    for other in [of_train, series] {
        let apart = of_pair.q.iter().zip(&other.q).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        assert!(apart < 1e-7 * size, "{apart:e} of {size:e}");
    }
}

#[test]
fn the_face_gear_pair_of_parts_sweeps_in_lanes() {
    let (train, pair) = pairs(&rich());
    let speeds = Axis::linear("speed", 60.0, 110.0, 10).unwrap();
    let sweep = Sweep::new(speeds).settle(0).measure(1).channels(&["deflection", "mesh force"]);
    let model = |p: &Point<'_>| train.with("speed", p["speed"]);
    let start = |p: &Point<'_>, _: &Train| pair.with("speed", p["speed"])?.on_drive_flank();
    let lanes = sweep.of(&LaneRk4::new(63 * 64).lanes::<8>(), model).start(start).run().unwrap();
    let single = sweep.of(&TableRk4::new(63 * 64), model).start(start).run().unwrap();
    for (a, b) in lanes.iter().zip(single.iter()) {
        let [a, b] = [a, b].map(|row| row.channel("mesh force").unwrap());
        assert!(a.max > 0.0 && (a.max - b.max).abs() < 1e-9 * b.max, "{a:?} {b:?}");
    }
}

/// motor = pinion ~ oval wheel = shaft = second pinion - drum; the last mesh is round.
fn chain(drum: MeshPart) -> Parts {
    let mut parts = Parts::new();
    parts.accept(Warning::Drifts);
    for (name, inertia) in
        [("motor", 2e-2), ("pinion", 1e-3), ("oval", 5e-3), ("second", 1e-3), ("drum", 4e-2)]
    {
        parts.body(name, Body::new(inertia));
    }
    parts.shaft("input", "motor", "pinion", ShaftPart::new(1e4).damping(1.0)).shaft(
        "between",
        "second",
        "oval",
        ShaftPart::new(2e4).damping(2.0),
    );
    parts.mesh("first", "pinion", "oval", centre_mesh(0.2).damping(500.0).half_backlash(2e-5));
    parts.mesh("last", "second", "drum", drum.damping(500.0).half_backlash(2e-5));
    parts
}

fn round() -> MeshPart {
    MeshPart::external([25, 50], [0.04, 0.08], steel())
}

/// Without torques and deflections, every body deviates by -θ'': the oval wheel turns all bodies behind it unevenly.
#[test]
fn bodies_behind_a_noncircular_gear_turn_unevenly() {
    let train = chain(round()).build("motor", 100.0).unwrap();
    let rotation = Wave::new(InstantCentre::new(0.2).unwrap().rotation());
    let omega = 50.0; // of the oval wheel in the mean
    for k in 0..20 {
        let t = 7e-3 * f64::from(k);
        let a = accelerations(&train, t, &[0.0; 5], &[0.0; 5]);
        let forcing = -omega * omega * rotation.jet(omega * t, Side::After).rate;
        for (a, ratio) in a.iter().zip([0.0, 0.0, 1.0, 1.0, 0.5]) {
            assert!((a - ratio * forcing).abs() < 1e-10 * omega * omega, "{a} {}", ratio * forcing);
        }
    }
    // The wheel turns evenly if it is the reference body and its radius has the mean that its teeth require.
    let mut parts = Parts::new();
    parts.body("pinion", Body::new(1e-3)).body("oval", Body::new(5e-3));
    let mesh =
        MeshPart::external([20, 40], [0.03, 0.06], steel()).radius_of_turn(OfMesh::Driven, cosine(0.3));
    let train =
        parts.mesh("mesh", "pinion", "oval", mesh).accept(Warning::Drifts).build("oval", 50.0).unwrap();
    let [q1, q2] = accelerations(&train, 0.013, &[0.0; 2], &[0.0; 2])[..] else { unreachable!() };
    let expected = 2.0 * 50.0 * 50.0 * 0.3 * (50.0f64 * 0.013).sin(); // -θ1'' with θ1' = 2 Ω (1 + 0.3 cos Ωt)
    assert!((q1 - expected).abs() < 1e-9 * expected && q2 == 0.0, "{q1} {expected} {q2}");
}

/// θ_2' = θ_1' r_1 (1 + a cos φ)/(r_2 (1 + c cos φ)). The mean of this quotient is m = a/c + (1 - a/c)/√(1 - c²), and
/// r_2 = m r_1 makes that of the ratio 1.
#[test]
fn two_noncircular_gears() {
    let (a, c, omega) = (0.1, 0.25, 80.0);
    let mean = a / c + (1.0 - a / c) / (1.0f64 - c * c).sqrt();
    let mut parts = Parts::new();
    parts.body("first", Body::new(1e-3)).body("second", Body::new(2e-3));
    let mesh = MeshPart::external([30, 30], [0.04, 0.04 * mean], steel())
        .radius_of_turn(OfMesh::Driver, cosine(a))
        .radius_of_turn(OfMesh::Driven, cosine(c));
    let train =
        parts.mesh("mesh", "first", "second", mesh).accept(Warning::Drifts).build("first", omega).unwrap();
    let second = accelerations(&train, 0.01, &[0.0; 2], &[0.0; 2])[1];
    let cos = Jet::variable(omega * 0.01).cos();
    let ratio = (cos * a + 1.0) / (cos * c + 1.0) * (1.0 / mean);
    let expected = -omega * omega * ratio.rate;
    assert!((second / expected - 1.0).abs() < 1e-12, "{second} {expected}");
}

#[test]
fn a_train_with_a_noncircular_gear_is_consistent() {
    let mut parts = chain(round());
    parts.torque("drive", "motor", 20.0).torque_of_speed("fan", "drum", -80.0, &[0.0, 0.0, 1.0 / 625.0]);
    let train = parts.build("motor", 100.0).unwrap();
    let q: Vec<f64> = (0..5).map(|i| 1e-3 * f64::from(i).cos()).collect();
    let findings = check_periodic(&train, &State::new(0.0, &q, &[1e-2, 2e-2, -1e-2, 3e-2, 0.0]));
    assert!(findings.is_empty(), "{findings:?}");
    // The speed of the drum is 25 R rad/s: the fan takes -80 R² N m.
    let [with, without] = [train.clone(), train.with("fan", 0.0).unwrap()]
        .map(|train| accelerations(&train, 0.01, &[0.0; 5], &[0.0; 5])[4]);
    let r = InstantCentre::new(0.2).unwrap().rotation().jet(0.5).value;
    assert!(((with - without) / (-80.0 * r * r / 4e-2) - 1.0).abs() < 1e-10, "{with} {without}");
    // The modes at an instant, and their energy.
    let modes = Modes::in_contact(&train.with("fan", 0.0).unwrap(), 0.01).unwrap();
    assert_eq!((modes.rigid_count(), modes.all().len()), (1, 5));
    let shares = train.strain_energy(&modes.all()[4], 0.5);
    let total: f64 = shares.iter().map(|share| share.1).sum();
    let (q, k) = (modes.all()[4].shape(), 0.5f64.cos());
    let d = 0.03 * q[1] - 0.06 * 1.04 / 0.96 * (1.0 + 0.4 / 1.04 * k) * q[2];
    let all = 1e4 * (q[0] - q[1]).powi(2)
        + 2e4 * (q[3] - q[2]).powi(2)
        + 2e8 * (d * d + (0.04 * q[3] - 0.08 * q[4]).powi(2));
    let first = shares.iter().find(|share| share.0 == "first").unwrap().1;
    assert!((total - 1.0).abs() < 1e-12 && (first - 2e8 * d * d / all).abs() < 1e-9, "{shares:?}");
}

/// A motor and an oval gear.
fn single(mesh: MeshPart) -> Parts {
    let mut parts = Parts::new();
    parts.body("motor", Body::new(1e-3)).body("oval", Body::new(5e-3)).mesh("mesh", "motor", "oval", mesh);
    parts
}

fn refused(mut parts: Parts) -> TrainError {
    parts.accept(Warning::Unbalanced).accept(Warning::Drifts).build("motor", 100.0).unwrap_err()
}

#[test]
fn noncircular_gears_are_refused_where_they_are_not_modelled() {
    assert!(chain(round()).build("motor", 100.0).is_ok());
    // Waves over the turn of a body that turns unevenly.
    let uneven = |part: &str, body: &str| TrainError::Uneven { part: part.into(), body: body.into() };
    let waving =
        MeshPart::external([25, 50], [0.04, 0.08], Wave::new(Fourier::new(2e8, &[[1e7, 0.0]]).unwrap()));
    assert_eq!(refused(chain(waving)), uneven("last", "second"));
    assert_eq!(refused(chain(round().friction(0.1))), uneven("last", "second"));
    let eccentric = Wave::new(Fourier::new(0.0, &[[1e-5, 0.0]]).unwrap());
    assert_eq!(refused(chain(round().error_of_turn(OfMesh::Driven, eccentric))), uneven("last", "drum"));
    assert_eq!(
        refused(chain(round().stiffness_of_turn(OfMesh::Driver, cosine(0.1)))),
        uneven("last", "second")
    );
    let mut parts = chain(round());
    parts.torque_of_angle("piston", "drum", 10.0, cosine(0.5));
    assert_eq!(refused(parts), uneven("piston", "drum"));
    // Waves of the pinion follow its even turn.
    let mut parts = chain(round());
    parts.torque_of_angle("piston", "motor", 10.0, cosine(0.5));
    assert!(parts.accept(Warning::Unbalanced).build("motor", 100.0).is_ok());

    let mut parts = chain(round());
    assert!(matches!(
        refused(parts.coordinates(Coordinates::Relative).clone()),
        TrainError::NotRelative { part } if part == "a noncircular gear"
    ));
    let not_round = |parts: Parts, expected: &str| match refused(parts) {
        TrainError::NotRound { why, .. } => assert!(why.contains(expected), "{why}"),
        error => panic!("{error}"),
    };
    not_round(single(centre_mesh(0.2).friction(0.1)), "friction");
    // The mean ratio contradicts the teeth.
    let mesh =
        MeshPart::external([20, 40], [0.03, 0.06], steel()).radius_of_turn(OfMesh::Driven, cosine(0.3));
    match refused(single(mesh)) {
        TrainError::MeanRatio { ratio, teeth, mesh } => {
            // The mean of 1/(1 + 0.3 cos φ) is 1/√(1 - 0.09).
            let expected = 0.5 / (1.0f64 - 0.09).sqrt();
            assert!((ratio - expected).abs() < 1e-12 && teeth == 0.5 && mesh == "mesh", "{ratio} {teeth}");
        }
        error => panic!("{error}"),
    }
    // A radius that is not positive, with the angle.
    let mesh = centre_mesh(0.2).radius_of_turn(OfMesh::Driver, cosine(1.5));
    let error = refused(single(mesh));
    assert!(
        matches!(&error, TrainError::Parameter(ParameterError::NotPositive { name, .. }) if
        name.starts_with("factor of the base radius of the first gear of \"mesh\" at ")),
        "{error}"
    );
    let nan = Wave::new(gear_dynamics::excitation::Function::new(|angle| angle * f64::NAN));
    assert!(matches!(
        refused(single(centre_mesh(0.2).radius_of_turn(OfMesh::Driver, nan))),
        TrainError::Parameter(_)
    ));
}

#[test]
fn loops_of_noncircular_gears_must_turn_alike() {
    // The motor drives two oval wheels, which a shaft joins.
    let two = |eccentric: f64| {
        let mut parts = Parts::new();
        parts.body("motor", Body::new(1e-3)).body("left", Body::new(5e-3)).body("right", Body::new(5e-3));
        parts.mesh("one", "motor", "left", centre_mesh(0.2)).mesh(
            "two",
            "motor",
            "right",
            centre_mesh(eccentric),
        );
        parts.shaft("across", "left", "right", ShaftPart::new(1e4));
        parts
    };
    assert!(two(0.2).accept(Warning::Drifts).build("motor", 100.0).is_ok());
    let closing = TrainError::UnevenLoop { part: "across".into(), body: "right".into() };
    assert_eq!(refused(two(0.25)), closing);
}

#[test]
fn planetary_sets_turn_evenly() {
    let members = || ring_locked([30, 30, 90], [1e-3, 1e-3, 5e-2, 3e-2]);
    let set = || Planetary::new(3, 0.03, members(), [steel(), steel()]).unwrap();
    let mut parts = set().parts();
    parts.body("motor", Body::new(1e-3));
    parts.mesh("drive", "motor", "sun", centre_mesh(0.2));
    assert_eq!(refused(parts), TrainError::Uneven { part: "sun 1".into(), body: "sun".into() });
    // Behind the carrier, a noncircular gear may turn other bodies.
    let mut parts = set().parts();
    parts.body("motor", Body::new(1e-3)).shaft("input", "motor", "sun", ShaftPart::new(1e4));
    parts.body("oval", Body::new(1e-2)).mesh("output", "carrier", "oval", centre_mesh(0.2));
    let train = parts.accept(Warning::Drifts).build("motor", 100.0).unwrap();
    let n = train.dof();
    let a = accelerations(&train, 0.02, &vec![0.0; n], &vec![0.0; n]);
    let place = train.shape().coordinates().iter().position(|c| c.name == "oval angle").unwrap();
    let omega = 100.0 / 4.0 / 2.0; // the sun turns four times as fast as the carrier
    let rate = InstantCentre::new(0.2).unwrap().rotation().jet((omega * 0.02f64).rem_euclid(TAU)).rate;
    assert!((a[place] + omega * omega * rate).abs() < 1e-10 * omega * omega, "{}", a[place]);
    assert!(a.iter().enumerate().all(|(i, a)| i == place || *a == 0.0), "{a:?}");
}

/// Two identical oval pairs one after the other: the second one turns the output evenly again.
#[test]
fn ratios_that_cancel_turn_evenly() {
    let build = |stiffness: Wave| {
        let mut parts = Parts::new();
        for name in ["motor", "oval", "output", "drum"] {
            parts.body(name, Body::new(1e-3));
        }
        let oval = || cosine(0.3);
        // θ' of the oval gear is Ω (1 + 0.3 cos φ)/√.., and the output turns back by the same factor.
        let first =
            MeshPart::external([20, 20], [0.03, 0.03], steel()).radius_of_turn(OfMesh::Driver, oval());
        let second =
            MeshPart::external([20, 20], [0.03, 0.03], steel()).radius_of_turn(OfMesh::Driven, oval());
        parts.mesh("first", "motor", "oval", first).mesh("second", "oval", "output", second);
        parts.mesh("last", "output", "drum", MeshPart::external([20, 40], [0.03, 0.06], stiffness));
        parts.accept(Warning::Drifts).build("motor", 100.0)
    };
    let waving = Wave::new(Fourier::new(2e8, &[[1e7, 0.0]]).unwrap());
    let train = build(waving).unwrap();
    let a = accelerations(&train, 0.01, &[0.0; 4], &[0.0; 4]);
    let expected = 1e4 * 0.3 * 1f64.sin(); // -θ'' with θ' = Ω (1 + 0.3 cos Ωt)
    assert!((a[1] / expected - 1.0).abs() < 1e-12 && [a[0], a[2], a[3]] == [0.0; 3], "{a:?}");
}

#[test]
fn a_gear_with_two_lobes_repeats_twice_in_a_turn() {
    let mut parts = Parts::new();
    parts.body("motor", Body::new(1e-3).restrained(1e4, 1.0)).body("oval", Body::new(5e-3));
    let two = cosine(0.3).per_turn(2).unwrap();
    let radii = [0.03, 0.06 / (1.0f64 - 0.09).sqrt()];
    let mesh = MeshPart::external([20, 40], radii, steel()).radius_of_turn(OfMesh::Driven, two);
    let train = parts.mesh("mesh", "motor", "oval", mesh).build("motor", 100.0).unwrap();
    assert!((train.period() / (0.5 * TAU / 50.0) - 1.0).abs() < 1e-14);
}

/// A noncircular gear has no teeth at even angles: a wave over the teeth follows the round gear, if that turns evenly.
#[test]
fn waves_over_the_teeth_follow_the_round_gear() {
    let build = |reference: &str| {
        let mut parts = Parts::new();
        parts.body("pinion", Body::new(1e-3)).body("oval", Body::new(5e-3));
        let waving = Wave::new(Fourier::new(2e8, &[[1e7, 0.0]]).unwrap());
        let mean = if reference == "oval" { 1.0 } else { 1.0 / (1.0f64 - 0.09).sqrt() };
        let mesh = MeshPart::external([20, 40], [0.03, 0.06 * mean], waving);
        let mesh = mesh.radius_of_turn(OfMesh::Driven, cosine(0.3));
        parts.mesh("mesh", "pinion", "oval", mesh).accept(Warning::Drifts).build(reference, 50.0)
    };
    assert!(build("pinion").is_ok());
    assert_eq!(build("oval").unwrap_err(), TrainError::Uneven { part: "mesh".into(), body: "pinion".into() });
}

#[test]
fn further_noncircular_gears_that_are_refused() {
    // A radius that jumps.
    let jumping = Wave::new(RectangularWave::new(0.9, 1.1, 0.5).unwrap());
    let error = refused(single(centre_mesh(0.2).radius_of_turn(OfMesh::Driver, jumping)));
    assert!(matches!(&error, TrainError::RadiusJumps { mesh, .. } if mesh == "mesh"), "{error}");
    // Nothing holds the train to its uneven rotation.
    let free = single(centre_mesh(0.2)).build("motor", 100.0).unwrap_err();
    assert!(matches!(free, TrainError::Warning { warning: Warning::Drifts, .. }), "{free}");
    // A gear at rest, a planet, and a rotating frame.
    let mut parts = single(centre_mesh(0.2));
    parts.body("rack", Body::new(1.0).locked()).mesh("still", "oval", "rack", centre_mesh(0.2));
    assert!(matches!(refused(parts), TrainError::LockedToGround { .. }));
    let mut parts = Parts::new();
    parts
        .body("motor", Body::new(1e-3))
        .body("carrier", Body::new(1e-2))
        .body("ring", Body::new(1.0).locked());
    parts.body("planet", Body::new(1e-3).carried_by("carrier", 0.0));
    let oval =
        MeshPart::external([20, 20], [0.03, 0.03], steel()).radius_of_turn(OfMesh::Driver, cosine(0.1));
    parts.mesh("inner", "motor", "planet", oval);
    parts.mesh("outer", "planet", "ring", MeshPart::internal([20, 60], [0.03, 0.09], steel()));
    let error = refused(parts);
    assert!(matches!(&error, TrainError::NotRound { mesh, .. } if mesh == "inner"), "{error}");
    let mut parts = single(centre_mesh(0.2));
    parts.rotating_with("oval");
    assert_eq!(refused(parts), TrainError::Uneven { part: "the rotating frame".into(), body: "oval".into() });
}

/// With a motor that is held to its speed, shooting and harmonic balance find the same stable orbit in contact.
#[test]
fn a_train_that_is_held_has_a_stable_orbit() {
    let mut parts = Parts::new();
    parts.body("motor", Body::new(0.05).restrained(2e4, 40.0)).body("oval", Body::new(5e-3));
    parts.mesh("mesh", "motor", "oval", centre_mesh(0.1).damping(3000.0).half_backlash(2e-5));
    parts.torque("drive", "motor", 40.0).torque("load", "oval", -80.0);
    let train = parts.build("motor", 60.0).unwrap();
    let start = gear_dynamics::linear::static_state(&train, 0.0).unwrap();
    let start = start.state;
    let settled = Dop853::new().rtol(1e-11).atol(1e-16).end(&train, &start, 8.0 * train.period()).unwrap();
    let orbit = Shooting::new().solve(&train, &[State { t: 0.0, ..settled }]).unwrap();
    let multipliers = orbit.multipliers();
    assert!(multipliers.largest() < 0.9, "{multipliers:?}");
    let balance = Balance::new(Harmonics::up_to(40));
    let guess = balance.linearised(&train, Piece::Upper).unwrap();
    let balanced = balance.solve(&train, &guess).unwrap();
    let size = orbit.states()[0].q[1].abs();
    let gap = (balanced.at(0.0).q[1] - orbit.states()[0].q[1]).abs();
    assert!(gap < 1e-9 * size, "{gap:e} of {size:e}");
}

/// With a constant torque the pinion of `NfgPair2` feels T1 - I1 θ1'', with θ1'' = i_j x'' in a run-up.   Source: Liu 2021,
/// Eq. (4).
#[test]
fn a_constant_torque_accelerates_the_pinion_in_a_run_up() {
    // In the gap, without damping.
    let params = NfgParams { half_backlash: 1.0, damping_ratio: 0.0, ..NfgParams::table1() };
    let pair = NfgPair2::new(&params, 0.01).unwrap().with_torque(7.0).unwrap();
    let law = SpeedLaw::ramp(40.0, 60.0, 4.0).unwrap(); // x'' = 5 rad/s²
    let a = accelerations(&VaryingSpeed::new(pair, law), 1.0, &[0.0; 2], &[0.0; 2]);
    assert!((a[0] - (7.0 / 0.01 - 3.5 * 5.0)).abs() < 1e-9, "{a:?}");
}
