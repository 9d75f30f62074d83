//! Planetary sets in a rotating frame: preloads, centrifugal forces, varying speed, against the motion in a frame at
//! rest.

use crate::api::*;
use crate::common::planets::{on_bearings, ring_held, ring_locked};
use gear_dynamics::trains::*;
use gear_dynamics::{Dop853, Wave};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

fn jacobian<M: Model>(model: &M, t: f64) -> Jacobian {
    let n = model.dof();
    let (mut u, mut out) = (vec![0.0; model.drives()], Jacobian::new(n));
    model.drive(t, Side::After, &mut u);
    let pieces = vec![Piece::Upper; model.contacts()];
    model.jacobian(Some(&pieces), &u, &vec![0.0; n], &vec![0.0; n], &mut out);
    out
}

/// A set with a locked ring that turns freely, with planets at the given places in 120ths of a turn.
fn set(places: &[u32], scale: f64, preloaded: bool) -> Parts {
    let bearings = [
        Bearing::new(0.4 * scale, 1e8),
        Bearing::new(0.66 / scale, 1e8 * scale),
        Bearing::new(2.35, 1e8),
        Bearing::new(5.43 * scale, 2e8),
    ];
    let inertias = [3.5e-4 * scale, 5.5e-4, 2.4e-2, 2.7e-2 / scale];
    let mut members = on_bearings(ring_locked([30, 30, 90], inertias), bearings);
    members.ring.1 = members.ring.1.locked();
    let k = |k: f64| Wave::constant(k).unwrap();
    let angles: Vec<f64> = places.iter().map(|place| TAU * f64::from(*place) / 120.0).collect();
    let set = Planetary::new(places.len() as u32, 0.03, members, [k(5e8), k(4e8)]).unwrap().angles(&angles);
    let mut parts = set.parts();
    if preloaded {
        parts.rotating_with("carrier");
    } else {
        parts.rotating_without_preload("carrier");
    }
    parts
}

/// The largest real part of the eigenvalues of q'' = K q + C q'.
fn growth(jacobian: &Jacobian) -> f64 {
    let n = jacobian.q.nrows();
    let mut all = DMatrix::zeros(2 * n, 2 * n);
    all.view_mut((0, n), (n, n)).fill_with_identity();
    all.view_mut((n, 0), (n, n)).copy_from(&jacobian.q);
    all.view_mut((n, n), (n, n)).copy_from(&jacobian.v);
    all.complex_eigenvalues().iter().fold(f64::NEG_INFINITY, |most, value| most.max(value.re))
}

/// A rigid rotation of a set that turns freely is a symmetry: it has no force, whatever the planets are, and no rate
/// of growth. Without the preloads the rate is 0.42 Ω for three planets.
#[test]
fn rigid_rotations_are_neutral() {
    let places: [&[u32]; 6] =
        [&[0, 40, 80], &[0, 30, 60, 90], &[0, 24, 48, 72, 96], &[0, 39, 82], &[3, 57], &[10, 31, 62, 95]];
    for (case, places) in places.iter().enumerate() {
        for scale in [1.0, 0.5, 1.7] {
            for speed in [100.0, 800.0] {
                let train = set(places, scale, true).build("carrier", speed).unwrap();
                let found = jacobian(&train, 0.0);
                // Rates of the coordinates in a rigid rotation, over that of the carrier.
                let mut rigid = DVector::zeros(train.dof());
                let names: Vec<String> = train.shape().coordinates().iter().map(|c| c.name.clone()).collect();
                let radius = 0.06 / 20f64.to_radians().cos();
                for (name, rate) in names.iter().zip(rigid.iter_mut()) {
                    let place = name.strip_prefix("planet ").map(|rest| {
                        let planet: usize = rest.split(' ').next().unwrap().parse().unwrap();
                        TAU * f64::from(places[planet - 1]) / 120.0
                    });
                    *rate = match (&name[..], place) {
                        ("sun angle", _) => 4.0,
                        ("carrier angle", _) => 1.0,
                        // Along its own rotation, (z_r - z_p)/z_p backwards.
                        (_, Some(_)) if name.ends_with("angle") => 2.0,
                        (_, Some(place)) if name.ends_with(" x") => -radius * place.sin(),
                        (_, Some(place)) => radius * place.cos(),
                        _ => 0.0,
                    };
                }
                let forces = &found.q * &rigid;
                let sizes = found.q.abs() * rigid.abs();
                for (i, (force, size)) in forces.iter().zip(sizes.iter()).enumerate() {
                    // Rounding of the sum of a row.
                    assert!(
                        force.abs() <= 64.0 * f64::EPSILON * size,
                        "{case} {}: {force:e} {size:e}",
                        names[i]
                    );
                }
                // A double eigenvalue of 0 with one direction splits by the root of the rounding of the stiffest entry,
                // some √(1e3 ε 1e10) = 0.05 rad/s.
                let grows = growth(&found);
                let printed =
                    growth(&jacobian(&set(places, scale, false).build("carrier", speed).unwrap(), 0.0));
                println!(
                    "{places:?} {scale} {speed}: {:.1e} Ω, without preload {:.3} Ω",
                    grows / speed,
                    printed / speed
                );
                assert!(grows < 1e-2 * speed, "{grows}");
                assert!(printed > 0.1 * speed);
            }
        }
    }
}

/// A planet of mass m on a bearing of a carrier with prescribed rotation is a mass on a spring whose other end moves on
/// a circle: linear in a frame at rest. A run-up from rest of the deviations agrees with it.
#[test]
fn a_planet_of_a_prescribed_carrier_is_a_mass_on_a_moving_spring() {
    let (mass, stiffness, radius, place) = (2.0, 8e6, 0.08, 0.7f64);
    for reversed in [false, true] {
        let mut parts = Parts::new();
        parts.body("motor", Body::new(1.0).prescribed());
        parts.body("carrier", Body::new(1.0).prescribed());
        let planet = Body::new(1e-3).bearing(Bearing::new(mass, stiffness)).carried_by("carrier", place);
        parts.body("planet", planet.radius(radius)).shaft("pin", "carrier", "planet", ShaftPart::new(1e4));
        let part = MeshPart::external([30, 60], [0.03, 0.06], Wave::constant(1e8).unwrap());
        let part = if reversed {
            part
        } else {
            MeshPart::internal([30, 60], [0.03, 0.06], Wave::constant(1e8).unwrap())
        };
        let train = parts
            .mesh("drive", "motor", "carrier", part)
            .rotating_with("carrier")
            .build("motor", 400.0)
            .unwrap();
        let law = SpeedLaw::ramp(400.0, 1600.0, 0.03).unwrap();
        let model = VaryingSpeed::new(train, law.clone());
        let names: Vec<String> = model.bare().shape().coordinates().iter().map(|c| c.name.clone()).collect();
        let at = |name: &str| names.iter().position(|known| known == name).unwrap();
        let (x, y) = (at("planet x"), at("planet y"));
        let n = model.dof();
        let sense = if reversed { -1.0 } else { 1.0 };
        let angle = |t: f64| place + sense * 0.5 * law.angle(t);
        let rate = |t: f64| sense * 0.5 * law.speed(t);
        // At rest in the rotating frame at the place.
        let spring = |t: f64, z: [f64; 4]| {
            let (sin, cos) = angle(t).sin_cos();
            let pull = |x: f64, pin: f64| -stiffness / mass * (x - pin);
            [z[2], z[3], pull(z[0], radius * cos), pull(z[1], radius * sin)]
        };
        let (sin, cos) = place.sin_cos();
        let mut z = [radius * cos, radius * sin, -rate(0.0) * radius * sin, rate(0.0) * radius * cos];
        let solver = Dop853::new().rtol(1e-11).atol(1e-15);
        let (mut state, mut t, h) = (State::at_rest(n), 0.0, 1e-6);
        let mut largest = 0.0f64;
        for _ in 0..40 {
            for _ in 0..1000 {
                let plus = |k: [f64; 4], h: f64| std::array::from_fn(|i| z[i] + h * k[i]);
                let k1 = spring(t, z);
                let k2 = spring(t + 0.5 * h, plus(k1, 0.5 * h));
                let k3 = spring(t + 0.5 * h, plus(k2, 0.5 * h));
                let k4 = spring(t + h, plus(k3, h));
                z = std::array::from_fn(|i| z[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
                t += h;
            }
            state = solver.end(&model, &state, t).unwrap();
            // Seen from the frame of the carrier, in which the place is at its angle.
            let (sin, cos) = (angle(t) - place).sin_cos();
            let seen = [cos * z[0] + sin * z[1], cos * z[1] - sin * z[0]];
            let expected = [seen[0] - radius * place.cos(), seen[1] - radius * place.sin()];
            for (at, expected) in [x, y].into_iter().zip(expected) {
                largest = largest.max(expected.abs());
                assert!((state.q[at] - expected).abs() < 1e-10, "{t}: {} {expected}", state.q[at]);
            }
        }
        // m r Ω²/(k - m Ω²) at 800 rad/s is 15 mm.
        assert!(largest > 5e-3, "{largest}");
    }
}

/// The Jacobian of planets on a carrier that turns freely, against differences of the exact motion about the state in
/// which each planet is at its place: Ω² and Ω' alike.
#[test]
fn preloads_are_those_of_the_exact_motion() {
    let (mass, stiffness, inertia, radius, place) = (1.5, 5e6, 0.04, 0.07, 2.1f64);
    for reversed in [false, true] {
        let mut parts = Parts::new();
        parts.body("motor", Body::new(1.0).prescribed()).body("carrier", Body::new(inertia));
        let planet = Body::new(1e-3).bearing(Bearing::new(mass, stiffness)).carried_by("carrier", place);
        parts.body("planet", planet.radius(radius)).shaft("pin", "carrier", "planet", ShaftPart::new(1e-9));
        let k = Wave::constant(1e6).unwrap();
        let part = if reversed { MeshPart::external } else { MeshPart::internal };
        let part = part([30, 60], [0.03, 0.06], k).half_backlash(1.0);
        let train = parts.mesh("drive", "motor", "carrier", part).accept(Warning::UnusualValue);
        let train = train.rotating_with("carrier").build("motor", 400.0).unwrap();
        let names: Vec<String> = train.shape().coordinates().iter().map(|c| c.name.clone()).collect();
        let at = |name: &str| names.iter().position(|known| known == name).unwrap();
        let places = [at("carrier angle"), at("planet x"), at("planet y")];
        let model = VaryingSpeed::new(train, SpeedLaw::ramp(400.0, 1600.0, 0.01).unwrap());
        let sense = if reversed { -1.0 } else { 1.0 };
        let (omega, rate) = (sense * 0.5 * 1000.0, sense * 0.5 * 1.2e5);
        // Accelerations (δ along its rotation, x, y) in the frame of the carrier.
        let exact = |[delta, x, y]: [f64; 3]| {
            let (sin, cos) = place.sin_cos();
            let p = [radius * cos, radius * sin];
            // The force of the bearing at the place, and the pin from which it comes.
            let force =
                [mass * (-omega * omega * p[0] - rate * p[1]), mass * (rate * p[0] - omega * omega * p[1])];
            let pin = [0, 1].map(|i| p[i] + force[i] / stiffness);
            let (sin, cos) = (sense * delta).sin_cos();
            let pin = [cos * pin[0] - sin * pin[1], sin * pin[0] + cos * pin[1]];
            let pull = [stiffness * (pin[0] - p[0] - x), stiffness * (pin[1] - p[1] - y)];
            let moment = -(pin[0] * pull[1] - pin[1] * pull[0]);
            let [rx, ry] = [p[0] + x, p[1] + y];
            [
                sense * moment / inertia,
                pull[0] / mass + omega * omega * rx + rate * ry,
                pull[1] / mass + omega * omega * ry - rate * rx,
            ]
        };
        let mut out = Jacobian::new(model.dof());
        let mut u = vec![0.0; model.drives()];
        model.drive(5e-3, Side::After, &mut u);
        let rest = vec![0.0; model.dof()];
        model.jacobian(Some(&[Piece::Gap]), &u, &rest, &rest, &mut out);
        for j in 0..3 {
            let h = [1e-6, 1e-6, 1e-6][j];
            let at = |h: f64| exact(std::array::from_fn(|i| if i == j { h } else { 0.0 }));
            let [plus, minus] = [at(h), at(-h)];
            for i in 0..3 {
                let expected = (plus[i] - minus[i]) / (2.0 * h);
                let found = out.q[(places[i], places[j])];
                // Differences: rounding of the terms k r/(m h).
                let size = stiffness * radius / inertia;
                assert!((found - expected).abs() < 1e-8 * size, "{i} {j}: {found} {expected}");
            }
        }
    }
}

/// A set held by its ring has the centrifugal force m r Ω² on each planet.
#[test]
fn planets_are_pushed_outwards() {
    let members = on_bearings(
        ring_held([30, 30, 90], [1e-3, 1e-3, 5e-2, 3e-2], 1e6),
        [0.4, 0.66, 2.35, 5.43].map(|mass| Bearing::new(mass, 1e8)),
    );
    let k = || Wave::constant(1e6).unwrap();
    let set = Planetary::new(3, 0.03, members, [k(), k()]).unwrap();
    let mut parts = set.parts();
    let rotating = parts.clone().rotating_with("carrier").build("carrier", 300.0).unwrap();
    let still = parts.rotating_without_preload("carrier").build("carrier", 300.0).unwrap();
    let rest = vec![0.0; rotating.dof()];
    let at = |train: &Train| {
        let (mut u, mut a) = (vec![0.0; train.drives()], rest.clone());
        train.drive(0.0, Side::After, &mut u);
        train.accel(&u, &rest, &rest, &mut a);
        a
    };
    let (with, without) = (at(&rotating), at(&still));
    let radius = 0.06 / 20f64.to_radians().cos();
    for (i, channel) in rotating.shape().coordinates().iter().enumerate() {
        let planet = channel.name.strip_prefix("planet ").and_then(|rest| rest.split(' ').next());
        let angle = planet.map(|planet| TAU * (planet.parse::<f64>().unwrap() - 1.0) / 3.0);
        let expected = match angle {
            Some(angle) if channel.name.ends_with(" x") => angle.cos(),
            Some(angle) if channel.name.ends_with(" y") => angle.sin(),
            _ => 0.0,
        };
        let expected = expected * radius * 300.0 * 300.0;
        assert!((with[i] - without[i] - expected).abs() < 1e-9 * radius * 9e4, "{}", channel.name);
    }
}
