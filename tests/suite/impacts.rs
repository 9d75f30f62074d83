//! Rigid stops with restitution: impacts in closed form, the derivative of impacting motions, orbits and their bifurcations.

use crate::data::read;
use gear_dynamics::*;
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

/// x'' + c x' + k x = A cos ωt, x <= d.
struct Oscillator {
    k: f64,
    c: f64,
    amplitude: f64,
    omega: f64,
    stop: f64,
    restitution: Restitution,
}

impl Oscillator {
    fn new(c: f64, omega: f64, amplitude: f64) -> Self {
        Oscillator { k: 1.0, c, amplitude, omega, stop: 1.0, restitution: Restitution::new(0.8).unwrap() }
    }
    /// exp of the free motion over a time t.
    fn free(&self, t: f64) -> [[f64; 2]; 2] {
        let beta = (self.k - 0.25 * self.c * self.c).sqrt();
        let (decay, sine, cosine) = ((-0.5 * self.c * t).exp(), (beta * t).sin() / beta, (beta * t).cos());
        let half = 0.5 * self.c * sine;
        [[decay * (cosine + half), decay * sine], [-decay * self.k * sine, decay * (cosine - half)]]
    }
    /// The orbit of one impact in n periods with velocity v behind it: when, and its amplitude of excitation, in closed form.
    fn closed(&self, n: usize, v: f64) -> (f64, f64) {
        let [[a, b], [c, d]] = self.free(n as f64 * self.period());
        let (a, d) = (a - 1.0, d - 1.0);
        let jump = -v * (1.0 + 1.0 / self.restitution.coefficient());
        let det = a * d - b * c;
        let h = [-b * jump / det, a * jump / det];
        let (p, q) = (self.stop - h[0], v - h[1]);
        let (elastic, damping) = (self.k - self.omega * self.omega, self.c * self.omega);
        let phase = (-q / self.omega).atan2(p) + damping.atan2(elastic);
        (phase / self.omega, elastic.hypot(damping) * p.hypot(q / self.omega))
    }
    /// A guess: that orbit, some time behind its impact.
    fn guess(&self, n: usize, v: f64) -> State {
        let (t, _) = self.closed(n, v);
        Dop853::new().end(self, &State::new(t, &[self.stop], &[v]), t + 0.37 * self.period()).unwrap()
    }
}

impl Model for Oscillator {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = self.amplitude * (self.omega * u[0]).cos() - self.c * v[0] - self.k * q[0];
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        out[0] = Contact { deflection: q[0], rate: v[0], upper: self.stop, ..Contact::default() };
    }
    fn impact(&self, _: usize, _: Piece, _: &[f64], _: &[f64], v: &mut [f64]) -> bool {
        v[0] = self.restitution.rebound(v[0], 0.0);
        true
    }
}

impl Periodic for Oscillator {
    fn period(&self) -> f64 {
        TAU / self.omega
    }
}

/// x'' = -g above a table at A sin ωt.
struct Ball {
    gravity: f64,
    amplitude: f64,
    omega: f64,
    restitution: Restitution,
}

impl Ball {
    /// Γ = A ω²/g, with g = 1 and ω = 2.
    fn new(gamma: f64, e: f64) -> Self {
        Ball { gravity: 1.0, amplitude: 0.25 * gamma, omega: 2.0, restitution: Restitution::new(e).unwrap() }
    }
    fn table(&self, t: f64) -> (f64, f64) {
        let (sine, cosine) = (self.omega * t).sin_cos();
        (self.amplitude * sine, self.amplitude * self.omega * cosine)
    }
    /// The orbit of one bounce a period, at its top.
    fn top(&self, lower: f64) -> State {
        let gamma = self.amplitude * self.omega * self.omega / self.gravity;
        let t = (lower / gamma).min(1.0).acos() / self.omega;
        let half = 0.5 * self.period();
        State::new(t + half, &[self.table(t).0 + 0.5 * self.gravity * half * half], &[0.0])
    }
}

impl Model for Ball {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
        a[0] = -self.gravity;
    }
    fn drives(&self) -> usize {
        2
    }
    fn drive(&self, t: f64, _: Side, u: &mut [f64]) {
        (u[0], u[1]) = self.table(t);
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        out[0] = Contact { deflection: q[0], rate: v[0], lower: u[0], lower_rate: u[1], ..Contact::default() };
    }
    fn impact(&self, _: usize, _: Piece, u: &[f64], _: &[f64], v: &mut [f64]) -> bool {
        v[0] = self.restitution.rebound(v[0], u[1]);
        true
    }
}

impl Periodic for Ball {
    fn period(&self) -> f64 {
        TAU / self.omega
    }
}

/// A run's impacts: time, velocity before, velocity behind.
fn impacts<M: Model>(solver: &impl Integrator, model: &M, start: &State, end: f64) -> Vec<[f64; 3]> {
    let mut all: Vec<[f64; 3]> = Vec::new();
    let mut last = None;
    let mut watch = |step: &mut Step<'_>| {
        if let (Some(t), Some(impact)) = (last, all.last_mut())
            && t == step.t0()
        {
            impact[2] = step.v0()[0];
        }
        last = None;
        if step.crossings().iter().any(|c| c.rebounds && c.is_impact()) {
            last = Some(step.t1());
            all.push([step.t1(), step.v1()[0], f64::NAN]);
        }
        ControlFlow::Continue(())
    };
    solver.run(model, start, end, &mut watch).unwrap();
    all
}

#[test]
fn a_ball_on_a_floor_keeps_its_times() {
    let tight = Dop853::new().rtol(1e-13).atol(1e-15);
    let ball = Ball { amplitude: 0.0, ..Ball::new(0.0, 0.5) };
    // Dropped from 2: first impact at 2 with speed 2, flights of 2, 1, 1/2, ... behind it.
    let seen = impacts(&tight, &ball, &State::new(0.0, &[2.0], &[0.0]), 5.8);
    assert_eq!(seen.len(), 5);
    for (k, [t, before, behind]) in seen.into_iter().enumerate() {
        let half = 0.5f64.powi(k as i32);
        assert!((t - (6.0 - 4.0 * half)).abs() < 1e-12, "{k}: {t}");
        assert!((before + 2.0 * half).abs() < 1e-12 && (behind - half).abs() < 1e-12, "{k}: {before} {behind}");
    }
    let rk45 = impacts(&Rk45::new().rtol(1e-10).atol(1e-12), &ball, &State::new(0.0, &[2.0], &[0.0]), 5.8);
    let rk4 = impacts(&Rk4::new(0.03), &ball, &State::new(0.0, &[2.0], &[0.0]), 5.8);
    for others in [rk45, rk4] {
        assert_eq!(others.len(), 5);
        assert!(others.iter().enumerate().all(|(k, [t, ..])| (t - (6.0 - 4.0 * 0.5f64.powi(k as i32))).abs() < 1e-12));
    }
}

/// The flights between impacts on a table that moves as a sine, the roots found by bisection.
#[test]
fn a_shaking_table_is_met_where_it_is() {
    let ball = Ball::new(1.3, 0.7);
    let tight = Dop853::new().rtol(1e-13).atol(1e-15);
    let (mut t, mut q, mut v) = (0.4, 3.0, 0.0);
    for [time, before, behind] in impacts(&tight, &ball, &State::new(t, &[q], &[v]), 40.0) {
        let height = |s: f64| q + v * (s - t) - 0.5 * (s - t) * (s - t) - ball.table(s).0;
        // The first sign change on a fine grid.
        let mut lo = t + 1e-4;
        while height(lo + 1e-4) > 0.0 {
            lo += 1e-4;
        }
        let mut hi = lo + 1e-4;
        while 0.5 * (lo + hi) > lo && 0.5 * (lo + hi) < hi {
            if height(0.5 * (lo + hi)) > 0.0 { lo = 0.5 * (lo + hi) } else { hi = 0.5 * (lo + hi) }
        }
        let speed = v - (lo - t);
        let after = ball.restitution.rebound(speed, ball.table(lo).1);
        assert!((time - lo).abs() < 1e-12 * lo.max(1.0) && (before - speed).abs() < 1e-12 && (behind - after).abs() < 2e-12);
        // Each flight by itself: errors of one would grow in the next.
        (t, q, v) = (time, ball.table(time).0, behind);
    }
    assert!(t > 30.0);
}

#[test]
fn an_elastic_stop_keeps_the_energy() {
    // Two masses on springs, the second against a stop, and the first against the second.
    struct Chain(Restitution);
    impl Model for Chain {
        fn dof(&self) -> usize {
            2
        }
        fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            (a[0], a[1]) = (-q[0], -2.0 * q[1]);
        }
        fn contacts(&self) -> usize {
            2
        }
        fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
            out[0] = Contact { deflection: q[1], rate: v[1], upper: 0.5, ..Contact::default() };
            out[1] = Contact { deflection: q[1] - q[0], rate: v[1] - v[0], lower: -0.3, ..Contact::default() };
        }
        fn impact(&self, contact: usize, on: Piece, _: &[f64], _: &[f64], v: &mut [f64]) -> bool {
            match (contact, on) {
                (0, Piece::Upper) => v[1] = self.0.rebound(v[1], 0.0),
                (1, Piece::Lower) => self.0.impulse(v[1] - v[0], &[-1.0, 1.0], &[-1.0, 0.5], v), // masses 1 and 2
                _ => return false,
            }
            true
        }
    }
    let energy = |q: &[f64], v: &[f64]| 0.5 * (v[0] * v[0] + 2.0 * v[1] * v[1] + q[0] * q[0] + 4.0 * q[1] * q[1]);
    let chain = Chain(Restitution::new(1.0).unwrap());
    let start = State::new(0.0, &[0.2, 0.0], &[1.0, 1.1]);
    let solver = Dop853::new().rtol(1e-13).atol(1e-14);
    let mut rattle = Rattle::new(&chain);
    let end = solver.run(&chain, &start, 300.0, &mut rattle).unwrap();
    let drift = energy(&end.state.q, &end.state.v) / energy(&start.q, &start.v) - 1.0;
    println!("{drift:e} after {} impacts", end.stats.crossings);
    assert!(drift.abs() < 1e-11 && end.stats.crossings > 100);
    assert_eq!(rattle.contact(0).impact_count() + rattle.contact(1).impact_count(), end.stats.crossings);
    assert_eq!((rattle.contact(0).impacts[0], rattle.contact(1).impacts[1]), (0, 0));
    assert_eq!((rattle.contact(0).state(), rattle.contact(0).loss_fraction()), (RattleState::Unilateral, 1.0));
    let lossy = solver.end(&Chain(Restitution::new(0.9).unwrap()), &start, 300.0).unwrap();
    assert!(energy(&lossy.q, &lossy.v) < 0.5 * energy(&start.q, &start.v));
}

/// Largest disagreement of the derivative with differences of the flow, Richardson.
fn against_differences<M: Model>(model: &M, start: &State, end: f64) -> f64 {
    let n = model.dof();
    let solver = Dop853::new().rtol(1e-14).atol(1e-15);
    let ours = Variation::new().tolerance(1e-13).run(model, start, end).unwrap();
    assert!(ours.crossings > 2);
    let largest = ours.matrix.amax();
    let mut worst: f64 = 0.0;
    for j in 0..2 * n {
        let h = 1e-5;
        let moved = |h: f64| {
            let mut from = start.clone();
            if j < n { from.q[j] += h } else { from.v[j - n] += h }
            let end = solver.end(model, &from, end).unwrap();
            [end.q, end.v].concat()
        };
        let (far, near) = ([moved(h), moved(-h)], [moved(0.5 * h), moved(-0.5 * h)]);
        for i in 0..2 * n {
            let slope = (4.0 * (near[0][i] - near[1][i]) / h - (far[0][i] - far[1][i]) / (2.0 * h)) / 3.0;
            worst = worst.max((ours.matrix[(i, j)] - slope).abs() / largest);
        }
    }
    println!("{} impacts, {worst:.2e}", ours.crossings);
    worst
}

/// A pendulum of two links that swings against a wall that moves: the impact depends on time, coordinates and velocities.
struct Links {
    restitution: Restitution,
}

impl Links {
    /// M⁻¹ x of unit links and masses, angles from the vertical.
    fn mobility(q: &[f64], x: [f64; 2]) -> [f64; 2] {
        let coupling = (q[0] - q[1]).cos();
        let det = 2.0 - coupling * coupling;
        [(x[0] - coupling * x[1]) / det, (2.0 * x[1] - coupling * x[0]) / det]
    }
    fn wall(u: &[f64]) -> (f64, f64) {
        let (sine, cosine) = (1.7 * u[0]).sin_cos();
        (0.4 + 0.2 * sine, 0.34 * cosine)
    }
}

impl Model for Links {
    fn dof(&self) -> usize {
        2
    }
    fn accel(&self, _: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let sine = (q[0] - q[1]).sin();
        let force = [-2.0 * q[0].sin() - sine * v[1] * v[1], sine * v[0] * v[0] - q[1].sin()];
        a.copy_from_slice(&Links::mobility(q, force));
    }
    fn contacts(&self) -> usize {
        1
    }
    /// The tip against the wall.
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let (wall, speed) = Links::wall(u);
        let rate = q[0].cos() * v[0] + q[1].cos() * v[1];
        out[0] = Contact { deflection: q[0].sin() + q[1].sin(), rate, upper: wall, upper_rate: speed, ..Contact::default() };
    }
    fn impact(&self, _: usize, _: Piece, u: &[f64], q: &[f64], v: &mut [f64]) -> bool {
        let b = [q[0].cos(), q[1].cos()];
        let rate = b[0] * v[0] + b[1] * v[1];
        self.restitution.impulse(rate - Links::wall(u).1, &b, &Links::mobility(q, b), v);
        true
    }
}

#[test]
fn the_derivative_of_impacting_motions() {
    let oscillator = Oscillator::new(0.1, 0.8, 1.0);
    assert!(against_differences(&oscillator, &State::new(0.0, &[0.3], &[0.2]), 25.0) < 1e-8);
    let ball = Ball::new(1.05, 0.6);
    assert!(against_differences(&ball, &State::new(0.3, &[2.0], &[0.1]), 12.0) < 1e-8);
    let links = Links { restitution: Restitution::new(0.8).unwrap() };
    assert!(against_differences(&links, &State::new(0.0, &[-0.4, 0.1], &[0.3, -0.2]), 9.0) < 1e-8);
    // What one impact does to differences, in closed form.
    let (t, v) = (oscillator.closed(1, -1.0).0, -1.0);
    let force = oscillator.amplitude * (oscillator.omega * t).cos() - 1.0;
    let [before, behind] = [1.0 / 0.8, -1.0].map(|v| force - 0.1 * v);
    let near = |t: f64, s: &State| Dop853::new().rtol(1e-14).atol(1e-15).end(&oscillator, s, t).unwrap();
    let _ = (near, before, behind, v);
}
