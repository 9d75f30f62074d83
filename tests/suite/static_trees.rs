//! Static states of trees and rings of gears, whose forces follow from the torques: light loads, unequal inertias, meshes
//! without backlash, gears without a load.

use crate::common::random::Random;
use gear_dynamics::excitation::Fourier;
use gear_dynamics::linear::{LinearError, static_state};
use gear_dynamics::model::from_fn;
use gear_dynamics::trains::{Body, Coordinates, MeshPart, Parts, ShaftPart, Train, Warning};
use gear_dynamics::{Model, Wave};

const RADIUS: f64 = 0.03;

/// A mesh between two gears, with half its backlash.
type Pair = (usize, usize, f64);

/// Gears of 30 teeth with these inertias and torques; the mesh stiffness has a ripple of 0.2.
fn train(inertias: &[f64], meshes: &[Pair], torques: &[f64], coordinates: Coordinates) -> Train {
    let mut parts = Parts::new();
    for (i, inertia) in inertias.iter().enumerate() {
        parts.body(&format!("g{i}"), Body::new(*inertia));
    }
    for (m, &(a, b, half_backlash)) in meshes.iter().enumerate() {
        let stiffness = Wave::new(Fourier::new(2e8, &[[4e7, 0.0]]).unwrap());
        let part = MeshPart::external([30, 30], [RADIUS; 2], stiffness);
        let part = part.half_backlash(half_backlash).phase(0.37 * m as f64);
        parts.mesh(&format!("m{m}"), &format!("g{a}"), &format!("g{b}"), part);
    }
    for (i, torque) in torques.iter().enumerate().filter(|(_, torque)| **torque != 0.0) {
        parts.torque(&format!("t{i}"), &format!("g{i}"), *torque);
    }
    parts
        .coordinates(coordinates)
        .accept(Warning::UnusualValue)
        .accept(Warning::Unbalanced)
        .build("g0", 100.0)
        .unwrap()
}

fn ring(gears: usize) -> Vec<Pair> {
    (0..gears).map(|i| (i, (i + 1) % gears, 4e-5)).collect()
}

/// The mesh forces of a state under the mean loads, and its accelerations.
fn rest(train: &Train) -> (Vec<f64>, Vec<f64>) {
    let state = static_state(train, None).unwrap();
    assert_eq!(state.instant, None);
    (state.contacts.iter().map(|c| c.force).collect(), state.acceleration)
}

fn near(found: &[f64], expected: &[f64], tolerance: f64) {
    let is_near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance);
    assert!(is_near && found.len() == expected.len(), "{found:?} for {expected:?} to {tolerance:e}");
}

const BOTH: [Coordinates; 2] = [Coordinates::Relative, Coordinates::Inertial];

/// Removes leaf after leaf: the force of its mesh carries the torques that were collected on it.
fn forces_of_a_tree(meshes: &[Pair], torques: &[f64]) -> Vec<f64> {
    let (mut left, mut forces) = (torques.to_vec(), vec![0.0; meshes.len()]);
    for (m, &(parent, child, _)) in meshes.iter().enumerate().rev() {
        forces[m] = -left[child] / RADIUS;
        left[parent] += left[child];
    }
    assert!(left[0].abs() <= 1e-9 * torques.iter().fold(0.0, |most: f64, t| most.max(t.abs())));
    forces
}

/// Random trees: the torque of the first gear balances the others. Signs of torques are those along the motion.
#[test]
fn forces_of_random_trees_follow_from_their_torques() {
    let mut random = Random(20_262_011);
    let mut draw = |low: f64, high: f64| low + (high - low) * random.next();
    for case in 0..240 {
        let (gears, kind) = (3 + case % 9, case % 4);
        let mut inertia = || match kind {
            0 | 1 => [1e-3, 1e-2][usize::from(draw(0.0, 1.0) < 0.5)],
            2 => [1e-6, 1.0][usize::from(draw(0.0, 1.0) < 0.5)],
            _ => 10f64.powf(draw(-5.0, 0.0)),
        };
        let inertias: Vec<f64> = (0..gears).map(|_| inertia()).collect();
        let size = [100.0, 1e-3, 100.0, 1.0][kind];
        let mut torques: Vec<f64> = (0..gears)
            .map(|_| if draw(0.0, 1.0) < 0.4 { 0.0 } else { size * (draw(-1.0, 1.0) * 8.0).round() / 8.0 })
            .collect();
        torques[0] = -torques[1..].iter().sum::<f64>();
        let mesh = |child: usize, parent: f64, gap: f64| {
            let half_backlash = if gap < 0.2 { 0.0 } else { [4e-5, 1e-4][usize::from(gap < 0.6)] };
            ((parent * child as f64) as usize, child, half_backlash)
        };
        let meshes: Vec<Pair> = (1..gears).map(|child| mesh(child, draw(0.0, 1.0), draw(0.0, 1.0))).collect();
        let expected = forces_of_a_tree(&meshes, &torques);
        for coordinates in BOTH {
            let (found, _) = rest(&train(&inertias, &meshes, &torques, coordinates));
            near(&found, &expected, 1e-6 * size / RADIUS + 1e-8);
        }
    }
}

/// A ring whose first gear drives the three others, under torques down to a millionth of k b r.
#[test]
fn light_loads_of_a_ring_are_shared_by_symmetry() {
    for torque in [1.0, 1e-3, 1e-4] {
        for coordinates in BOTH {
            let torques = [torque, -torque / 3.0, -torque / 3.0, -torque / 3.0];
            let (found, _) = rest(&train(&[1e-3; 4], &ring(4), &torques, coordinates));
            let expected = [0.5, 1.0 / 6.0, -1.0 / 6.0, -0.5].map(|share| share * torque / RADIUS);
            near(&found, &expected, 1e-6 * torque / RADIUS + 1e-10);
        }
    }
}

/// Two gears of a ring of 6: the short way carries the load, the long way lies in its gaps. Opposite gears of rings of
/// 127 to 130 coordinates, with full and with sparse equations: both ways carry half.
#[test]
fn rings_between_two_gears() {
    for coordinates in BOTH {
        let torques = [200.0, 0.0, -200.0, 0.0, 0.0, 0.0];
        let (found, _) = rest(&train(&[1e-3; 6], &ring(6), &torques, coordinates));
        let force = 200.0 / RADIUS;
        near(&found, &[force, force, 0.0, 0.0, 0.0, 0.0], 1e-6 * force);
        for gears in [128, 130] {
            let mut torques = vec![0.0; gears];
            (torques[0], torques[gears / 2]) = (300.0, -300.0);
            let (found, _) = rest(&train(&vec![1e-3; gears], &ring(gears), &torques, coordinates));
            let expected: Vec<f64> =
                (0..gears).map(|i| if i < gears / 2 { 5000.0 } else { -5000.0 }).collect();
            near(&found, &expected, 5e-3);
        }
    }
}

/// A chain whose only torque drives it: all gears have the same acceleration T/ΣJ.
#[test]
fn a_load_that_nothing_balances_accelerates_the_whole_chain() {
    for gears in [5, 127, 128] {
        let mut torques = vec![0.0; gears];
        torques[0] = 10.0;
        let meshes = &ring(gears)[..gears - 1];
        let (_, found) = rest(&train(&vec![1e-3; gears], meshes, &torques, Coordinates::Inertial));
        let expected = 10.0 / (1e-3 * gears as f64);
        near(&found, &vec![expected; gears], 1e-8 * expected);
    }
}

/// A mass that nothing holds is told, however light the mass beside it is.
#[test]
fn a_free_mass_beside_a_light_one_is_told() {
    for light in [1.0, 1e-6, 1e-9] {
        let accel = move |_: f64, q: &[f64], _: &[f64], a: &mut [f64]| {
            (a[0], a[1]) = ((1.0 - 1e3 * q[0]) / light, 2.0 - q[1].tanh());
        };
        let model = from_fn(2, accel).unwrap().with_period(1.0).unwrap();
        assert_eq!(model.dof(), 2);
        assert!(matches!(static_state(&model, None), Err(LinearError::Free { .. })), "{light:e}");
    }
}

/// A loaded wheel on its own support stays inside the gap, and its neighbours carry nothing: closed form.
#[test]
fn parts_without_a_load_rest() -> std::result::Result<(), Box<dyn std::error::Error>> {
    let (support, torque) = (17_207.792, -29.075_986);
    for inertia in [1e-2, 1e-4, 1e-1] {
        let mut parts = Parts::new();
        parts.body("b0", Body::new(1e-2)).body("b1", Body::new(inertia).restrained(support, 1.0));
        parts.body("b2", Body::new(1e-2).restrained(7762.122, 1.0));
        let stiffness = Wave::new(Fourier::new(2.54e8, &[])?);
        let mesh =
            MeshPart::external([73, 44], [0.073, 0.044], stiffness).damping(500.0).half_backlash(8.84e-5);
        parts.mesh("m", "b0", "b1", mesh).shaft("s", "b0", "b2", ShaftPart::new(21_507.6).damping(1.0));
        parts.torque("t", "b1", torque);
        let state = static_state(&parts.build("b0", 100.0)?, None)?;
        assert!((state.state.q[1] / (torque / support) - 1.0).abs() < 1e-12, "{:?}", state.state.q);
        assert!(state.state.q[0].abs() < 1e-15 && state.contacts[0].force == 0.0, "{:?}", state.state.q);
    }
    Ok(())
}
