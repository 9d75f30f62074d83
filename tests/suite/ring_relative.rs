//! The relative coordinates of Yao 2020: the table of coefficients for n = 3, and conversion in both
//! directions.

use crate::api::*;
use std::ops::ControlFlow;

/// Three gears with different parameters.
fn params() -> RingParams {
    let mut params = RingSet::set_a(3, 1000.0).params().unwrap();
    params.motor = Motor { inertia: 0.031, torque: 44.0, shaft: Shaft { stiffness: 970.0, damping: 0.026 } };
    let numbers = [
        (1.7e-3, 0.056, 5.1e-3, 2.0, 24e3, 0.11),
        (1.9e-3, 0.051, 6.2e-3, 3.0, 21e3, 0.13),
        (2.3e-3, 0.061, 4.4e-3, 1.5, 27e3, 0.17),
    ];
    for (gear, (inertia, base_radius, load, torque, stiffness, damping)) in
        params.gears.iter_mut().zip(numbers)
    {
        *gear = Gear {
            inertia,
            base_radius,
            load: Load { inertia: load, torque, shaft: Shaft { stiffness, damping } },
        };
    }
    for (i, mesh) in params.meshes.iter_mut().enumerate() {
        let k = 1.9e8 + 1e7 * i as f64;
        let stiffness = Wave::new(Fourier::new(k, &[[0.1 * k, 0.0]]).unwrap()).with_phase(i as f64).unwrap();
        let error = Wave::new(Fourier::new(0.0, &[[0.0, 2e-6 + 1e-6 * i as f64]]).unwrap())
            .with_phase(0.5 * i as f64)
            .unwrap();
        *mesh = Mesh::new(stiffness, error, Backlash::new(2e-5 + 1e-6 * i as f64).unwrap());
        params.mesh_damping[i] = 900.0 + 100.0 * i as f64;
    }
    params
}

fn ring() -> Ring {
    Ring::as_printed(&params()).unwrap()
}

const B_E: f64 = 2.5e-5;
const OMEGA_N: f64 = 1.3e3;

/// The coefficients of the list under Eq. (2) of Yao 2020, corrected (docs/errata.md). An entry X/D means ξ =
/// C_X/(2 D ω) and k = K_X/(D ω²).
#[test]
#[rustfmt::skip]
fn coefficients_of_the_printed_table() {
    let ring = ring();
    let mesh_k = [1.9e8, 2.0e8, 2.1e8];
    let view = ring.relative(B_E, OMEGA_N).unwrap();
    let (xi, k) = view.coefficients(&mesh_k).unwrap();
    let p = params();
    let j: Vec<f64> = p.gears.iter().map(|g| g.inertia).collect();
    let jl: Vec<f64> = p.gears.iter().map(|g| g.load.inertia).collect();
    let r: Vec<f64> = p.gears.iter().map(|g| g.base_radius).collect();
    let m: Vec<f64> = (0..3).map(|i| j[i] / (r[i] * r[i])).collect();
    let together = |a: f64, b: f64| a * b / (a + b);
    let (je1, je2) = (together(j[0], p.motor.inertia), together(j[0], jl[0]));
    let (je3, je4) = (together(j[1], jl[1]), together(j[2], jl[2]));
    let (me1, me2, me3) = (together(m[0], m[1]), together(m[1], m[2]), together(m[2], m[0]));
    let big_p = |i: usize| j[i - 1] / (r[i - 1] * B_E);
    let big_q = |i: usize| m[i - 1] * r[i - 1] * B_E;
    // Links: M, g12, g23, g31, s1, s2, s3 are the columns q1 to q7.
    let (motor, g12, g23, g31, s1, s2, s3) = (0, 1, 2, 3, 4, 5, 6);
    let c = [p.motor.shaft.damping, 900.0, 1000.0, 1100.0, 0.11, 0.13, 0.17];
    let stiff = [p.motor.shaft.stiffness, mesh_k[0], mesh_k[1], mesh_k[2], 24e3, 21e3, 27e3];
    // (row, [(sign, link, divisor)]); the rows are those of Eqs. (3a)-(3g).
    type Entries = Vec<(f64, usize, f64)>;
    let table: [(usize, Entries); 7] = [
        (0, vec![(1.0, motor, je1), (-1.0, g12, big_p(1)), (1.0, g31, big_p(1)), (-1.0, s1, j[0])]),
        (4, vec![(1.0, s1, je2), (-1.0, motor, j[0]), (1.0, g12, big_p(1)), (-1.0, g31, big_p(1))]),
        (5, vec![(1.0, s2, je3), (-1.0, g12, big_p(2)), (1.0, g23, big_p(2))]),
        (6, vec![(1.0, s3, je4), (-1.0, g23, big_p(3)), (1.0, g31, big_p(3))]),
        (1, vec![(1.0, g12, me1), (-1.0, motor, big_q(1)), (-1.0, g23, m[1]), (-1.0, g31, m[0]),
                 (1.0, s1, big_q(1)), (-1.0, s2, big_q(2))]),
        (2, vec![(1.0, g23, me2), (-1.0, g12, m[1]), (-1.0, g31, m[2]), (1.0, s2, big_q(2)),
                 (-1.0, s3, big_q(3))]),
        (3, vec![(1.0, g31, me3), (-1.0, g23, m[2]), (1.0, motor, big_q(1)), (-1.0, g12, m[0]),
                 (-1.0, s1, big_q(1)), (1.0, s3, big_q(3))]),
    ];
    for (row, entries) in table {
        for column in 0..7 {
            let entry = entries.iter().find(|e| e.1 == column);
            let expected = entry.map_or([0.0; 2], |(sign, link, d)| {
                [sign * c[*link] / (2.0 * d * OMEGA_N), sign * stiff[*link] / (d * OMEGA_N * OMEGA_N)]
            });
            for (ours, theirs) in [(xi[(row, column)], expected[0]), (k[(row, column)], expected[1])] {
                assert!(
                    (ours - theirs).abs() <= 1e-13 * theirs.abs(),
                    "q{}, q{}: {ours} against {theirs}", row + 1, column + 1
                );
            }
        }
    }
}

/// The equations in relative coordinates, q'' = f - 2 ξ q' - k g(q), give the accelerations of the equations
/// in angles, with the forcing f1 to f7.
#[test]
fn accelerations_agree_with_the_angle_form() {
    let ring = ring();
    let view = ring.relative(B_E, OMEGA_N).unwrap();
    let t = 3.1e-4;
    let state = State::new(
        t,
        &[2e-3, -1e-3, -1.2e-3, 5e-4, 3e-4, 1e-3, 2e-3],
        &[0.1, -0.3, 0.2, 0.05, -0.1, 0.4, 0.2],
    );
    let mut u = vec![0.0; ring.drives()];
    let mut a = [0.0; 7];
    ring.drive(t, Side::After, &mut u);
    ring.accel(&u, &state.q, &state.v, &mut a);
    let (q, v) = view.of(&state);
    let p = params();
    let mesh_k: Vec<f64> = p.meshes.iter().map(|m| m.stiffness().value(p.omega * t, Side::After)).collect();
    let (xi, k) = view.coefficients(&mesh_k).unwrap();
    let w2 = OMEGA_N * OMEGA_N;
    let error = |i: usize| p.omega * p.omega * p.meshes[i].error().jet(p.omega * t, Side::After).second;
    let g: Vec<f64> = (0..7)
        .map(|i| if (1..=3).contains(&i) { p.meshes[i - 1].law().at(q[i] * B_E) / B_E } else { q[i] })
        .collect();
    for i in 0..7 {
        let f = match i {
            0 => p.motor.torque / (p.motor.inertia * w2),
            1..=3 => -error(i - 1) / (B_E * w2),
            _ => p.gears[i - 4].load.torque / (p.gears[i - 4].load.inertia * w2),
        };
        let ours: f64 = f - (0..7).map(|j| 2.0 * xi[(i, j)] * v[j] + k[(i, j)] * g[j]).sum::<f64>();
        let b = ring.mesh_matrix();
        let moved: f64 = (0..7).map(|j| b[(i, j)] * a[j]).sum();
        let angle = match i {
            1..=3 => (moved - error(i - 1)) / (B_E * w2),
            _ => moved / w2,
        };
        assert!((ours - angle).abs() < 1e-11 * angle.abs().max(1e3), "q{}: {ours} against {angle}", i + 1);
    }
}

#[test]
fn there_and_back() {
    for n in [3, 5, 8] {
        let ring = Ring::as_printed(&RingSet { error: 3e-6, ..RingSet::set_a(n, 1500.0) }.params().unwrap())
            .unwrap();
        let view = ring.relative(B_E, OMEGA_N).unwrap();
        let t = 1.7e-4;
        let mut q: Vec<f64> = (0..2 * n + 1).map(|i| 0.3 * (i as f64).sin()).collect();
        let mut v: Vec<f64> = (0..2 * n + 1).map(|i| 0.2 * (1.7 * i as f64).cos()).collect();
        assert!(view.to_angles(t, &q, &v).is_err());
        view.close(t, &mut q, &mut v).unwrap();
        let (back, rates) = view.of(&view.to_angles(t, &q, &v).unwrap());
        for i in 0..2 * n + 1 {
            assert!((q[i] - back[i]).abs() < 1e-10 && (v[i] - rates[i]).abs() < 1e-10, "n = {n}, q{}", i + 1);
        }
    }
}

/// The sum of the mesh coordinates is -3 e(t)/b_e along a run, and both frames give the same relative motion.
#[test]
fn closure_and_frames() {
    let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params().unwrap()).unwrap();
    let view = ring.relative(2.65e-5, 1e3).unwrap();
    let solver = Dop853::new().rtol(1e-12).atol(1e-15);
    let e = |t: f64| ring.shape().meshes()[0].error().value(ring.speed() * t, Side::After);
    solver
        .run(&ring, &State::at_rest(7), 5e-3, &mut |step: &mut Step<'_>| {
            let (q, _) = view.of(&State::new(step.t1(), step.q1(), step.v1()));
            let sum: f64 = q[1..=3].iter().sum();
            assert!((sum + 3.0 * e(step.t1()) / 2.65e-5).abs() < 1e-8);
            ControlFlow::Continue(())
        })
        .unwrap();
    let inertial = solver.end(&ring, &State::at_rest(7), 5e-3).unwrap();
    let rigid = solver.end(&ring.clone().with_frame(Frame::Rigid), &State::at_rest(7), 5e-3).unwrap();
    let (a, b) = (view.of(&inertial).0, view.of(&rigid).0);
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-7), "{a:?} {b:?}");
    // The coordinates of the two frames differ by α t²/2.
    let moved = 0.5 * ring.rigid_acceleration() * 25e-6;
    assert!((inertial.q[0] - rigid.q[0] - moved).abs() < 1e-12 * moved.abs().max(1.0));
    assert!((ring.torque_imbalance() - 38.0).abs() < 1e-12);
}
