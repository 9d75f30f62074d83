//! Trains that are refused, and those that are warned of.

use crate::api::*;
use crate::common::planets::{on_bearings, ring_held, ring_locked, turning};
use crate::trains::{k, pair};
use gear_dynamics::Wave;
use gear_dynamics::excitation::Fourier;
use gear_dynamics::linear::static_state;
use gear_dynamics::trains::*;

/// The error of the pair after a change.
fn refused(change: impl FnOnce(&mut Parts)) -> TrainError {
    let mut parts = pair();
    change(&mut parts);
    parts.build("pinion", 100.0).unwrap_err()
}

fn warned(change: impl FnOnce(&mut Parts), expected: Warning) {
    let mut parts = pair();
    change(&mut parts);
    let error = parts.build("pinion", 100.0).unwrap_err();
    assert!(matches!(error, TrainError::Warning { warning, .. } if warning == expected), "{error}");
    parts.accept(expected);
    assert!(parts.build("pinion", 100.0).is_ok(), "{expected:?} accepted");
}

/// Tooth numbers of a planetary set without a common centre distance are named, not an angle that nobody entered.
#[test]
fn rings_that_do_not_fit_sun_and_planets_are_refused() {
    let built = |teeth: [u32; 3], angle: f64| {
        let members = ring_locked(teeth, [1e-3; 4]);
        let set = Planetary::new(3, 0.03, members, [k(), k()]).unwrap().pressure_angle(angle);
        set.parts().build("sun", 100.0)
    };
    let angle = 20f64.to_radians();
    assert!(built([30, 30, 90], angle).is_ok());
    for teeth in [[30, 30, 96], [30, 30, 99], [90, 30, 30], [30, 60, 30]] {
        let [sun, planet, ring] = teeth;
        let near = u64::from(sun + 2 * planet);
        assert_eq!(built(teeth, angle).unwrap_err(), TrainError::RingTeeth { sun, planet, ring, near });
    }
    let text = built([30, 30, 96], angle).unwrap_err().to_string();
    assert!(text.starts_with("a ring of 96 teeth") && text.contains("some 90 teeth are usual"), "{text}");
    for angle in [f64::NAN, -0.1, 1.5] {
        let error = built([30, 30, 90], angle).unwrap_err();
        assert!(error.to_string().starts_with("pressure angle of \"sun 1\" is"), "{error}");
    }
}

#[test]
fn wrong_names_are_refused() {
    let error = refused(|parts| drop(parts.body("wheel", Body::new(1.0)).clone()));
    assert_eq!(error, TrainError::DuplicateName { name: "wheel".into() });
    let error = refused(|parts| drop(parts.torque("mesh", "wheel", 1.0).clone()));
    assert_eq!(error, TrainError::DuplicateName { name: "mesh".into() });
    let mesh = || MeshPart::external([20, 40], [0.03, 0.06], k());
    let error = refused(|parts| drop(parts.mesh("second", "pinion", "weel", mesh()).clone()));
    assert_eq!(
        error.to_string(),
        "\"second\" refers to the body \"weel\", which does not exist; there are: pinion, wheel"
    );
    let error = refused(|parts| drop(parts.mesh("second", "wheel", "wheel", mesh()).clone()));
    assert_eq!(error, TrainError::JoinsItself { part: "second".into(), body: "wheel".into() });
    let error = refused(|parts| drop(parts.shaft("shaft", "wheel", "wheel", ShaftPart::new(1.0)).clone()));
    assert!(matches!(error, TrainError::JoinsItself { .. }));
    assert!(matches!(
        refused(|parts| drop(parts.torque("t", "axle", 1.0).clone())),
        TrainError::NoSuchBody { .. }
    ));
    assert!(matches!(pair().build("axle", 1.0), Err(TrainError::NoSuchBody { .. })));
    assert!(matches!(
        refused(|parts| drop(parts.rotating_with("axle").clone())),
        TrainError::NoSuchBody { .. }
    ));
    let planet = Body::new(1.0).carried_by("axle", 0.0);
    assert!(matches!(
        refused(|parts| drop(parts.body("planet", planet).clone())),
        TrainError::NoSuchBody { .. }
    ));
}

#[test]
fn values_out_of_range_are_refused() {
    let parameter = |error: TrainError| assert!(matches!(error, TrainError::Parameter(_)), "{error}");
    for coefficients in [&[f64::NAN][..], &[1.0, f64::INFINITY], &[]] {
        let error = refused(|parts| drop(parts.torque_of_speed("m", "pinion", 1.0, coefficients).clone()));
        assert!(error.to_string().contains("of \"m\""), "{error}");
        parameter(error);
    }
    for value in [f64::NAN, f64::INFINITY, -1.0, 0.0] {
        match refused(|parts| drop(parts.body("third", Body::new(value)).clone())) {
            TrainError::NoInertia { body } => assert!(value == 0.0 && body == "third"),
            error => parameter(error),
        }
        let bearing = Bearing::new(value, 1e8);
        parameter(refused(|parts| drop(parts.body("third", Body::new(1.0).bearing(bearing)).clone())));
        parameter(refused(|parts| {
            let mesh = MeshPart::external([20, 40], [value, 0.06], k());
            parts.mesh("second", "pinion", "wheel", mesh);
        }));
        parameter(pair().build("pinion", value).unwrap_err());
    }
    for value in [f64::NAN, f64::INFINITY, -1.0] {
        let body = || Body::new(1.0);
        for body in [
            body().drag(value),
            body().grounded(value, 0.0),
            body().restrained(0.0, value),
            body().bearing(Bearing::new(1.0, value)),
            body().bearing(Bearing::new(1.0, 1.0).damping(value)),
            body().bearing(Bearing::new(1.0, 1.0).half_clearance(value)),
        ] {
            parameter(refused(|parts| drop(parts.body("third", body).clone())));
        }
        parameter(refused(|parts| drop(parts.shaft("s", "pinion", "wheel", ShaftPart::new(value)).clone())));
        parameter(refused(|parts| {
            drop(parts.shaft("s", "pinion", "wheel", ShaftPart::new(0.0).damping(value)).clone())
        }));
        parameter(refused(|parts| {
            parts.shaft("s", "pinion", "wheel", ShaftPart::new(1.0).half_clearance(value));
        }));
        parameter(refused(|parts| {
            drop(
                parts
                    .motor(
                        "m",
                        "pinion",
                        InductionMotor {
                            breakdown_torque: 1.0,
                            breakdown_slip: value,
                            synchronous_speed: 1.0,
                        },
                    )
                    .clone(),
            )
        }));
        parameter(refused(|parts| {
            drop(
                parts
                    .motor(
                        "m",
                        "pinion",
                        InductionMotor {
                            breakdown_torque: 1.0,
                            breakdown_slip: 1.0,
                            synchronous_speed: value,
                        },
                    )
                    .clone(),
            )
        }));
        let mesh = || MeshPart::external([20, 40], [0.03, 0.06], k());
        for mesh in [
            mesh().damping(value),
            mesh().half_backlash(value),
            mesh().pressure_angle(value),
            mesh().friction(value),
        ] {
            parameter(refused(|parts| drop(parts.mesh("second", "pinion", "wheel", mesh).clone())));
        }
    }
    let value = f64::NAN;
    parameter(refused(|parts| drop(parts.torque("t", "pinion", value).clone())));
    parameter(refused(|parts| drop(parts.body("third", Body::new(1.0).centre([value, 0.0])).clone())));
    let mesh = MeshPart::external([20, 40], [0.03, 0.06], k());
    parameter(refused(|parts| {
        drop(parts.mesh("second", "pinion", "wheel", mesh.clone().phase(value)).clone())
    }));
    parameter(refused(|parts| {
        drop(parts.mesh("second", "pinion", "wheel", mesh.stated_phase(value)).clone())
    }));
    parameter(Parts::new().build("pinion", 1.0).unwrap_err());
    let mesh = MeshPart::external([0, 40], [0.03, 0.06], k());
    let error = refused(|parts| drop(parts.mesh("second", "pinion", "wheel", mesh).clone()));
    assert_eq!(error, TrainError::ToothNumber { mesh: "second".into(), teeth: 0 });
    let error = Planetary::new(0, 0.03, ring_locked([30, 30, 90], [1.0; 4]), [k(), k()]).unwrap_err();
    assert!(matches!(error, gear_dynamics::ParameterError::TooFew { .. }));
}

#[test]
fn trains_that_cannot_turn_or_be_assembled_are_refused() {
    let mesh = |teeth: [u32; 2]| MeshPart::external(teeth, teeth.map(|z| 1.5e-3 * f64::from(z)), k());
    let error = refused(|parts| {
        parts.body("idler", Body::new(1e-3));
        parts.mesh("one", "wheel", "idler", mesh([40, 30])).mesh("two", "idler", "pinion", mesh([30, 20]));
    });
    assert!(matches!(error, TrainError::Locked { .. }), "{error}");
    // A shaft between gears that turn at different speeds.
    let error = refused(|parts| drop(parts.shaft("shaft", "pinion", "wheel", ShaftPart::new(1.0)).clone()));
    assert!(matches!(error, TrainError::Locked { .. }), "{error}");
    // A coupling to the ground from a body that turns.
    let error = refused(|parts| {
        parts.body("ground", Body::new(1e-3).grounded(1e3, 0.0));
        parts.shaft("coupling", "wheel", "ground", ShaftPart::new(1.0));
    });
    assert!(
        matches!(&error, TrainError::LockedToGround { part, body, speed, ground }
            if part == "coupling" && body == "wheel" && *speed == -0.5 && ground == "ground"),
        "{error}"
    );
    let error = refused(|parts| {
        let mesh = MeshPart::external([20, 40], [0.03, 0.05], k());
        parts.mesh("second", "pinion", "wheel", mesh);
    });
    assert!(matches!(error, TrainError::RadiiContradictTeeth { .. }), "{error}");
    let error =
        refused(|parts| drop(parts.body("third", Body::new(1.0)).accept(Warning::Disconnected).clone()));
    assert_eq!(error, TrainError::SpeedUndetermined { body: "third".into() });
    let mut held = Parts::new();
    held.body("pinion", Body::new(1.0).grounded(1e5, 0.0));
    assert!(matches!(held.build("pinion", 1.0), Err(TrainError::ReferenceAtRest { .. })));

    let inertias = [1e-3, 1e-3, 1e-2, 1e-2];
    let set = |teeth: [u32; 3], n: u32| {
        Planetary::new(n, 0.03, ring_held(teeth, inertias, 1e6), [k(), k()]).unwrap()
    };
    let locked = |set: Planetary| set.parts();
    let mut parts = locked(set([30, 30, 90], 3));
    parts.body("planet 4", Body::new(1e-3).carried_by("carrier", 0.1).radius(0.07));
    parts.mesh("sun 4", "sun", "planet 4", MeshPart::external([30, 30], [0.03, 0.03], k()));
    let error = parts.build("sun", 1.0).unwrap_err();
    assert!(matches!(error, TrainError::CentreDistance { .. }), "{error}");
    // The ring of 200 teeth is too large for the centre distance.
    assert!(matches!(locked(set([30, 20, 200], 1)).build("sun", 1.0), Err(TrainError::RingTeeth { .. })));
    let error = locked(set([30, 20, 70], 3)).build("sun", 1.0).unwrap_err();
    let TrainError::DoesNotAssemble { planet, nearest, .. } = error else { panic!("{error}") };
    // 100 places on the carrier: planet 2 fits at 33/100 of a turn.
    assert_eq!(planet, "planet 2");
    let angles = [0.0, nearest, 2.0 * nearest];
    assert!((nearest / std::f64::consts::TAU - 0.33).abs() < 1e-12);
    assert!(locked(set([30, 20, 70], 3).angles(&angles)).build("sun", 1.0).is_ok());
    // All speeds follow from one another, whatever their number.
    assert!(locked(set([50, 50, 150], 100)).build("sun", 1.0).is_ok());
    let loose = Planetary::new(3, 0.03, turning([30, 30, 90], inertias), [k(), k()]).unwrap();
    let loose = loose.parts().build("sun", 1.0).unwrap_err();
    assert!(matches!(loose, TrainError::SpeedUndetermined { .. }), "{loose}");
    let mut parts = locked(set([30, 30, 90], 3));
    parts.body("planet 4", Body::new(1e-3).carried_by("planet 1", 0.1));
    assert!(matches!(parts.build("sun", 1.0), Err(TrainError::NestedCarrier { .. })));
    let mut parts = locked(set([30, 30, 90], 3));
    parts.body("planet 4", Body::new(1e-3).carried_by("carrier", 0.1));
    let error = parts.build("sun", 1.0).unwrap_err();
    assert!(
        matches!(error, TrainError::SpeedUndetermined { .. } | TrainError::PlanetWithoutMesh { .. }),
        "{error}"
    );
}

#[test]
fn a_second_load_is_refused() {
    let error =
        refused(|parts| drop(parts.torque("drive", "pinion", 10.0).load("wheel").load("pinion").clone()));
    assert_eq!(error, TrainError::TwoLoads { bodies: ["wheel".into(), "pinion".into()] });
    let mut joined = pair();
    joined.torque("drive", "pinion", 10.0).load("wheel").join("other", {
        let mut other = pair();
        other.torque("drive", "pinion", 10.0).load("wheel");
        other
    });
    assert!(
        joined
            .shaft("shaft", "wheel", "other pinion", ShaftPart::new(1e4).damping(1.0))
            .build("pinion", 100.0)
            .is_ok()
    );
}

/// One of the meshes of a gear may state no phase: the others are behind it.
#[test]
fn phases_that_matter_are_stated() {
    let wave = || Wave::new(Fourier::new(2e8, &[[4e7, 0.0]]).unwrap());
    let third = |stiffness: [Wave; 2], change: fn(MeshPart) -> MeshPart| {
        let mut parts = Parts::new();
        for (name, x) in [("pinion", 0.0), ("wheel", 0.1), ("third", -0.1)] {
            parts.body(name, Body::new(1e-3).centre([x, 0.0]));
        }
        let mesh = |k: &Wave| MeshPart::external([20, 40], [0.03, 0.06], k.clone());
        parts.mesh("first", "pinion", "wheel", mesh(&stiffness[0]));
        parts.mesh("second", "pinion", "third", change(mesh(&stiffness[1])));
        parts
    };
    let unstated = third([wave(), wave()], |mesh| mesh);
    let error = unstated.build("pinion", 100.0).unwrap_err();
    assert!(matches!(error, TrainError::Warning { warning: Warning::PhaseUnstated, .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains("\"first\" and \"second\"") && text.contains("phase_from_teeth"), "{text}");
    assert!(unstated.clone().accept(Warning::PhaseUnstated).build("pinion", 100.0).is_ok());
    for silent in [
        third([wave(), wave()], |mesh| mesh.phase(0.0)),
        third([wave(), wave()], MeshPart::phase_from_teeth),
        third([k(), wave()], |mesh| mesh),
    ] {
        assert!(silent.build("pinion", 100.0).is_ok());
    }
    let mesh = || MeshPart::external([20, 20], [0.03, 0.03], wave());
    assert!(idler([1e-3; 3], [mesh(), mesh()]).build("driver", 100.0).is_ok());
    assert!(
        split_torque([1e-3; 4], 2, ShaftPart::new(1e4).damping(1.0), [mesh(), mesh()])
            .unwrap()
            .build("input", 100.0)
            .is_ok()
    );
}

#[test]
fn unusual_trains_are_warned_of() {
    warned(|parts| drop(parts.torque("drive", "pinion", 10.0).clone()), Warning::Unbalanced);
    let unusual = Warning::UnusualValue;
    let second =
        |mesh: MeshPart| move |parts: &mut Parts| drop(parts.mesh("second", "pinion", "wheel", mesh).clone());
    warned(second(MeshPart::external([20, 40], [0.03, 0.06], Wave::constant(1e5).unwrap())), unusual);
    warned(second(MeshPart::external([20, 40], [37.6, 75.2], k())), unusual); // a module of 4 m
    warned(second(MeshPart::external([20, 40], [0.03, 0.06], k()).half_backlash(50.0)), unusual);
    let loose = Body::new(1e-3).bearing(Bearing::new(1.0, 0.0)).centre([0.2, 0.0]);
    let third = |parts: &mut Parts| {
        parts.body("third", loose.clone());
        parts.mesh("second", "wheel", "third", MeshPart::external([40, 20], [0.06, 0.03], k()));
    };
    warned(third, Warning::Unsupported);
    warned(|parts| drop(parts.body("third", Body::new(1.0).locked()).clone()), Warning::Disconnected);
}

#[test]
fn further_refusals() {
    let planetary = |bearing: Bearing| {
        let other = Bearing::new(1.0, 1e8);
        let members = on_bearings(ring_locked([30, 30, 90], [1e-3; 4]), [other, bearing, other, other]);
        Planetary::new(3, 0.03, members, [k(), k()]).unwrap().parts()
    };
    let error = planetary(Bearing::new(1.0, 1e8).along_y()).build("sun", 1.0).unwrap_err();
    assert!(matches!(error, TrainError::NotIsotropic { .. }), "{error}");
    let mut parts = planetary(Bearing::new(1.0, 1e8));
    parts
        .body("pinion", Body::new(1e-3).bearing(Bearing::new(1.0, 1e8)).centre([1.0, 0.0]))
        .body("wheel", Body::new(1e-3));
    parts.mesh("output", "pinion", "wheel", MeshPart::external([20, 20], [0.02, 0.02], k()));
    parts.shaft("shaft", "carrier", "pinion", ShaftPart::new(1e5)).rotating_with("carrier");
    let error = parts.build("sun", 1.0).unwrap_err();
    assert!(matches!(error, TrainError::NotRotating { .. }), "{error}");
    assert!(matches!(
        refused(|parts| {
            parts.body("held", Body::new(1.0).grounded(0.0, 0.0));
            parts.mesh("second", "wheel", "held", MeshPart::external([40, 20], [0.06, 0.03], k()));
        }),
        TrainError::Locked { .. } | TrainError::Warning { .. }
    ));
    let mut params = RingSet::set_a(4, 1000.0).params().unwrap();
    params.gears.pop();
    assert!(matches!(ring_parts(&params, 20), Err(TrainError::Parameter(_))));
    let relative = refused(|parts| {
        parts.body("motor", Body::new(1.0).drag(1.0)).shaft("shaft", "motor", "pinion", ShaftPart::new(1e4));
        parts.coordinates(Coordinates::Relative);
    });
    assert!(matches!(relative, TrainError::NotRelative { .. }), "{relative}");
}

#[test]
fn parts_that_cannot_be_placed_are_refused() {
    let on = || Body::new(1e-3).bearing(Bearing::new(1.0, 1e8));
    let mut parts = Parts::new();
    parts.body("one", on()).body("two", on());
    parts.mesh("mesh", "one", "two", MeshPart::external([20, 20], [0.02, 0.02], k()));
    assert_eq!(parts.build("one", 1.0).unwrap_err(), TrainError::SameCentre { mesh: "mesh".into() });

    let mut parts = Parts::new();
    parts.body("one", Body::new(1.0)).body("two", Body::new(1.0));
    parts.shaft("coupling", "one", "two", ShaftPart::new(1e4).damping(1.0).half_clearance(1e-3));
    // A coupling needs no mesh: 10 N m turn it 10/1e4 rad past half of its clearance.
    parts.torque("drive", "one", 10.0).load("two");
    let state = static_state(&parts.accept(Warning::UnusualValue).build("one", 1.0).unwrap(), 0.0).unwrap();
    let contact = state.contacts[0];
    assert!((contact.force - 10.0).abs() < 1e-9 && (contact.deflection - 2e-3).abs() < 1e-12, "{contact:?}");

    let mut parts = Parts::<Backlash>::default();
    parts.body("one", Body::new(1e-3).radius(0.1));
    let error = parts.build("one", 1.0).unwrap_err();
    assert_eq!(error, TrainError::RadiusWithoutCarrier { body: "one".into() });

    let mut parts = Parts::new();
    for carrier in ["a", "b"] {
        parts.body(carrier, Body::new(1.0));
        parts.body(&format!("planet {carrier}"), Body::new(1.0).carried_by(carrier, 0.0).radius(0.1));
    }
    parts.mesh("mesh", "planet a", "planet b", MeshPart::external([20, 20], [0.02, 0.02], k()));
    assert_eq!(parts.build("a", 1.0).unwrap_err(), TrainError::TwoCarriers { mesh: "mesh".into() });

    let varying = Wave::new(Fourier::new(1e-5, &[[2e-6, 0.0]]).unwrap());
    let mut parts = Parts::<VaryingBacklash>::default();
    parts.body("one", Body::new(1e-3)).body("two", Body::new(1e-3));
    let mesh = MeshPart::external([20, 20], [0.02, 0.02], k()).phase(0.25).law(VaryingBacklash::new(varying));
    parts.mesh("mesh", "one", "two", mesh);
    assert_eq!(
        parts.build_with_laws("one", 1.0).unwrap_err(),
        TrainError::MovingEdges { mesh: "mesh".into() }
    );

    let locked = refused(|parts| {
        parts.body("rail", Body::new(1.0).locked()).torque("torque", "rail", 1.0);
        parts.accept(Warning::Disconnected);
    });
    assert_eq!(locked, TrainError::AtRest { part: "torque".into() });
}

/// A stiffness that is negative somewhere in its mesh cycle pushes the teeth into one another, also where its mean and
/// its value at φ = 0 are positive.
#[test]
fn a_stiffness_that_is_negative_over_part_of_the_cycle_is_refused() {
    let pair = |stiffness: Wave| {
        let mut parts = Parts::new();
        parts.body("pinion", Body::new(1e-3)).body("wheel", Body::new(4e-3));
        parts.mesh("mesh", "pinion", "wheel", MeshPart::external([20, 40], [0.03, 0.06], stiffness));
        parts.torque("drive", "pinion", 30.0).load("wheel");
        parts.build("pinion", 100.0)
    };
    let wave = |mean: f64, swing: f64| Wave::new(Fourier::new(mean, &[[swing, 0.0]]).unwrap());
    assert!(pair(wave(6e7, 6e7)).is_ok());
    for (mean, swing) in [(1e7, 6e7), (5.9e7, 6e7), (1e8, -1.1e8)] {
        let error = pair(wave(mean, swing)).unwrap_err().to_string();
        assert!(error.contains("stiffness of \"mesh\" at φ = "), "{error}");
        assert!(error.contains("it must not be negative"), "{error}");
    }
}

/// Transmission errors of metres, waves that count the teeth a second time, and shafts that carry nothing.
#[test]
fn errors_of_metres_and_shafts_of_no_stiffness() {
    let train = |error: Wave, stiffness: Wave, shaft: ShaftPart| {
        let mut parts = Parts::new();
        for (name, inertia) in [("motor", 1e-3), ("pinion", 1e-3), ("wheel", 4e-3)] {
            parts.body(name, Body::new(inertia));
        }
        parts.shaft("shaft", "motor", "pinion", shaft);
        parts.mesh(
            "mesh",
            "pinion",
            "wheel",
            MeshPart::external([20, 40], [0.03, 0.06], stiffness).error(error),
        );
        parts.torque("drive", "motor", 20.0).torque("load", "wheel", -40.0);
        parts.build("pinion", 100.0)
    };
    let sine = |size: f64| Wave::new(Fourier::new(0.0, &[[0.0, size]]).unwrap());
    let shaft = || ShaftPart::new(1e4);
    assert!(train(sine(8e-6), k(), shaft()).is_ok());
    let text = |built: Result<Train, TrainError>, expected: Warning| match built.unwrap_err() {
        TrainError::Warning { warning, message } if warning == expected => message,
        other => panic!("{other}"),
    };
    let metres = text(train(sine(8.0), k(), shaft()), Warning::UnusualValue);
    assert!(metres.starts_with("the transmission error of \"mesh\" [m] is 8e0"), "{metres}");
    for (order, name) in [(20, "pinion"), (40, "wheel")] {
        let counted = text(train(sine(8e-6).per_turn(order).unwrap(), k(), shaft()), Warning::UnusualValue);
        assert!(counted.contains(&format!("repeats {order} times in a mesh cycle")), "{name}: {counted}");
    }
    let varying = Wave::new(Fourier::new(2e8, &[[4e7, 0.0]]).unwrap()).per_turn(20).unwrap();
    assert!(text(train(sine(8e-6), varying, shaft()), Warning::UnusualValue).contains("the stiffness"));
    let apart = text(train(sine(8e-6), k(), ShaftPart::new(0.0)), Warning::Disconnected);
    assert_eq!(apart, "\"pinion\" is not connected with \"motor\"");
    assert!(train(sine(8e-6), k(), ShaftPart::new(0.0).damping(1.0)).is_ok());
}
