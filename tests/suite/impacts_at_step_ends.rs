//! Impacts and crossings within rounding of the end of a step, of a drive edge or of the start of a run are reported
//! once, and the derivative jumps once.

use crate::api::*;
use gear_dynamics::contact::{Deflection, PieceChoice};
use gear_dynamics::excitation::RectangularWave;
use gear_dynamics::model::{Drives, Scalar, Size};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::ControlFlow;

/// A ball on a table at A sin ωt with the restitution e, under the gravity 1. `edge`: a phase at which each period
/// has an announced edge, where nothing jumps.
struct Table {
    amplitude: f64,
    frequency: f64,
    restitution: f64,
    edge: Option<f64>,
}

impl Model for Table {
    fn dof(&self) -> usize {
        1
    }
    fn drives(&self) -> usize {
        2
    }
    fn drive(&self, t: f64, _: Side, u: &mut [f64]) {
        let (sin, cos) = (self.frequency * t).sin_cos();
        u.copy_from_slice(&[self.amplitude * sin, self.amplitude * self.frequency * cos]);
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        let (edge, period) = (self.edge?, self.period());
        let first = ((t - edge) / period).floor() - 1.0;
        (0..4).map(|k| edge + (first + f64::from(k)) * period).find(|edge| *edge > t * (1.0 + 1e-14))
    }
    fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = -1.0;
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        out[0] = floor(q[0], v[0], [u[0], u[1]]);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { stops: &[[true, false]], ..Offers::default() }
    }
    fn impact(&self, _: usize, _: Piece, u: &[f64], _: &[f64], v: &mut [f64]) {
        v[0] = u[1] - self.restitution * (v[0] - u[1]);
    }
}
impl Periodic for Table {
    fn period(&self) -> f64 {
        TAU / self.frequency
    }
}

fn floor(deflection: f64, rate: f64, [lower, lower_rate]: [f64; 2]) -> Contact {
    Contact { deflection, rate, lower, lower_rate, upper: f64::INFINITY, ..Contact::default() }
}

impl Table {
    /// At rest, without loss.
    fn rest() -> Self {
        Table { amplitude: 0.0, frequency: 1.0, restitution: 1.0, edge: None }
    }
    /// One impact a period, at the phase φ with cos φ = π (1 - e)/((1 + e) Γ), Γ = A ω². Returns the table, the
    /// instant of the impact and the state at the top of the flight.
    fn of_one_impact() -> (Self, f64, State) {
        let (frequency, restitution, gamma) = (2.0f64, 0.5, 1.3);
        let amplitude = gamma / frequency.powi(2);
        let at = (PI * (1.0 - restitution) / (1.0 + restitution) / gamma).acos() / frequency;
        let half = PI / frequency;
        let top = amplitude * (frequency * at).sin() + 0.5 * half * half;
        let table = Table { amplitude, frequency, restitution, edge: None };
        (table, at, State::new(at + half, &[top], &[0.0]))
    }
}

fn solvers(step: f64) -> Vec<(&'static str, Box<dyn Integrator>)> {
    vec![
        ("Dop853", Box::new(Dop853::new())),
        ("Dop853 of steps", Box::new(Dop853::new().first_step(step).max_step(step))),
        ("Rk45 of steps", Box::new(Rk45::new().first_step(step).max_step(step))),
        ("Rodas", Box::new(Rodas::new())),
        ("Rk4", Box::new(Rk4::new(step))),
    ]
}

fn count(solver: &dyn Integrator, model: &Table, start: &State, end: f64) -> (State, [u64; 2]) {
    let mut impacts = Impacts::new(model);
    let finish = solver.run(model, start, end, &mut impacts).unwrap();
    (finish.state, [finish.stats.crossings, impacts.of(0).count() as u64])
}

/// From (h²/2, 0) the ball meets the floor at h, 3h, 5h ..: whole steps of h/16 and h/10.
#[test]
fn impacts_at_whole_steps_are_counted() {
    let table = Table::rest();
    for half in [FRAC_PI_2, 0.7, 1.0, 0.3, 1.1] {
        let (start, end) = (State::new(0.0, &[0.5 * half * half], &[0.0]), 100.0 * half + 0.01);
        for step in [half / 16.0, half / 10.0] {
            for (name, solver) in solvers(step) {
                let (state, counts) = count(&*solver, &table, &start, end);
                assert_eq!(counts, [50; 2], "{name}, h = {half}, step {step}");
                assert!((state.q[0] - 0.5 * half * half + 5e-5).abs() < 1e-11, "{name}, h = {half}");
            }
        }
        // Runs that end at each multiple of h, each from the end of the one before.
        let (mut state, mut crossings) = (start, 0);
        for k in 1..=20 {
            let mut nothing = |_: &mut Step<'_>| ControlFlow::Continue(());
            let end = f64::from(k) * half;
            let finish = Dop853::new().run(&table, &state, end, &mut nothing).unwrap();
            crossings += finish.stats.crossings;
            state = finish.state;
        }
        assert_eq!(crossings, 10, "h = {half}");
    }
}

/// An edge of the drives that is announced within a few last bits of the impact changes neither the count nor the
/// motion nor the multipliers, whose product is e².
#[test]
fn impacts_beside_announced_edges_are_counted() {
    let (bare, at, top) = Table::of_one_impact();
    let plain = Shooting::new().solve(&bare, std::slice::from_ref(&top)).unwrap();
    let expected = plain.multipliers().values();
    assert!((expected.iter().product::<num_complex::Complex64>().re - 0.25).abs() < 1e-6);
    for k in [0, 1, -1, 3, -3, 7, 40] {
        let (table, ..) = Table::of_one_impact();
        let table = Table { edge: Some(at + f64::from(k) * f64::EPSILON), ..table };
        for (name, solver) in solvers(table.period() / 64.0) {
            let (state, counts) = count(&*solver, &table, &top, top.t + 50.0 * table.period());
            assert_eq!(counts, [50; 2], "{name}, {k}");
            assert!((state.q[0] - top.q[0]).abs() < 1e-9, "{name}, {k}");
        }
        let orbit = Shooting::new().solve(&table, std::slice::from_ref(&top)).unwrap();
        assert_eq!(orbit.crossing_count(), 1, "{k}");
        let found = orbit.multipliers().values();
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).norm() < 1e-5), "{k}: {found:?}");
    }
}

/// A floor with damping in contact, under a gravity that jumps from 2 to 1 at t = 1.
#[derive(Clone, Debug, PartialEq)]
struct Falling {
    gravity: Wave,
    law: Backlash,
}

impl Shape for Falling {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 1, contacts: 1, constants: 2, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        ["speed", "stiffness"].map(|name| Channel::new(name, "1")).into()
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u[0] = self.gravity.value(angle, side);
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        self.gravity.next_edge(angle)
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let (lower, upper, [stiffness]) = (S::from(0.0), S::from(f64::INFINITY), u.constants());
        let at = Deflection { d: q[0], rate: v[0], lower, upper };
        let force = stiffness * law.force(i, &self.law, at) + law.touch(i, at) * v[0] * 5.0;
        Contact { deflection: q[0], rate: v[0], lower, upper, force, ..Contact::default() }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [gravity] = u.waves();
        a[0] = -gravity - self.contact(law, 0, u, q, v).force;
    }
}

/// The ball falls from 1 + δ and touches the floor beside the jump at t = 1. The derivative is continuous in δ: it is
/// compared with that of δ = ±1e-6, far from the jump.
#[test]
fn a_contact_beside_a_jump_of_the_drives_changes_the_derivative_once() {
    let gravity = Wave::new(RectangularWave::new(1.0, 2.0, 0.5).unwrap());
    let shape = Falling { gravity, law: Backlash::new(0.0).unwrap() };
    let ball = Machine::of_constants(shape, &[("speed", FRAC_PI_2), ("stiffness", 50.0)]).unwrap();
    let start = |off: f64| State::new(0.0, &[1.0 + off], &[0.0]);
    for method in [None, Some(FlowMethod::Dop853)] {
        let set = |variation: Variation| match method {
            Some(method) => variation.flow_method(method),
            None => variation,
        };
        let run = |off: f64| set(Variation::new()).run(&ball, &start(off), 1.9).unwrap();
        let expected = (run(1e-6).matrix + run(-1e-6).matrix) * 0.5;
        for off in [1e-15, 3e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9] {
            for off in [off, -off] {
                let found = run(off);
                assert!((found.matrix - &expected).abs().max() < 1e-4, "{method:?} {off:e}");
                assert_eq!(found.crossings, 2, "{method:?} {off:e}");
            }
        }
    }
    for off in [0.0, 1e-15, 3e-15, 1e-13, 1e-11, -1e-11, -1e-13] {
        let mut nothing = |_: &mut Step<'_>| ControlFlow::Continue(());
        for solver in [&Taylor::new() as &dyn Integrator, &Dop853::new(), &Rk45::new(), &Rk4::new(1e-3)] {
            let finish = solver.run(&ball, &start(off), 1.9, &mut nothing).unwrap();
            assert_eq!(finish.stats.crossings, 2, "{off:e}");
        }
    }
}

/// A ball with e = 0.7 falls from 1 + δ onto a rigid floor under the same gravity: after an impact 6e-14 to 1e-12
/// behind the jump all stages of the next step have the gravity behind it.
#[test]
fn a_step_that_begins_behind_a_jump_has_the_drives_behind_it() {
    struct Ball(Wave);
    impl Model for Ball {
        fn dof(&self) -> usize {
            1
        }
        fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
            u[0] = self.0.value(FRAC_PI_2 * t, side);
        }
        fn next_edge(&self, t: f64) -> Option<f64> {
            self.0.next_edge(FRAC_PI_2 * t).map(|angle| angle / FRAC_PI_2)
        }
        fn accel(&self, u: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = -u[0];
        }
        fn contacts(&self) -> usize {
            1
        }
        fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
            out[0] = floor(q[0], v[0], [0.0; 2]);
        }
        fn offers(&self) -> Offers<'_> {
            Offers { stops: &[[true, false]], ..Offers::default() }
        }
        fn impact(&self, _: usize, _: Piece, _: &[f64], _: &[f64], v: &mut [f64]) {
            v[0] *= -0.7;
        }
    }
    let ball = Ball(Wave::new(RectangularWave::new(1.0, 2.0, 0.5).unwrap()));
    for off in [0.0, 1e-14, 6e-14, 1e-13, 1e-12] {
        for (name, solver) in solvers(0.1) {
            let end = solver.end(&ball, &State::new(0.0, &[1.0 + off], &[0.0]), 1.5).unwrap();
            // 1.4 · 0.5 - 0.5²/2 and 1.4 - 0.5
            assert!(
                (end.q[0] - 0.575).abs() < 1e-9 && (end.v[0] - 0.9).abs() < 1e-9,
                "{name} {off:e} {end:?}"
            );
        }
    }
}

/// A mass at rest at 0 that a floor reaches, whose edge is t - 1: q = s - sin(10 s)/10, s = t - 1.
#[test]
fn a_mass_at_rest_is_met_by_a_moving_edge() {
    struct Mass;
    impl Model for Mass {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = 100.0 * (u[0] - 1.0 - q[0]).max(0.0);
        }
        fn contacts(&self) -> usize {
            1
        }
        fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
            out[0] = floor(q[0], v[0], [u[0] - 1.0, 1.0]);
        }
    }
    for (name, solver) in solvers(1e-2) {
        let end = solver.end(&Mass, &State::at_rest(1), 1.2).unwrap();
        assert!((end.q[0] - (0.2 - 0.1 * 2f64.sin())).abs() < 1e-6, "{name}: {}", end.q[0]);
    }
}

/// The guess of the first step is below the resolution of a late time: q'' = -1e9 q.
#[test]
fn the_first_step_at_a_late_time_is_no_shorter_than_its_resolution() {
    let fast = from_fn(1, |_, q, _, a| a[0] = -1e9 * q[0]).unwrap();
    let solvers: [&dyn Integrator; 3] = [&Dop853::new(), &Rk45::new(), &Rodas::new()];
    for t in [1e5, 1e6, 1e7, 1e8] {
        for solver in solvers {
            let end = solver.end(&fast, &State::new(t, &[1e-3], &[0.0]), t + 1e-3).unwrap();
            // The rounding of the two times is part of the distance between them.
            let expected = 1e-3 * (1e9f64.sqrt() * (end.t - t)).cos();
            assert!((end.q[0] - expected).abs() < 2e-8, "{t:e} {} {expected}", end.q[0]);
        }
    }
}
