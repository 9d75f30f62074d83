//! Gaps that are wide beside the motion: only one flank is ever touched, and the other one must not be felt.

use crate::api::*;
use crate::common::random::Random;
use gear_dynamics::models::Oscillator;
use gear_dynamics::ode::IntegrateError;
use gear_dynamics::trains::{Body, MeshPart, Parts, ShaftPart};
use gear_dynamics::{Dop853, Rk45, Taylor};
use std::f64::consts::TAU;

/// The motion about the upper edge with a half backlash of 1 and of b is the same, as far as the deflection of size b is
/// resolved. Contact loss is found at every width.
#[test]
fn contact_loss_is_found_in_gaps_of_every_width() {
    let mut random = Random(8);
    for case in 0..40 {
        let given = [
            ("speed", 0.4 + 0.8 * random.next()),
            ("damping", 0.1),
            ("mesh stiffness", 1.0),
            ("mean force", 0.1 + 0.1 * random.next()),
            ("force", 0.15 + 0.2 * random.next()),
        ];
        let model = |b: f64| Oscillator::new(&[&given[..], &[("half backlash", b)]].concat()).unwrap();
        let start = |b: f64| State::new(0.0, &[b + 0.2], &[0.0]);
        let t_end = 3.0 * TAU / given[0].1;
        let fine = |b: f64| Dop853::new().rtol(1e-15).atol(1e-12).end(&model(b), &start(b), t_end).unwrap();
        let right = fine(10.0);
        for b in [1e3, 1e5, 1e7, 1e8] {
            let ends = [
                ("Dop853", Dop853::new().rtol(1e-15).atol(1e-9).end(&model(b), &start(b), t_end)),
                ("Rk45", Rk45::new().rtol(1e-15).atol(1e-9).end(&model(b), &start(b), t_end)),
                ("Rk4", Rk4::new(1e-2).end(&model(b), &start(b), t_end)),
                ("Taylor", Taylor::new().rtol(1e-15).atol(1e-12).end(&model(b), &start(b), t_end)),
            ];
            for (name, end) in ends {
                let end = end.unwrap();
                let off = (end.q[0] - b - (right.q[0] - 10.0)).abs().max((end.v[0] - right.v[0]).abs());
                // The tolerances, and the rounding of a deflection of size b in up to 5000 steps: √5000 ε b, which
                // the motion enlarges.
                assert!(off < 1e-6 + 512.0 * f64::EPSILON * b, "case {case}, {name}, b = {b:e}: {off:e}");
            }
        }
    }
}

/// A motion that starts far inside the flank and settles on a small ripple loses contact in it as in a narrow gap.
#[test]
fn contact_loss_of_a_motion_that_has_settled_is_found() {
    let given =
        [("speed", 0.7), ("damping", 2.5), ("mesh stiffness", 1.0), ("mean force", 1e-7), ("force", 4e-7)];
    let model = |b: f64| Oscillator::new(&[&given[..], &[("half backlash", b)]].concat()).unwrap();
    let t_end = 12.0 * TAU / 0.7;
    let right =
        Dop853::new().rtol(1e-15).atol(1e-14).end(&model(1e-3), &State::new(0.0, &[1.001], &[0.0]), t_end);
    let right = right.unwrap().q[0] - 1e-3;
    let b = 1e4;
    let start = State::new(0.0, &[b + 1.0], &[0.0]);
    for (name, end) in [
        ("Dop853", Dop853::new().rtol(1e-15).atol(1e-13).end(&model(b), &start, t_end)),
        ("Rk4", Rk4::new(1e-2).end(&model(b), &start, t_end)),
        ("Taylor", Taylor::new().rtol(1e-15).atol(1e-13).end(&model(b), &start, t_end)),
    ] {
        let off = (end.unwrap().q[0] - b - right).abs();
        assert!(off < 2e-8, "{name}: {off:e} beside {right:e}");
    }
}

/// A tolerance far below the rounding of a deflection of 6e5 kept steps at 1e-4 of their length.
#[test]
fn a_tolerance_below_the_rounding_of_the_coordinates_is_refused() {
    let given =
        [("speed", 0.6), ("damping", 0.1), ("mesh stiffness", 1.0), ("mean force", 0.7), ("force", 0.01)];
    let b = 6e5;
    let model = Oscillator::new(&[&given[..], &[("half backlash", b)]].concat()).unwrap();
    let start = State::new(0.0, &[b + 0.7], &[0.0]);
    let run = |atol: f64| Dop853::new().rtol(1e-13).atol(atol).end(&model, &start, 20.0 * TAU / 0.6);
    let Err(IntegrateError::BelowRounding { t, velocity: 0, rounding, tolerance }) = run(1e-16) else {
        panic!("{:?}", run(1e-16));
    };
    assert!(t < 1.0 && rounding > 0.5 * tolerance && tolerance < 1e-14, "{t} {rounding:e} {tolerance:e}");
    // A tolerance above ε b.
    let end = run(1e-9).unwrap();
    let exact = 0.7 + 0.01 * (1.0f64 - 0.36).hypot(0.06).recip();
    assert!((end.q[0] - b - 0.7).abs() < exact - 0.7 + 1e-6, "{end:?}");
}

/// A motion on the upper flank of a gap far wider than it, settled from `offset` amplitudes beside its mean, and its
/// distance from the closed form as a share of its range.
fn settled(
    [b, load, pulse, damping, speed]: [f64; 5],
    offset: f64,
    tolerance: f64,
) -> (gear_dynamics::analysis::Steady, f64) {
    let model = Oscillator::new(&[
        ("speed", speed),
        ("damping", damping),
        ("mesh stiffness", 1.0),
        ("mean force", load),
        ("force", pulse),
        ("half backlash", b),
    ])
    .unwrap();
    let [real, imaginary] = [1.0 - speed * speed, damping * speed];
    let response = [real, -imaginary].map(|part| pulse * part / real.mul_add(real, imaginary * imaginary));
    let size = response[0].hypot(response[1]);
    let start = State::new(0.0, &[b + load + offset * size], &[0.0]);
    let settle = Settle::new().tolerance(tolerance).max_periods(1000).max_period_multiple(1);
    let steady = settle.run(&Dop853::new().rtol(1e-13).atol(1e-14 * size), &model, &start).unwrap();
    let (sin, cos) = (speed * steady.state.t).sin_cos();
    let turn = [response[0] * cos - response[1] * sin, -speed * (response[0] * sin + response[1] * cos)];
    let off =
        [(steady.state.q[0] - b - load - turn[0]) / size, (steady.state.v[0] - turn[1]) / (speed * size)];
    let off = 0.5 * off[0].abs().max(off[1].abs());
    (steady, off)
}

/// Settling in a gap of 7e5 motions: the change reaches the tolerance, or the rounding of the coordinate, and
/// does not end at many times that rounding. The estimate of the error says so.
#[test]
fn settling_in_a_wide_gap_goes_on_to_its_rounding() {
    for tolerance in [4e-10, 4e-13] {
        let (steady, off) = settled([42.102_984_254_649_01, 1.3e-3, 5.67e-5, 0.217, 0.937], -0.1, tolerance);
        assert!(off < 1e-9 && off < 2.0 * steady.error() && steady.error() < 1e-6, "{off:e} {steady:?}");
        assert_eq!(steady.change <= tolerance, tolerance == 4e-10, "{steady:?}");
        assert!(steady.periods < 60, "{steady:?}");
    }
}

/// Near its resonance a motion decays by 0.92 to 0.97 a period, and its change swings while it shrinks.
#[test]
fn settling_in_a_wide_gap_goes_on_while_a_change_that_swings_shrinks() {
    for (numbers, offset, periods) in [
        ([564.559, 0.3073, 2.6585e-3, 0.027_774, 1.038_67], 0.161, 300),
        ([13_519.93, 0.141, 8.1965e-3, 0.020_008, 1.138_65], -0.398, 400),
    ] {
        let (steady, off) = settled(numbers, offset, 2e-10);
        assert!(off < 1e-8 && steady.periods < periods, "{off:e} {steady:?}");
    }
}

/// The motion about the flank is the same at every half backlash b, as far as a deflection of size b is resolved. Settling
/// does not end in the transient, and says how far it is.
#[test]
fn settling_at_every_width_of_the_gap() {
    let of = |b: f64, solver: &dyn Integrator| {
        let model = Oscillator::new(&[
            ("speed", 0.5),
            ("damping", 0.05),
            ("mesh stiffness", 1.0),
            ("mean force", 0.06),
            ("force", 0.02),
            ("half backlash", b),
        ]);
        let steady =
            Settle::new().run(solver, &model.unwrap(), &State::new(0.0, &[b + 0.1], &[0.0])).unwrap();
        let [real, imaginary] = [1.0 - 0.25, 0.05 * 0.5];
        let size = 0.02 / f64::hypot(real, imaginary);
        let lag = f64::atan2(imaginary, real);
        let turn = 0.5 * steady.state.t - lag;
        let exact = [0.06 + size * turn.cos(), -0.5 * size * turn.sin()];
        let off = [steady.state.q[0] - b - exact[0], steady.state.v[0] - exact[1]];
        (off[0].abs().max(off[1].abs()) / (2.0 * size), steady)
    };
    for b in [1e2, 1e3, 1e4, 1e5, 1e6, 1e7] {
        let solvers: [(&dyn Integrator, f64); 2] = [(&Taylor::new(), 1e-8), (&Dop853::new(), 1e-6)];
        for (solver, most) in solvers {
            let (off, steady) = of(b, solver);
            // The rounding of a deflection of size b in a period adds up over some four periods.
            let allowed = 1e-9 + 10.0 * f64::EPSILON * b / 0.05;
            assert!(off < most && off < steady.error() + allowed, "b = {b:e}: {off:e} {steady:?}");
        }
    }
}

/// Shafts wound up by a load, and a stiffness that hardly varies: the range of the motor is 1e-8 of its angle. The settled
/// state lies on the orbit of shooting, within a few of its errors.
#[test]
fn wound_shafts_settle_on_their_orbit() {
    for (half_backlash, shaft, torque, ripple) in
        [(2e-4, 1e3, 50.0, 1e-3), (1e-3, 300.0, 100.0, 1e-3), (2e-5, 8e3, 50.0, 0.1)]
    {
        let stiffness = Wave::new(Fourier::new(3e8, &[[ripple * 3e8, 0.0]]).unwrap());
        let mesh =
            MeshPart::external([20, 50], [0.04, 0.1], stiffness).damping(2e3).half_backlash(half_backlash);
        let mut parts = Parts::new();
        parts.body("motor", Body::new(0.02)).body("pinion", Body::new(1e-3)).body("wheel", Body::new(0.02));
        parts.body("load", Body::new(0.3));
        parts.shaft("input", "motor", "pinion", ShaftPart::new(shaft).damping(0.2));
        parts.mesh("mesh", "pinion", "wheel", mesh);
        parts.shaft("output", "wheel", "load", ShaftPart::new(2.0 * shaft).damping(0.5));
        parts.torque("drive", "motor", torque).load("load");
        let train = parts.build("motor", 100.0).unwrap();
        let settle = Settle::new().max_periods(4000);
        let orbit = Shooting::new().solve(&train, None).unwrap();
        for solver in [&Taylor::new() as &dyn Integrator, &Dop853::new().atol(1e-14)] {
            let steady = settle.run(solver, &train, None).unwrap();
            let (exact, range) = (&orbit.states()[0], orbit.range());
            let n = exact.q.len();
            let parts = (0..n).map(|i| (steady.state.q[i] - exact.q[i]).abs() / range[i]);
            let off = parts.fold(0.0, f64::max);
            println!(
                "{half_backlash} {off:e} {} {:e} {range:?} {:?}",
                steady.periods,
                steady.error(),
                exact.q
            );
            assert!(off < 3.0 * steady.error() + 1e-8, "{off:e} {}", steady.error());
        }
    }
}

/// A plain formula far from 0: shooting finds the orbit, or says that it did not converge. A spring that acts far away only
/// still holds the coordinate.
#[test]
fn formulas_far_from_zero() {
    let cubic = |c: f64| {
        let model = from_fn(1, move |t: f64, q, v, a| {
            let x: f64 = q[0] - c;
            a[0] = 0.06 + 0.03 * (0.9 * t).cos() - 0.1 * v[0] - x - 0.5 * x.powi(3);
        });
        model.unwrap().with_period(TAU / 0.9).unwrap()
    };
    let right = Shooting::new().solve(&cubic(0.0), &State::new(0.0, &[0.1], &[0.0])).unwrap();
    let right = &right.states()[0];
    let mut found = 0;
    for c in [1e2, 1e3, 1e4, 1e5, 3e5, 1e6, 3e6, 1e7] {
        match Shooting::new().solve(&cubic(c), &State::new(0.0, &[c + 0.1], &[0.0])) {
            Ok(orbit) => {
                let state = &orbit.states()[0];
                let off = (state.q[0] - c - right.q[0]).abs().max((state.v[0] - right.v[0]).abs());
                assert!(off < 1e-8 + 1e-15 * c + orbit.accuracy(), "c = {c:e}: {off:e} {}", orbit.accuracy());
                found += 1;
            }
            Err(error) => assert!(matches!(error, ShootingError::NotConverged { .. }), "c = {c:e}: {error}"),
        }
    }
    assert!(found >= 5, "{found}");
    let flank = from_fn(1, |t: f64, q, v, a| {
        a[0] = 0.06 + 0.02 * (0.5 * t).cos() - 0.05 * v[0] - (q[0] - 1e5).max(0.0);
    });
    let flank = flank.unwrap().with_period(2.0 * TAU).unwrap();
    let steady = Settle::new().run(&Dop853::new(), &flank, &State::new(0.0, &[1e5 + 0.1], &[0.0])).unwrap();
    let response = 0.02 / f64::hypot(0.75, 0.025);
    assert!((steady.state.q[0] - 1e5 - 0.06 - response * f64::atan2(0.025, 0.75).cos()).abs() < 1e-7);
}

/// q'' = F - 10 f(d) with d = q - e sin 20 φ, and a gap from `lower` to `upper`.
#[derive(PartialEq)]
struct FarEdge {
    law: Backlash,
    edges: [f64; 2],
}

impl Shape for FarEdge {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 2, contacts: 1, constants: 3, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        ["speed", "load", "error"].map(|name| Channel::new(name, "1")).into()
    }
    fn waves<A: Angle>(&self, angle: A, _: Side, u: &mut [A::Number]) {
        let (sin, cos) = (angle.number() * 20.0).sin_cos();
        u.copy_from_slice(&[sin, cos * 20.0]);
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let ([wave, slope], [_, error]) = (u.waves(), u.constants());
        let (d, rate) = (q[0] - error * wave, v[0] - error * slope * u.speed());
        let [lower, upper] = self.edges.map(S::from);
        let force = law.force(i, &self.law, Deflection { d, rate, lower, upper }) * 10.0;
        Contact { deflection: d, rate, lower, upper, force, ..Contact::default() }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [load, ..] = u.constants::<2>();
        a[0] = load - self.contact(law, 0, u, q, v).force;
    }
}

fn far_edge(edges: [f64; 2], load: f64, error: f64) -> Machine<FarEdge> {
    let constants = [("speed", 1.0), ("load", load), ("error", error)];
    Machine::of_constants(FarEdge { law: Backlash::new(0.0).unwrap(), edges }, &constants).unwrap()
}

/// A start at rest on the flank of a wide gap is on the flank: the motion is a quarter of a vibration, then a straight
/// line through the gap.
#[test]
fn starts_on_a_flank_of_a_wide_gap() {
    let solvers: [&dyn Integrator; 4] =
        [&Taylor::new(), &Dop853::new().rtol(1e-10), &Rk45::new().rtol(1e-10), &Rk4::new(1e-3)];
    for far in [1e2, 1e4, 1e6, 1e8, 1e10, 1e12, 1e299, 1e301] {
        for (sign, edges) in [(1.0, [-far, 1.0]), (-1.0, [-1.0, far])] {
            for depth in [1e-8, 1e-6, 5e-3, 0.2] {
                let machine = far_edge(edges, 0.0, 0.0);
                let start = State::new(0.0, &[sign * (1.0 + depth)], &[0.0]);
                let (omega, t_end) = (10f64.sqrt(), 4.0);
                let exact = 1.0 - depth * omega * (t_end - 0.25 * TAU / omega);
                for solver in solvers {
                    let mut rattle = Rattle::new(&machine);
                    let run = solver.run(&machine, &start, t_end, &mut rattle).unwrap();
                    let off = (sign * run.state.q[0] - exact).abs();
                    assert!(off < 1e-8, "{far:e}, {depth}: {off:e}");
                    assert_eq!(run.stats.crossings, 1, "{far:e}, {depth}");
                }
            }
        }
    }
}

/// A transmission error that is much faster than the free flight beside a wide gap: no contact is invented. The flight is a
/// parabola.
#[test]
fn fast_transmission_errors_in_a_wide_gap() {
    for (edges, load, start) in [
        ([-6e5, 0.6], 0.15, [-0.94, -0.36]),
        ([-0.6, 6e7], -0.15, [0.94, 0.36]),
        ([-6e9, 0.6], 0.15, [-0.94, -0.36]),
    ] {
        for error in [0.003, 0.03, 0.1] {
            let machine = far_edge(edges, load, error);
            let start = State::new(0.0, &start[..1], &start[1..]);
            let exact = start.q[0] + 6.0 * start.v[0] + 18.0 * load;
            for rtol in [1e-4, 1e-5, 1e-7, 1e-9, 1e-12] {
                let run =
                    Taylor::new().rtol(rtol).run(&machine, &start, 6.0, &mut Rattle::new(&machine)).unwrap();
                assert_eq!(run.stats.crossings, 0, "{edges:?}, {error}, {rtol:e}");
                assert!((run.state.q[0] - exact).abs() < 10.0 * rtol, "{edges:?}, {error}, {rtol:e}");
            }
        }
    }
}
