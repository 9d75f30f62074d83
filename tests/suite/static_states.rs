//! Static states under the mean loads and waves of a period, or under those of one instant.

use crate::api::*;
use crate::common::random::Random;
use gear_dynamics::contact::{Backlash, Deflection, Piece, PieceChoice};
use gear_dynamics::excitation::{Fourier, RectangularWave};
use gear_dynamics::linear::static_state;
use gear_dynamics::model::{Drives, Size};
use gear_dynamics::models::ring::{RingSet, Shaft};
use gear_dynamics::trains::{Bearing, Body, Coordinates, MeshPart, OfMesh, Parts, ShaftPart, two_stage};
use gear_dynamics::{Dop853, Ring, Wave};
use std::f64::consts::TAU;

/// A motor, a shaft, a pinion and a wheel, under a torque with a ripple.
fn ripple(factor: Wave, stiffness: Wave) -> Parts {
    let mut parts = Parts::new();
    parts.body("motor", Body::new(2e-2)).body("pinion", Body::new(1e-3)).body("wheel", Body::new(2e-2));
    parts.shaft("input shaft", "motor", "pinion", ShaftPart::new(8e3).damping(1.0));
    parts.mesh(
        "mesh",
        "pinion",
        "wheel",
        MeshPart::external([20, 50], [0.02, 0.05], stiffness).damping(1500.0),
    );
    parts.torque_of_angle("drive torque", "motor", 20.0, factor).torque("load", "wheel", -50.0);
    parts
}

fn fourier(mean: f64, terms: &[[f64; 2]]) -> Wave {
    Wave::new(Fourier::new(mean, terms).unwrap())
}

/// A ripple of 1.65 times the mean torque of 20 N m, that is 33 N m: at its first instant the shaft would be wound 2.65
/// times as far. The mesh carries 20 N m over 0.02 m on its mean stiffness.
#[test]
fn mean_loads_and_mean_waves_are_the_default() {
    let ripples = [[1.65, 0.0], [0.0, 0.4], [0.3, 0.0]];
    let stiffnesses = [
        fourier(3e8, &[[6e7, 0.0], [2e7, -1e7]]),
        Wave::new(RectangularWave::of_contact_ratio(1.6, 2.5e8, 3.333_333_333_333_333e8).unwrap()),
    ];
    for stiffness in stiffnesses {
        let train = ripple(fourier(1.0, &ripples), stiffness).build("motor", 150.0).unwrap();
        let rest = static_state(&train, None).unwrap();
        let mean = 3e8;
        assert_eq!(rest.state.t, 0.0);
        assert!((rest.contacts[0].force - 1000.0).abs() < 1e-6, "{:?}", rest.contacts[0]);
        assert!((rest.contacts[0].deflection * mean - 1000.0).abs() < 1e-6, "{:?}", rest.contacts[0]);
        // The shaft is wound by 20 N m.
        let wound = rest.state.q[0] - rest.state.q[1];
        assert!((rest.state.q.len() == 2) && wound.is_finite());
        // At the first instant the motor drives with 53 N m.
        let first = static_state(&train, 0.0).unwrap();
        assert!(first.contacts[0].force > 1200.0, "{:?}", first.contacts[0]);
        assert!(rest.acceleration.iter().all(|a| a.abs() < 1e-6), "{:?}", rest.acceleration);
    }
}

/// Two stages with hunting teeth, whose period has 4350 edges or some 4e7, under a torque with a ripple of three times its
/// mean: both meshes carry the mean torque.
#[test]
fn the_mean_is_that_of_the_whole_period() {
    for ([first, second], tolerance) in [([[23, 67], [21, 75]], 1e-9), ([[101, 307], [103, 311]], 1e-3)] {
        let wave = || Wave::new(RectangularWave::of_contact_ratio(1.5, 1.6e8, 2.4e8).unwrap());
        let mesh = |teeth: [u32; 2]| {
            let radii = teeth.map(|teeth| 1e-3 * f64::from(teeth));
            MeshPart::external(teeth, radii, wave()).damping(1000.0).half_backlash(2e-5)
        };
        let shaft = ShaftPart::new(1e5).damping(1.0);
        let mut parts = two_stage([1e-3, 2e-2, 1e-3, 6e-2], shaft, [mesh(first), mesh(second)]);
        parts.torque_of_angle("drive", "pinion 1", 10.0, fourier(1.0, &[[3.0, 0.0]])).load("wheel 2");
        let rest = static_state(&parts.build("pinion 1", 100.0).unwrap(), None).unwrap();
        assert_eq!(rest.instant, None);
        let [z1, z2] = first.map(f64::from);
        let forces = [10.0 / (1e-3 * z1), 10.0 * z2 / z1 / (1e-3 * f64::from(second[0]))];
        for (contact, force) in rest.contacts.iter().zip(forces) {
            assert!((contact.force / force - 1.0).abs() < tolerance, "{} for {force}", contact.force);
        }
    }
}

/// A mesh with sines as waves is fast between the edges of the other mesh, whose stiffness jumps: hundreds of edges in the
/// period, several cycles between two of them.
#[test]
fn fast_waves_between_many_edges() {
    for [first, second] in [[[25, 133], [19, 61]], [[43, 78], [26, 46]]] {
        let radii = |teeth: [u32; 2]| teeth.map(|teeth| 1e-3 * f64::from(teeth));
        let (k, ripple, error, torque, b) = (4e8, 0.8e8, 3e-6, 50.0, 5e-5);
        let mut parts = Parts::new();
        for body in ["pinion 0", "wheel 0", "pinion 1", "wheel 1"] {
            parts.body(body, Body::new(1e-3));
        }
        let runout = |terms: [f64; 2]| fourier(0.0, &[terms]);
        let mesh = MeshPart::external(first, radii(first), fourier(k, &[[ripple, 0.0]]))
            .half_backlash(b)
            .phase(0.1)
            .error(fourier(0.0, &[[error, 0.0]]))
            .error_of_turn(OfMesh::Driver, runout([0.0, 2e-6]));
        parts.mesh("mesh 0", "pinion 0", "wheel 0", mesh);
        let jumps = Wave::new(RectangularWave::of_contact_ratio(1.5, 3e8, 4.5e8).unwrap());
        let mesh = MeshPart::external(second, radii(second), jumps)
            .half_backlash(8e-5)
            .phase(0.3)
            .error_of_turn(OfMesh::Driver, runout([2e-6, 0.0]));
        parts.mesh("mesh 1", "pinion 1", "wheel 1", mesh);
        parts.shaft("shaft", "wheel 0", "pinion 1", ShaftPart::new(1e5).damping(1.0));
        parts.torque("drive", "pinion 0", torque).load("wheel 1");
        let rest = static_state(&parts.build("pinion 0", 100.0).unwrap(), None).unwrap();
        let force = torque / radii(first)[0];
        let (found, expected) = (rest.contacts[0].deflection, b + (force + 0.5 * ripple * error) / k);
        assert!((found - expected).abs() < 1e-6 * force / k, "{first:?}: {found} for {expected}");
    }
}

/// Three stages with hunting teeth and sines as waves: each mean contact carries the mean torque, also the first, whose
/// force is a twentieth of the largest.
#[test]
fn mean_contacts_of_hunting_trains() {
    let stages: [([u32; 2], f64, f64, f64); 3] = [
        ([41, 107], 0.027, 1.533e-7, 0.808),
        ([27, 100], -0.09, 9.546e-7, 0.684),
        ([21, 83], -0.223, 4.75e-6, 0.373),
    ];
    let (k, b) = (1e8, 2e-5);
    let mut parts = Parts::new();
    let (mut torque, mut expected, mut before) = (2.94, Vec::new(), String::new());
    parts.torque("drive", "pinion 0", torque).load("wheel 2");
    for (stage, (teeth, ripple, error, phase)) in stages.into_iter().enumerate() {
        let [pinion, wheel] = ["pinion", "wheel"].map(|body| format!("{body} {stage}"));
        parts.body(&pinion, Body::new(1e-3)).body(&wheel, Body::new(2e-3));
        if stage > 0 {
            parts.shaft(&format!("shaft {stage}"), &before, &pinion, ShaftPart::new(1e5).damping(1.0));
        }
        let (c, radii) = (ripple * k, teeth.map(|teeth| 1e-3 * f64::from(teeth)));
        let stiffness = fourier(k, &[[c, 0.0], [0.3 * c, 0.2 * c], [0.0, -0.2 * c]]);
        let error_wave = fourier(0.0, &[[error, 0.0], [0.0, 0.3 * error], [0.2 * error, 0.2 * error]]);
        let mesh =
            MeshPart::external(teeth, radii, stiffness).half_backlash(b).phase(phase).error(error_wave);
        parts.mesh(&format!("mesh {stage}"), &pinion, &wheel, mesh);
        // The mean of stiffness times error: half the sum of the products of their coefficients.
        let force = torque / radii[0];
        expected.push((force, b + (force + 0.5 * c * error * 1.02) / k));
        torque *= radii[1] / radii[0];
        before = wheel;
    }
    let rest = static_state(&parts.build("pinion 0", 100.0).unwrap(), None).unwrap();
    assert_eq!(rest.instant, None);
    for (contact, (force, deflection)) in rest.contacts.iter().zip(expected) {
        assert!((contact.force / force - 1.0).abs() < 1e-6, "{} for {force}", contact.force);
        assert!(
            (contact.deflection - deflection).abs() < 1e-6 * force / k,
            "{} for {deflection}",
            contact.deflection
        );
    }
}

/// A load that only a formula knows, with time as the only drive: q'' = 3 + cos² 0.7t + 5 sin 1.4t - 2q - q³ - 0.1 v. The
/// mean load is 3.5, and 2q + q³ = 3.5.
#[test]
fn the_mean_of_a_formula_is_that_of_its_accelerations() {
    struct Loaded;
    impl Model for Loaded {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            let t = u[0];
            let load = 3.0 + (0.7 * t).cos().powi(2) + 5.0 * (1.4 * t).sin();
            a[0] = load - 2.0 * q[0] - q[0].powi(3) - 0.1 * v[0];
        }
    }
    impl Periodic for Loaded {
        fn period(&self) -> f64 {
            std::f64::consts::TAU / 1.4
        }
    }
    let q = static_state(&Loaded, None).unwrap().state.q[0];
    assert!((2.0 * q + q.powi(3) - 3.5).abs() < 1e-9, "{q}");
    let q = static_state(&Loaded, 0.0).unwrap().state.q[0];
    assert!((2.0 * q + q.powi(3) - 4.0).abs() < 1e-9, "{q}");
}

/// Random stiffness waves with up to 60 orders, or jumps, of random mean, on random loads: the deflection is load over mean
/// stiffness.
#[test]
fn means_of_waves_of_many_orders() {
    let mut random = Random(48);
    for case in 0..200 {
        let mean = 1e8 * (1.0 + random.next());
        let wave = if case % 2 == 0 {
            let orders = 1 + (60.0 * random.next()) as usize;
            let share = 0.4 / orders as f64;
            let terms: Vec<[f64; 2]> = (0..orders)
                .map(|_| {
                    [share * mean * (2.0 * random.next() - 1.0), share * mean * (2.0 * random.next() - 1.0)]
                })
                .collect();
            fourier(mean, &terms)
        } else {
            // (2 - ε) of a mesh cycle with one pair, (ε - 1) with two.
            let (ratio, single) = (1.2 + 0.6 * random.next(), 0.8 * mean);
            let double = (mean - (2.0 - ratio) * single) / (ratio - 1.0);
            Wave::new(RectangularWave::of_contact_ratio(ratio, single, double).unwrap())
        };
        let torque = 10.0 + 90.0 * random.next();
        let mut parts = Parts::new();
        parts.body("pinion", Body::new(1e-3)).body("wheel", Body::new(2e-2));
        parts.mesh(
            "mesh",
            "pinion",
            "wheel",
            MeshPart::external([20, 50], [0.02, 0.05], wave).half_backlash(3e-5),
        );
        parts.torque("drive", "pinion", torque).load("wheel");
        let contact = static_state(&parts.build("pinion", 150.0).unwrap(), None).unwrap().contacts[0];
        let expected = 3e-5 + torque / 0.02 / mean;
        assert!(
            (contact.deflection / expected - 1.0).abs() < 1e-9,
            "case {case}: {contact:?} for {expected}"
        );
    }
}

/// The default start is in the middle of the motion: a train whose slow shaft mode rings for long settles at once where the
/// ripple is fast.
#[test]
fn the_default_start_is_that_of_the_mean_load() {
    let train =
        ripple(fourier(1.0, &[[1.65, 0.0]]), fourier(3e8, &[[0.0, 0.0]])).build("motor", 4000.0).unwrap();
    let solver = Dop853::new().rtol(1e-9).atol(1e-15);
    let settle = Settle::new().max_periods(3000).tolerance(1e-4);
    let mean = settle.run(&solver, &train, None).unwrap();
    let first = settle.run(&solver, &train, &static_state(&train, 0.0).unwrap().state).unwrap();
    assert!(mean.periods < first.periods, "{} and {}", mean.periods, first.periods);
}

/// Three meshes side by side whose errors have means of 0, 2 and -3 μm: a small torque is carried by the third alone, for
/// every phase of the waves. Its deflection is b + ⟨K e⟩/⟨K⟩ + T/(r ⟨K⟩), whatever the waves are at t = 0.
#[test]
fn meshes_side_by_side_share_the_mean_load() {
    for phase in [0.0, 1.0, 2.5] {
        let mut parts = Parts::new();
        parts.body("pinion", Body::new(1e-3)).body("wheel", Body::new(1e-3));
        for (name, e) in [("first", 0.0), ("second", 2e-6), ("third", -3e-6)] {
            let mesh = MeshPart::external([20, 40], [0.03, 0.06], fourier(2e8, &[[2e7, 0.0]]));
            let mesh = mesh.error(fourier(e, &[[1e-6, 0.0]])).half_backlash(2e-5).phase(phase);
            parts.mesh(name, "pinion", "wheel", mesh);
        }
        parts.torque("drive", "pinion", 10.0).load("wheel");
        let found = static_state(&parts.build("pinion", 100.0).unwrap(), None).unwrap();
        assert_eq!((found.instant, found.pieces[2]), (None, Piece::Upper));
        assert_eq!(found.pieces[..2], [Piece::Gap, Piece::Gap]);
        // The deflection without the error: its mean is ⟨e⟩ below.
        let expected = 2e-5 + 0.5 * 0.1 * 1e-6 + 10.0 / 0.03 / 2e8;
        let deflection = found.contacts[2].deflection;
        assert!((deflection / expected - 1.0).abs() < 1e-9, "{deflection:e} for {expected:e}");
    }
}

/// A pulse of 1/750 of the period between the points of the first two sums is seen: the mean load is 1 + 100 w √π/2π.
#[test]
fn a_narrow_pulse_is_part_of_the_mean() {
    struct Pulse;
    impl Model for Pulse {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            let place = (u[0].rem_euclid(std::f64::consts::TAU) - 1.3) / 0.005;
            a[0] = 1.0 + 100.0 * (-place * place).exp() - q[0];
        }
    }
    impl Periodic for Pulse {
        fn period(&self) -> f64 {
            std::f64::consts::TAU
        }
    }
    let found = static_state(&Pulse, None).unwrap();
    let mean = 1.0 + 0.5 * std::f64::consts::PI.sqrt() / std::f64::consts::TAU;
    assert!((found.state.q[0] - mean).abs() < 1e-8, "{found:?}");
    assert_eq!(found.instant, None);
    assert_eq!(static_state(&Pulse, 0.0).unwrap().instant, Some(0.0));
}

/// A soft spring of a large inertia beside a stiff one of a small inertia is no rigid motion.
#[test]
fn a_soft_spring_beside_a_light_body_carries_its_load() {
    struct Soft;
    impl Model for Soft {
        fn dof(&self) -> usize {
            2
        }
        fn accel(&self, _: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            let coupling = 1e6 * (q[0] - q[1]);
            a[0] = -coupling / 1e-7;
            a[1] = coupling - q[1] - 0.5 * v[1] + 3.0;
        }
        fn offers(&self) -> Offers<'_> {
            Offers { jacobian: true, ..Offers::default() }
        }
        fn jacobian(&self, _: Option<&[Piece]>, _: &[f64], _: &[f64], _: &[f64], out: &mut Jacobian) {
            out.q.copy_from_slice(&[-1e13, 1e6, 1e13, -1e6 - 1.0]); // column by column
            out.v.copy_from_slice(&[0.0, 0.0, 0.0, -0.5]);
        }
    }
    impl Periodic for Soft {
        fn period(&self) -> f64 {
            1.0
        }
    }
    let found = static_state(&Soft, None).unwrap();
    assert!((found.state.q[1] - 3.0).abs() < 1e-8, "{found:?}");
    assert!(found.acceleration.iter().all(|a| a.abs() < 1e-3), "{found:?}");
}

/// The teeth part in some instants: the mean of the force by deflection is that of a sum of a million instants, also
/// where the period has 20 to 123 mesh cycles, of which a few points each would be one and the same phase.
#[test]
fn the_mean_force_of_parting_teeth_is_that_of_the_whole_period() {
    let (k0, k1, error, half) = (3e8, 6e7, 4e-6, 4e-5);
    for teeth in [[20, 40], [20, 41], [24, 36]] {
        for ripple in [None, Some(1), Some(2)] {
            let radii = [0.03, 0.03 * f64::from(teeth[1]) / f64::from(teeth[0])];
            let stiffness = Wave::new(Fourier::new(k0, &[[k1, 0.0]]).unwrap());
            let mesh = MeshPart::external(teeth, radii, stiffness)
                .error(Wave::new(Fourier::new(0.0, &[[0.0, error]]).unwrap()))
                .half_backlash(half);
            let mut parts = Parts::new();
            parts.body("pinion", Body::new(1e-3)).body("wheel", Body::new(4e-3));
            parts.mesh("mesh", "pinion", "wheel", mesh).torque("drive", "pinion", 30.0).load("wheel");
            if let Some(order) = ripple {
                let once = Wave::new(Fourier::new(0.0, &[[1.0, 0.0]]).unwrap()).per_turn(order).unwrap();
                parts.torque_of_angle("ripple", "wheel", 10.0, once);
            }
            let rest = static_state(&parts.build("pinion", 100.0).unwrap(), None).unwrap();
            // On its flank for the whole period the mean force is 1000 N: k0 (x - b) = 1000 N, since the mean of
            // cos φ sin φ is 0.
            let past = 1000.0 / k0;
            let count = 1_000_000;
            let force = |i: u32| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(count)).sin_cos();
                (k0 + k1 * cos) * (past - error * sin).max(0.0)
            };
            let mean = (0..count).map(force).sum::<f64>() / f64::from(count);
            let off = (rest.contacts[0].force - mean).abs();
            assert!(off < 2e-4 * mean, "{teeth:?} {ripple:?}: {} {mean}", rest.contacts[0].force);
        }
    }
}

/// Gear 1 of a ring drives all others in both directions, each with the same torque T: along each half the force of the
/// meshes falls by T/R from gear to gear. One half is on upper flanks, the other one on lower flanks. All flanks of one
/// kind pull, since the gaps do not add up around the ring. 12 gears have full equations, 80 sparse ones.
#[test]
fn a_ring_carries_its_load_on_both_flanks() {
    for gears in [12, 80] {
        let (torque, radius) = (20.0, 0.0564);
        let stiff = Shaft { stiffness: 3e5, damping: 1.0 };
        let set = RingSet {
            gear_inertia: 1.5e-3,
            load_inertia: 1.5e-3,
            base_radius: radius,
            motor_shaft: stiff,
            output_shaft: stiff,
            mesh_stiffness: 1e8,
            stiffness_harmonics: vec![0.2],
            error: 1e-7,
            motor_torque: torque * gears as f64,
            load_torque: torque,
            ..RingSet::set_a(gears, 1000.0)
        };
        let ring = Ring::as_printed(&set.params().unwrap()).unwrap();
        let rest = static_state(&ring, None).unwrap();
        assert_eq!(rest.instant, None, "{gears} gears");
        let count = |piece| rest.pieces.iter().filter(|p| **p == piece).count();
        let carried = [count(Piece::Upper), count(Piece::Lower)];
        assert!(carried.iter().all(|&n| n.abs_diff(gears / 2) <= 1), "{gears} gears: {carried:?}");
        let forces: Vec<f64> = rest.contacts.iter().map(|c| c.force).collect();
        let drop = torque / radius;
        for pair in forces.windows(2) {
            assert!(((pair[0] - pair[1]).abs() - drop).abs() < 1e-6 * drop, "{gears}: {pair:?} {drop}");
        }
    }
}

/// A pair without a load rests in the middle of its gap, clear of both flanks, whatever its transmission error is: the
/// teeth carry nothing at any instant. So does an idle pair beside a loaded one.
#[test]
fn an_idle_pair_rests_in_the_middle_of_its_gap() {
    let half = 1e-5;
    for (mean, swing) in [(0.0, 0.0), (0.0, 9e-6), (3e-5, 9e-6), (-3e-5, 0.0)] {
        let mesh = |teeth: [u32; 2]| {
            let radii = teeth.map(|teeth| 1e-3 * f64::from(teeth));
            let mesh = MeshPart::external(teeth, radii, fourier(2e8, &[[2e7, 0.0]])).damping(500.0);
            mesh.error(fourier(mean, &[[0.0, swing]])).half_backlash(half).phase(0.0)
        };
        for (coordinates, loaded) in
            [Coordinates::Inertial, Coordinates::Relative].into_iter().zip([false, true])
        {
            let mut parts = Parts::new();
            parts
                .body("driver", Body::new(1e-2))
                .body("idle", Body::new(1e-3))
                .body("driven", Body::new(1e-3));
            parts.mesh("first", "driver", "idle", mesh([20, 40])).mesh(
                "second",
                "driver",
                "driven",
                mesh([20, 30]),
            );
            parts.torque("drive", "driver", if loaded { 20.0 } else { 0.0 }).load("driven");
            let train = parts.coordinates(coordinates).build("driver", 100.0).unwrap();
            let found = static_state(&train, None).unwrap();
            let [idle, driven] = [found.contacts[0], found.contacts[1]];
            assert_eq!((found.instant, found.pieces[0]), (None, Piece::Gap), "{mean} {swing}");
            // The mean force of the damping is 0 to rounding.
            assert!(idle.force.abs() < 1e-12 && idle.deflection.abs() < 1e-12, "{mean} {swing}: {idle:?}");
            // With a swing the loaded teeth part in some instants.
            let carried = if loaded { 1000.0 } else { 0.0 };
            let parts = loaded && swing > 0.0;
            assert!(parts || (driven.force - carried).abs() < 1e-6, "{mean} {swing}: {driven:?}");
        }
    }
}

/// A stiffness that swings with the transmission error shifts the mean force: under a light load the flank that presses is
/// found by this force, not by the mean deflection. Its mean over the period is the load.
#[test]
fn a_light_load_is_carried_by_the_flank_that_presses() {
    let (stiffness, swing, half) = (2e8, 6e7, 5e-5);
    for (error, torque) in
        [(1e-5, -3.0), (1e-5, 3.0), (-1e-5, 3.0), (-1e-5, -3.0), (3e-5, -8.0), (1e-6, -0.3)]
    {
        let mesh = MeshPart::external([20, 40], [0.03, 0.06], fourier(stiffness, &[[swing, 0.0]]));
        let mut parts = Parts::new();
        parts.body("pinion", Body::new(1e-3)).body("wheel", Body::new(4e-3));
        let mesh = mesh.error(fourier(0.0, &[[error, 0.0]])).half_backlash(half).phase(0.0);
        parts.mesh("mesh", "pinion", "wheel", mesh);
        parts.torque("drive", "pinion", torque).torque("load", "wheel", -2.0 * torque);
        let train = parts.build("pinion", 100.0).unwrap();
        let found = static_state(&train, None).unwrap();
        let load = torque / 0.03;
        let (edge, piece) = if load < 0.0 { (-half, Piece::Lower) } else { (half, Piece::Upper) };
        assert_eq!((found.instant, found.pieces[0]), (None, piece), "{error} {torque}");
        let count = 64;
        let force = (0..count).map(|k| {
            let at = static_drives(&train, train.period() * f64::from(k) / f64::from(count), &found.state);
            let angle = TAU * f64::from(k) / f64::from(count);
            (stiffness + swing * angle.cos()) * (at.deflection - edge)
        });
        let mean = force.sum::<f64>() / f64::from(count);
        assert!((mean - load).abs() < 1e-6 * load.abs(), "{error} {torque}: {mean} for {load}");
    }
}

/// The contact of a train at rest in a state, with the drives at a time.
fn static_drives(train: &dyn Model, t: f64, state: &State) -> Contact {
    let (mut u, mut contact) = (vec![0.0; train.drives()], [Contact::default()]);
    train.drive(t, Side::After, &mut u);
    train.contact(&u, &state.q, &vec![0.0; train.dof()], &mut contact);
    contact[0]
}

/// A bearing with clearance that carries nothing, or as much as a mesh beside a shaft pushes it with: the forces of the
/// meshes follow from the torques. Constant waves have no instant.
#[test]
fn bearings_with_clearance_under_small_loads_rest() {
    let mut random = Random(2);
    let mut between = |low: f64, high: f64| low + (high - low) * random.next();
    let cos = 20f64.to_radians().cos();
    for case in 0..300 {
        let (bodies, torque) = (2 + case % 2, if case % 3 == 0 { 0.0 } else { between(5.0, 60.0) });
        let teeth = [20, 40, 30];
        let radius = |i: usize| 1e-3 * f64::from(teeth[i]);
        let (mut parts, mut centre) = (Parts::new(), [0.0; 2]);
        let [held, on] = [0.0; 2].map(|_| between(0.0, bodies as f64) as usize);
        let name = |i: usize| format!("body {i}");
        for i in 0..bodies {
            if i > 0 {
                let (far, turn) = ((radius(i) + radius(i - 1)) / cos, between(0.0, std::f64::consts::TAU));
                centre = [centre[0] + far * turn.cos(), centre[1] + far * turn.sin()];
            }
            let body = Body::new(1e-3).centre(centre);
            let bearing = Bearing::new(1.0, 10f64.powf(between(7.0, 9.0))).damping(1e3);
            let bearing = bearing.half_clearance(10f64.powf(between(-6.0, -4.0)));
            parts.body(&name(i), if i == held { body.bearing(bearing) } else { body });
        }
        for i in 1..bodies {
            let stiffness = Wave::constant(10f64.powf(between(7.5, 9.0))).unwrap();
            let mesh = MeshPart::external([teeth[i - 1], teeth[i]], [radius(i - 1), radius(i)], stiffness);
            let mesh = mesh.pressure_angle(20f64.to_radians()).half_backlash(10f64.powf(between(-6.0, -4.0)));
            parts.mesh(&format!("mesh {i}"), &name(i - 1), &name(i), mesh);
        }
        let load = (on + 1) % bodies;
        parts.torque("drive", &name(on), torque).load(&name(load));
        let found = static_state(&parts.build(&name(0), 100.0).unwrap(), None);
        let found = found.unwrap_or_else(|error| panic!("case {case}: {error}"));
        assert_eq!(found.instant, None, "case {case}");
        for i in 1..bodies {
            let carries = on.min(load) < i && i <= on.max(load);
            let force = if carries { torque / radius(on) } else { 0.0 };
            let off = (found.contacts[i - 1].force.abs() - force).abs();
            assert!(
                off <= 1e-6 * torque / radius(on) + 1e-9,
                "case {case}: mesh {i} carries {off:e} more than {force}"
            );
        }
    }
}

/// A contact with one flank: q'' = load - 0.1 v - (q - edge beyond it). It rests at edge + load.
#[test]
fn a_single_flank_carries_its_load() {
    #[derive(Clone, PartialEq)]
    struct OneFlank {
        edges: [f64; 2],
        load: f64,
    }
    impl Shape for OneFlank {
        fn size(&self) -> Size {
            Size { dof: 1, contacts: 1, constants: 1, ..Size::default() }
        }
        fn names(&self) -> Vec<Channel> {
            vec![Channel::new("speed", "1")]
        }
        fn contact<S: Scalar, L: PieceChoice<S>>(
            &self,
            _: &L,
            _: usize,
            _: Drives<'_, S>,
            q: &[S],
            v: &[S],
        ) -> Contact<S> {
            let [lower, upper] = self.edges.map(S::from);
            Contact { deflection: q[0], rate: v[0], lower, upper, ..Contact::default() }
        }
        fn accel<S: Scalar, L: PieceChoice<S>>(
            &self,
            laws: &L,
            u: Drives<'_, S>,
            q: &[S],
            v: &[S],
            a: &mut [S],
        ) {
            let Contact { deflection: d, rate, lower, upper, .. } = self.contact(laws, 0, u, q, v);
            let force = laws.force(0, &Backlash::new(0.0).unwrap(), Deflection { d, rate, lower, upper });
            a[0] = S::from(self.load) - v[0] * 0.1 - force;
        }
    }
    for (edges, load, at) in
        [([-0.5, f64::INFINITY], -0.3, -0.8), ([f64::NEG_INFINITY, 0.5], 0.3, 0.8), ([-0.5, 0.5], -0.3, -0.8)]
    {
        let model = Machine::of_constants(OneFlank { edges, load }, &[("speed", 1.0)]).unwrap();
        for found in [static_state(&model, None), static_state(&model, 0.0)] {
            let found = found.unwrap();
            assert!((found.state.q[0] - at).abs() < 1e-12, "{edges:?} {:?}", found.state);
        }
    }
}

/// The mean of a ripple over a period of many mesh cycles: the coarse first sum sees a load that does not balance.
/// A drag does not act at rest, and the closed form is b + F/k.
#[test]
fn a_coarse_sum_of_a_ripple_is_no_verdict() {
    let stiffness = || Wave::new(Fourier::new(1e8, &[[1e7, 0.0]]).unwrap());
    let radius = |teeth: u32| 0.0014 * f64::from(teeth);
    let mesh = |teeth: [u32; 2], phase: f64| {
        MeshPart::external(teeth, teeth.map(radius), stiffness()).half_backlash(2e-5).phase(phase)
    };
    for ripple in [vec![[0.5, 0.3]], vec![[0.5, 0.3], [-0.5, 0.0]], vec![[0.0, 0.4]]] {
        for drag in [0.0, 0.1] {
            let mut parts = Parts::new();
            parts.body("p", Body::new(1e-3).drag(drag)).body("w", Body::new(1e-3));
            parts.body("q", Body::new(2e-3)).body("x", Body::new(2e-3));
            parts.mesh("m", "p", "w", mesh([21, 48], 0.0)).mesh("n", "q", "x", mesh([19, 54], 0.3));
            parts.shaft("s", "w", "q", ShaftPart::new(1e4).damping(1.0));
            let ripple = Wave::new(Fourier::new(0.0, &ripple).unwrap());
            parts.torque("T", "p", 50.0).torque_of_angle("rip", "p", 10.0, ripple).load("x");
            let train = parts.coordinates(Coordinates::Inertial).build("p", 50.0).unwrap();
            let found = static_state(&train, None).unwrap();
            assert_eq!(found.instant, None);
            let forces = [50.0 / radius(21), 50.0 * 48.0 / 21.0 / radius(19)];
            for (contact, force) in found.contacts.iter().zip(forces) {
                let exact = 2e-5 + force / 1e8;
                assert!((contact.deflection / exact - 1.0).abs() < 1e-8, "{drag}: {contact:?} {exact}");
            }
        }
    }
}
