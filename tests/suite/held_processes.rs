//! Held processes: exact mean energies, independence of the solver, pinned values, torque and clearance of
//! the ring.

use crate::api::*;
use rand_distr::{Normal, Uniform};
use std::ops::ControlFlow;

/// x'' + c x' + x = 0. The damping c is a drive, to which `Noisy` adds random values.
struct Damped;

impl Model for Damped {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = -u[0] * v[0] - q[0];
    }
    fn drive(&self, _: f64, _: Side, u: &mut [f64]) {
        u[0] = 0.0;
    }
}

fn energy(s: &State) -> f64 {
    0.5 * (s.q[0] * s.q[0] + s.v[0] * s.v[0])
}

fn process(hold: f64, member: u64) -> HeldProcess {
    HeldProcess::new(hold, Uniform::new(0.0, 1.0).unwrap()).unwrap().seed(2020).member(member)
}

fn member(hold: f64, member: u64) -> Noisy<Damped> {
    Noisy::new(Damped).add(&[(0, 0.2)], &process(hold, member)).unwrap()
}

/// The mean energy at t = 40 of 1000 members is within three standard errors of the value from the exact
/// second moments.
#[test]
fn ensemble_energies() {
    let data = crate::data::read("closed_forms.json");
    let exact = data["held_random_damping"]["values"].as_array().unwrap();
    let solver = Dop853::new().rtol(1e-9).atol(1e-12);
    for hold in [0.5, 5.0, 40.0] {
        let expected = exact.iter().find(|v| v["hold"] == hold).unwrap()["E_energy"].as_f64().unwrap();
        let count = 1000;
        let energies: Vec<f64> = (0..count)
            .map(|k| energy(&solver.end(&member(hold, k), &State::new(0.0, &[1.0], &[0.0]), 40.0).unwrap()))
            .collect();
        let s = Summary::of_samples(&energies).unwrap();
        let error = s.deviation / (count as f64).sqrt();
        println!("h = {hold}: {} ± {error:.1e} against {expected}", s.mean);
        assert!((s.mean - expected).abs() < 3.0 * error);
    }
}

/// No step extends over the end of a hold interval, so that the result does not depend on the step size.
#[test]
fn independent_of_the_solver() {
    let start = State::new(0.0, &[1.0], &[0.0]);
    let truth = Dop853::new().rtol(1e-13).atol(1e-15).end(&member(0.37, 5), &start, 40.0).unwrap();
    let rk4 = Rk4::new(0.01).end(&member(0.37, 5), &start, 40.0).unwrap();
    let coarse = Rk4::new(0.02).end(&member(0.37, 5), &start, 40.0).unwrap();
    let rk45 = Rk45::new().rtol(1e-11).atol(1e-13).end(&member(0.37, 5), &start, 40.0).unwrap();
    assert!((rk45.q[0] - truth.q[0]).abs() < 1e-9);
    assert!((rk4.q[0] - truth.q[0]).abs() < 1e-9);
    assert!((coarse.q[0] - truth.q[0]) / (rk4.q[0] - truth.q[0]) > 12.0); // order 4: 16
    let mut edges = 0;
    Dop853::new()
        .run(&member(0.37, 5), &start, 40.0, &mut |step: &mut Step<'_>| {
            edges += u64::from(step.at_drive_edge());
            ControlFlow::Continue(())
        })
        .unwrap();
    assert_eq!(edges, 108);
}

/// A value is a function of seed, member, stream and number alone: the order of the calls does not matter,
/// and other members, streams and seeds give other values.
#[test]
fn counter_based() {
    let p = process(0.1, 3);
    let forward: Vec<u64> = (0..100).map(|k| p.held(7, k).to_bits()).collect();
    let backward: Vec<u64> = (0..100).rev().map(|k| p.held(7, k).to_bits()).collect();
    assert!(forward.iter().eq(backward.iter().rev()));
    let others = [process(0.1, 4).held(7, 0), process(0.1, 3).held(8, 0), process(0.1, 3).seed(1).held(7, 0)];
    assert!(others.iter().all(|x| x.to_bits() != forward[0]));
    // The values themselves are pinned: the crate promises that they do not change.
    let first: Vec<f64> = (0..3).map(|k| p.held(7, k)).collect();
    println!("{first:?}");
    assert_eq!(first, VALUES);
    let normal = HeldProcess::new(1.0, Normal::new(0.0, 1.0).unwrap()).unwrap().seed(2020);
    println!("{:?}", normal.held(0, 0));
    assert_eq!(normal.held(0, 0), NORMAL);
}

/// `process(0.1, 3).held(7, k)` for k = 0, 1, 2: uniform on (0, 1), seed 2020, member 3, stream 7.
const VALUES: [f64; 3] = [0.103_795_216_577_002_19, 0.431_029_157_139_371_2, 0.608_054_536_635_636_7];
/// `held(0, 0)` of a standard normal process: seed 2020, member 0, stream 0.
const NORMAL: f64 = 0.152_717_869_330_872_47;

/// Mean and variance of the values, and no correlation between neighbouring numbers, streams or members.
#[test]
fn uniform_and_uncorrelated() {
    let p = process(1.0, 0);
    let n = 200_000u64;
    let x: Vec<f64> = (0..n).map(|k| p.held(0, k) - 0.5).collect();
    let y: Vec<f64> = (0..n).map(|k| p.held(1, k) - 0.5).collect();
    let z: Vec<f64> = (0..n).map(|m| process(1.0, m).held(0, 0) - 0.5).collect();
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / a.len() as f64;
    let one = vec![1.0; n as usize];
    let bound = 4.0 / (n as f64).sqrt();
    for a in [&x, &y, &z] {
        assert!(product(a, &one).abs() < bound * (1f64 / 12.0).sqrt());
        assert!((product(a, a) - 1.0 / 12.0).abs() < bound / 12.0);
        assert!(product(&a[1..], a).abs() < bound / 12.0);
    }
    assert!(product(&x, &y).abs() < bound / 12.0 && product(&x, &z).abs() < bound / 12.0);
}

fn ring() -> Ring {
    Ring::new(&RingSet { motor_torque: 8.0, ..RingSet::set_a(4, 1000.0) }.params().unwrap())
        .unwrap()
        .with_frame(Frame::Rigid)
}

/// Values shared by all meshes, and values per mesh relative to C_g: the drives contain the stated sums.
#[test]
fn shared_and_per_mesh() {
    let ring = ring();
    let slots: Vec<usize> = (0..4).map(|i| ring.slot(&format!("mesh damping {i}")).unwrap()).collect();
    let mut u = vec![0.0; ring.drives()];
    let mut damping = |model: &dyn Model, t: f64| {
        model.drive(t, Side::After, &mut u);
        slots.iter().map(|s| u[*s]).collect::<Vec<f64>>()
    };
    let c = damping(&ring, 0.0);
    let p = process(1e-3, 0);
    let together = Noisy::new(ring.clone())
        .add(&slots.iter().map(|slot| (*slot, 500.0)).collect::<Vec<_>>(), &p)
        .unwrap();
    assert!(
        damping(&together, 2.5e-3).iter().zip(&c).all(|(d, c)| (d - c - 500.0 * p.held(0, 2)).abs() < 1e-9)
    );
    let relative = slots
        .iter()
        .zip(&c)
        .fold(Noisy::new(ring), |relative, (slot, c)| relative.add(&[(*slot, *c)], &p).unwrap());
    for (i, d) in damping(&relative, 0.5e-3).iter().enumerate() {
        assert!((d / (c[i] * (1.0 + p.held(i as u64, 0))) - 1.0).abs() < 1e-14);
    }
}

/// The random torque and the random clearance of Yao 2020: held processes on other slots.
#[test]
fn random_torque_and_clearance() {
    let ring = ring();
    let torque = Noisy::new(ring.clone())
        .add(&[(ring.slot("motor torque").unwrap(), 4.0)], &process(5e-3, 0))
        .unwrap();
    let gaps: Vec<[usize; 2]> = (0..4).map(|i| ring.clearance_slots(i).unwrap()).collect();
    let clearance = gaps.iter().fold(Noisy::new(ring.clone()), |held, [lower, upper]| {
        held.add(&[(*lower, -1e-5), (*upper, 1e-5)], &process(5e-3, 0)).unwrap()
    });
    let mut u = vec![0.0; ring.drives()];
    clearance.drive(0.0, Side::After, &mut u);
    for (mesh, [lower, upper]) in gaps.iter().enumerate() {
        let b = 2.65e-5 + 1e-5 * process(5e-3, 0).held(mesh as u64, 0);
        assert_eq!((u[*lower], u[*upper]), (-b, b));
    }
    let start = State::at_rest(9);
    let ends = [
        Dop853::new().rtol(1e-10).end(&ring, &start, 0.03).unwrap(),
        Dop853::new().rtol(1e-10).end(&torque, &start, 0.03).unwrap(),
        Dop853::new().rtol(1e-10).end(&clearance, &start, 0.03).unwrap(),
    ];
    assert!((ends[1].q[0] - ends[0].q[0]).abs() > 1e-6 && (ends[2].q[0] - ends[0].q[0]).abs() > 1e-9);
    // A clearance that jumps below the deflection puts a mesh on its flank at once. The run still agrees with
    // one of tighter tolerance.
    let fine = Dop853::new()
        .rtol(1e-12)
        .atol_each(&[vec![1e-17; 9], vec![1e-13; 9]].concat())
        .end(&clearance, &start, 0.03)
        .unwrap();
    assert!((fine.q[0] - ends[2].q[0]).abs() < 1e-8 * fine.q[0].abs());
}

/// After 10⁹ hold intervals the value and the next edge still belong to the right interval, on both sides.
#[test]
fn far_out() {
    for hold in [1e-4, 0.1, 3.7] {
        let held = Noisy::new(Damped).add(&[(0, 1.0)], &process(hold, 1)).unwrap();
        let p = process(hold, 1);
        for k in [1_000_000_000u64, 1_000_000_007, 1_234_567_891] {
            let t = k as f64 * hold;
            assert_eq!(p.path(0).at(t, Side::After), p.held(0, k));
            assert_eq!(p.path(0).at(t, Side::Before), p.held(0, k - 1));
            assert_eq!(p.path(0).at((k as f64 + 0.5) * hold, Side::Before), p.held(0, k));
            assert_eq!(held.next_edge(t), Some((k + 1) as f64 * hold));
            assert_eq!(held.next_edge(t.next_down()), Some(t));
        }
    }
}

/// Values held for 1e-9 of the run would take 1e9 steps: the run is refused before it begins.
#[test]
fn edges_without_end_are_refused() {
    let noisy = |hold: f64| Noisy::new(Damped).add(&[(0, 0.2)], &process(hold, 0)).unwrap();
    let start = State::new(0.0, &[1.0], &[0.0]);
    for error in [
        Dop853::new().end(&noisy(1e-9), &start, 1.0).unwrap_err(),
        Rk45::new().end(&noisy(1e-6), &start, 1000.0).unwrap_err(),
        Rk4::new(0.1).max_steps(1000).end(&noisy(1e-3), &start, 10.0).unwrap_err(),
    ] {
        assert!(matches!(error, IntegrateError::TooManyEdges { .. }), "{error}");
    }
    assert!(Rk4::new(0.1).max_steps(20_000).end(&noisy(1e-3), &start, 10.0).is_ok());
    // The first edge lies beside the start, and the next ones far away.
    let beside = State { t: 1.0 - 1e-12, ..start };
    assert!(Rk4::new(0.1).max_steps(1000).end(&noisy(1.0), &beside, 10.0).is_ok());
}
