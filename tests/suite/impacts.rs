//! Rigid stops with restitution: impacts in closed form, the derivative of motions with impacts, orbits and
//! their bifurcations, invalid stops.

use crate::api::*;
use crate::data::read;
use nalgebra::DMatrix;
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// x'' + c x' + k x = A cos ωt with a rigid stop at x = d above.
pub(crate) struct Oscillator {
    k: f64,
    c: f64,
    amplitude: f64,
    omega: f64,
    stop: f64,
    restitution: Restitution,
}

impl Oscillator {
    pub(crate) fn new(c: f64, omega: f64, amplitude: f64) -> Self {
        Oscillator { k: 1.0, c, amplitude, omega, stop: 1.0, restitution: Restitution::new(0.8).unwrap() }
    }
    /// Matrix of the free motion over a time t, for x and x'.
    fn free(&self, t: f64) -> [[f64; 2]; 2] {
        let beta = (self.k - 0.25 * self.c * self.c).sqrt();
        let (decay, sine, cosine) = ((-0.5 * self.c * t).exp(), (beta * t).sin() / beta, (beta * t).cos());
        let half = 0.5 * self.c * sine;
        [[decay * (cosine + half), decay * sine], [-decay * self.k * sine, decay * (cosine - half)]]
    }
    /// The orbit with one impact in n periods and the velocity v after it, in closed form: the time of the
    /// impact and the amplitude A of the excitation.
    pub(crate) fn closed(&self, n: usize, v: f64) -> (f64, f64) {
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
    /// A guess: the state of that orbit 0.37 periods after its impact.
    pub(crate) fn guess(&self, n: usize, v: f64) -> State {
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
    fn offers(&self) -> Offers<'_> {
        Offers { stops: &[[true, true]], ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        out[0] = Contact { deflection: q[0], rate: v[0], upper: self.stop, ..Contact::default() };
    }
    fn impact(&self, _: usize, _: Piece, _: &[f64], _: &[f64], v: &mut [f64]) {
        v[0] = self.restitution.rebound(v[0], 0.0);
    }
}

impl Periodic for Oscillator {
    fn period(&self) -> f64 {
        TAU / self.omega
    }
}

/// x'' = -g above a table at A sin ωt: a bouncing ball.
struct Ball {
    gravity: f64,
    amplitude: f64,
    omega: f64,
    restitution: Restitution,
}

impl Ball {
    /// `gamma` is Γ = A ω²/g; g = 1 and ω = 2.
    fn new(gamma: f64, e: f64) -> Self {
        Ball { gravity: 1.0, amplitude: 0.25 * gamma, omega: 2.0, restitution: Restitution::new(e).unwrap() }
    }
    fn table(&self, t: f64) -> (f64, f64) {
        let (sine, cosine) = (self.omega * t).sin_cos();
        (self.amplitude * sine, self.amplitude * self.omega * cosine)
    }
    /// The orbit of one bounce a period, at its highest point.
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
    fn offers(&self) -> Offers<'_> {
        Offers { stops: &[[true, true]], ..Offers::default() }
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
        out[0] =
            Contact { deflection: q[0], rate: v[0], lower: u[0], lower_rate: u[1], ..Contact::default() };
    }
    fn impact(&self, _: usize, _: Piece, u: &[f64], _: &[f64], v: &mut [f64]) {
        v[0] = self.restitution.rebound(v[0], u[1]);
    }
}

impl Periodic for Ball {
    fn period(&self) -> f64 {
        TAU / self.omega
    }
}

/// The impacts of a run: time, velocity before, velocity after.
fn impacts<M: Model>(
    solver: &impl Integrator,
    model: &M,
    start: &State,
    end: f64,
) -> Result<Vec<[f64; 3]>, IntegrateError> {
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
    solver.run(model, start, end, &mut watch)?;
    Ok(all)
}

#[test]
fn a_ball_on_a_floor_keeps_its_times() {
    let tight = Dop853::new().rtol(1e-13).atol(1e-15);
    let ball = Ball { amplitude: 0.0, ..Ball::new(0.0, 0.5) };
    // Dropped from a height of 2: the first impact at t = 2 with speed 2, then flights of 2, 1, 1/2, ..
    let seen = impacts(&tight, &ball, &State::new(0.0, &[2.0], &[0.0]), 5.8).unwrap();
    assert_eq!(seen.len(), 5);
    for (k, [t, before, behind]) in seen.into_iter().enumerate() {
        let half = 0.5f64.powi(k as i32);
        assert!((t - (6.0 - 4.0 * half)).abs() < 1e-12, "{k}: {t}");
        assert!(
            (before + 2.0 * half).abs() < 1e-12 && (behind - half).abs() < 1e-12,
            "{k}: {before} {behind}"
        );
    }
    let rk45 =
        impacts(&Rk45::new().rtol(1e-10).atol(1e-12), &ball, &State::new(0.0, &[2.0], &[0.0]), 5.8).unwrap();
    let rk4 = impacts(&Rk4::new(0.03), &ball, &State::new(0.0, &[2.0], &[0.0]), 5.8).unwrap();
    for others in [rk45, rk4] {
        assert_eq!(others.len(), 5);
        assert!(
            others
                .iter()
                .enumerate()
                .all(|(k, [t, ..])| (t - (6.0 - 4.0 * 0.5f64.powi(k as i32))).abs() < 1e-12)
        );
    }
}

/// The flights between impacts on a table that moves as a sine, compared with roots found by bisection.
#[test]
fn a_shaking_table_is_met_where_it_is() {
    let ball = Ball::new(4.3, 0.9);
    let tight = Dop853::new().rtol(1e-13).atol(1e-15);
    let (mut t, mut q, mut v) = (0.4, 3.0, 0.0);
    for [time, before, behind] in impacts(&tight, &ball, &State::new(t, &[q], &[v]), 40.0).unwrap() {
        let height = |s: f64| q + v * (s - t) - 0.5 * (s - t) * (s - t) - ball.table(s).0;
        // The first sign change on a fine grid, then bisection.
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
        assert!(
            (time - lo).abs() < 1e-12 * lo.max(1.0)
                && (before - speed).abs() < 1e-12
                && (behind - after).abs() < 2e-12
        );
        // Each flight starts from the computed state: an error of one flight would grow in the next.
        (t, q, v) = (time, ball.table(time).0, behind);
    }
    assert!(t > 30.0);
}

#[test]
fn an_elastic_stop_keeps_the_energy() {
    // Two masses on springs: the second against a stop, and the first against the second.
    struct Chain(Restitution);
    impl Model for Chain {
        fn dof(&self) -> usize {
            2
        }
        fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            (a[0], a[1]) = (-q[0], -2.0 * q[1]);
        }
        fn offers(&self) -> Offers<'_> {
            Offers { stops: &[[false, true], [true, false]], ..Offers::default() }
        }
        fn contacts(&self) -> usize {
            2
        }
        fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
            out[0] = Contact { deflection: q[1], rate: v[1], upper: 0.5, ..Contact::default() };
            out[1] =
                Contact { deflection: q[1] - q[0], rate: v[1] - v[0], lower: -0.3, ..Contact::default() };
        }
        fn impact(&self, contact: usize, on: Piece, _: &[f64], _: &[f64], v: &mut [f64]) {
            match (contact, on) {
                (0, Piece::Upper) => v[1] = self.0.rebound(v[1], 0.0),
                // The masses are 1 and 2.
                (1, Piece::Lower) => self.0.impulse(v[1] - v[0], &[-1.0, 1.0], &[-1.0, 0.5], v),
                _ => {}
            }
        }
    }
    let energy =
        |q: &[f64], v: &[f64]| 0.5 * (v[0] * v[0] + 2.0 * v[1] * v[1] + q[0] * q[0] + 4.0 * q[1] * q[1]);
    let chain = Chain(Restitution::new(1.0).unwrap());
    let start = State::new(0.0, &[0.2, 0.0], &[1.0, 1.1]);
    let solver = Dop853::new().rtol(1e-13).atol(1e-14);
    let mut rattle = Rattle::new(&chain);
    let end = solver.run(&chain, &start, 300.0, &mut rattle).unwrap();
    let drift = energy(&end.state.q, &end.state.v) / energy(&start.q, &start.v) - 1.0;
    println!("{drift:e} after {} impacts", end.stats.crossings);
    assert!(drift.abs() < 1e-11 && end.stats.crossings > 100);
    assert_eq!(
        rattle.contacts()[0].impact_count() + rattle.contacts()[1].impact_count(),
        end.stats.crossings
    );
    assert_eq!((rattle.contacts()[0].impacts[0], rattle.contacts()[1].impacts[1]), (0, 0));
    assert_eq!(
        (rattle.contacts()[0].rattle_state(), rattle.contacts()[0].loss_fraction()),
        (RattleState::Unilateral, 1.0)
    );
    let lossy = solver.end(&Chain(Restitution::new(0.9).unwrap()), &start, 300.0).unwrap();
    assert!(energy(&lossy.q, &lossy.v) < 0.5 * energy(&start.q, &start.v));
}

/// Three balls of equal mass in a row. The first hits the second, which touches the third.
#[test]
fn impacts_at_one_instant_follow_each_other() {
    struct Row(Restitution);
    impl Model for Row {
        fn dof(&self) -> usize {
            3
        }
        fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
            a.fill(0.0);
        }
        fn offers(&self) -> Offers<'_> {
            Offers { stops: &[[true, true]; 2], ..Offers::default() }
        }
        fn contacts(&self) -> usize {
            2
        }
        fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
            for i in 0..2 {
                out[i] = Contact {
                    deflection: q[i + 1] - q[i],
                    rate: v[i + 1] - v[i],
                    lower: 1.0,
                    ..Contact::default()
                };
            }
        }
        fn impact(&self, i: usize, _: Piece, _: &[f64], _: &[f64], v: &mut [f64]) {
            let v = &mut v[i..i + 2];
            self.0.impulse(v[1] - v[0], &[-1.0, 1.0], &[-1.0, 1.0], v);
        }
    }
    let start = State::new(0.0, &[-1.0, 1.0, 2.0], &[1.0, 0.0, 0.0]);
    let mut seen = Vec::new();
    let mut watch = |step: &mut Step<'_>| {
        seen.extend(step.crossings().iter().map(|c| (c.contact, c.to, (step.t1() * 1e12).round())));
        ControlFlow::Continue(())
    };
    let end = Dop853::new().run(&Row(Restitution::new(1.0).unwrap()), &start, 2.0, &mut watch).unwrap();
    assert_eq!(seen, [(0, Piece::Lower, 1e12), (1, Piece::Lower, 1e12)]);
    for (v, expected) in end.state.v.iter().zip([0.0, 0.0, 1.0]) {
        assert!((v - expected).abs() < 1e-12, "{:?}", end.state.v);
    }
    // With losses the first two balls collide repeatedly and ever more slowly. Momentum is preserved.
    let end = Dop853::new().end(&Row(Restitution::new(0.5).unwrap()), &start, 2.0).unwrap();
    assert!(
        (end.v.iter().sum::<f64>() - 1.0).abs() < 1e-12 && end.v[2] > end.v[1] && end.v[1] >= end.v[0],
        "{:?}",
        end.v
    );
}

/// Largest difference between the derivative of the flow and differences of the flow (Richardson
/// extrapolation), over its largest entry.
fn against_differences<M: Model>(model: &M, start: &State, end: f64) -> f64 {
    let n = model.dof();
    let solver = Dop853::new().rtol(1e-14).atol(1e-15);
    let ours = Variation::new().flow_tolerance(1e-13).run(model, start, end).unwrap();
    assert!(ours.crossings >= 2, "{ours:?}");
    let largest = ours.matrix.amax();
    let mut worst: f64 = 0.0;
    for j in 0..2 * n {
        let h = 1e-5;
        let moved = |h: f64| {
            let mut from = start.clone();
            if j < n {
                from.q[j] += h
            } else {
                from.v[j - n] += h
            }
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

/// A pendulum of two links that swings against a moving wall: the impact depends on time, coordinates and
/// velocities.
struct Links {
    restitution: Restitution,
}

impl Links {
    /// M⁻¹ x for links of unit length and mass, with angles from the vertical.
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
    fn offers(&self) -> Offers<'_> {
        Offers { stops: &[[true, true]], ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    /// The tip of the second link against the wall.
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let (wall, speed) = Links::wall(u);
        let rate = q[0].cos() * v[0] + q[1].cos() * v[1];
        out[0] = Contact {
            deflection: q[0].sin() + q[1].sin(),
            rate,
            upper: wall,
            upper_rate: speed,
            ..Contact::default()
        };
    }
    fn impact(&self, _: usize, _: Piece, u: &[f64], q: &[f64], v: &mut [f64]) {
        let b = [q[0].cos(), q[1].cos()];
        let rate = b[0] * v[0] + b[1] * v[1];
        self.restitution.impulse(rate - Links::wall(u).1, &b, &Links::mobility(q, b), v);
    }
}

/// x'' = 1.2 cos 1.3 t - x - (20 (x - 0.5) + 3 x') beyond a pad at 0.5, with a rigid stop at 0.6. With or
/// without fixed pieces.
struct Padded {
    pieces: bool,
    restitution: Restitution,
}

impl Model for Padded {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let pad = if q[0] > 0.5 { 20.0 * (q[0] - 0.5) + 3.0 * v[0] } else { 0.0 };
        a[0] = 1.2 * (1.3 * u[0]).cos() - q[0] - pad;
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: self.pieces, stops: &[[false; 2], [false, true]], ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        2
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        out[0] = Contact { deflection: q[0], rate: v[0], upper: 0.5, ..Contact::default() };
        out[1] = Contact { upper: 0.6, ..out[0] };
    }
    fn impact(&self, _: usize, _: Piece, _: &[f64], _: &[f64], v: &mut [f64]) {
        v[0] = self.restitution.rebound(v[0], 0.0);
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let pad = if pieces[0] == Piece::Upper { 20.0 * (q[0] - 0.5) + 3.0 * v[0] } else { 0.0 };
        a[0] = 1.2 * (1.3 * u[0]).cos() - q[0] - pad;
    }
}

#[test]
fn the_derivative_of_impacting_motions() {
    let oscillator = Oscillator::new(0.1, 0.8, 1.0);
    assert!(against_differences(&oscillator, &State::new(0.0, &[0.3], &[0.2]), 25.0) < 1e-8);
    let ball = Ball::new(2.5, 0.8);
    assert!(against_differences(&ball, &State::new(0.3, &[2.0], &[0.1]), 16.0) < 1e-8);
    let links = Links { restitution: Restitution::new(0.8).unwrap() };
    assert!(against_differences(&links, &State::new(0.0, &[-0.7, 0.1], &[0.9, -0.2]), 9.0) < 1e-8);
    let [padded, without] =
        [true, false].map(|pieces| Padded { pieces, restitution: Restitution::new(0.7).unwrap() });
    let start = State::new(0.0, &[0.0], &[1.5]);
    let mut kinds = [0; 2];
    let mut count = |step: &mut Step<'_>| {
        step.crossings().iter().for_each(|c| kinds[usize::from(c.rebounds)] += 1);
        ControlFlow::Continue(())
    };
    Dop853::new().run(&padded, &start, 12.0, &mut count).unwrap();
    assert!(kinds[0] > 3 && kinds[1] > 1, "{kinds:?}");
    assert!(against_differences(&padded, &start, 12.0) < 2e-8);
    let [a, b] = [&padded, &without].map(|model| Variation::new().run(model, &start, 12.0).unwrap().matrix);
    println!("{:e}", (&a - &b).amax() / a.amax());
    assert!((&a - &b).amax() < 1e-9 * a.amax());
    // From a start on the stop, just before the rebound: δ⁺ = S δ with S = [[-e, 0], [(a⁺ + e a)/v, -e]].
    let (t, v): (f64, f64) = (0.3, 0.7);
    let [a, behind] = [v, -0.8 * v].map(|v| (0.8 * t).cos() - 0.1 * v - 1.0);
    let s = DMatrix::from_row_slice(2, 2, &[-0.8, 0.0, (behind + 0.8 * a) / v, -0.8]);
    let on = Variation::new().run(&oscillator, &State::new(t, &[1.0], &[v]), 1.2).unwrap();
    let off = Variation::new().run(&oscillator, &State::new(t, &[1.0], &[-0.8 * v]), 1.2).unwrap();
    assert!((&off.matrix * s - on.matrix).amax() < 1e-10 && (off.state.q[0] - on.state.q[0]).abs() < 1e-12);
}

/// A zero of `f` by the secant method; `f` must be smooth there.
fn secant(mut f: impl FnMut(f64) -> f64, [mut a, mut b]: [f64; 2]) -> f64 {
    let mut at_a = f(a);
    for _ in 0..30 {
        let at_b = f(b);
        println!("  {b:.16} {at_b:.2e}");
        let next = b - at_b * (b - a) / (at_b - at_a);
        (a, at_a, b) = (b, at_b, next);
        if (b - a).abs() < 1e-11 * b.abs() {
            return b;
        }
    }
    panic!("the secant method does not converge")
}

/// The parameter p at a fold, extrapolated from orbits on one side of it: p = p0 + a f² + b f³, where f is
/// the distance of a multiplier from 1.
fn fold(mut f: impl FnMut(f64) -> f64, start: [f64; 3]) -> f64 {
    let mut seen = start.map(|p| (f(p), p));
    let mut last = f64::NAN;
    for _ in 0..30 {
        let [(f0, p0), (f1, p1), (f2, p2)] = seen;
        let row = |f: f64, p: f64| [f * f - f0 * f0, f.powi(3) - f0.powi(3), p - p0];
        let ([a1, b1, c1], [a2, b2, c2]) = (row(f1, p1), row(f2, p2));
        let det = a1 * b2 - a2 * b1;
        let (a, b) = ((c1 * b2 - c2 * b1) / det, (a1 * c2 - a2 * c1) / det);
        let at = p2 - a * f2 * f2 - b * f2.powi(3);
        println!("  {p2:.16} {f2:.2e} {at:.16}");
        if (at - last).abs() < 1e-11 * at {
            return at;
        }
        last = at;
        let next = at + a * (f2 / 4.0).powi(2);
        seen = [seen[1], seen[2], (f(next), next)];
    }
    panic!("the extrapolation to the fold does not converge")
}

/// det(M - s), which is zero if s is a multiplier.
fn characteristic(cycle: &ShootingOrbit, s: f64) -> f64 {
    let m = cycle.monodromy();
    s * s - s * m.trace() + m.determinant()
}

#[test]
fn grazing_doubling_and_fold_of_the_impact_oscillator() {
    let reference = &read("impacts.json")["impact_oscillator"];
    for entry in reference["values"].as_array().unwrap() {
        let get = |name: &str| entry[name].as_f64();
        let (c, omega, n) = (get("c").unwrap(), get("w").unwrap(), get("n").unwrap() as usize);
        let agrees = |ours: f64, name: &str| {
            let wanted = get(name).unwrap();
            println!("{name}: {ours:.15}, off {:.1e}", ours / wanted - 1.0);
            assert!((ours / wanted - 1.0).abs() < 1e-9, "{name}: {ours} {wanted}");
        };
        let shooting = Shooting::new().period_multiple(n);
        // The orbit without impacts is proportional to A. It grazes when its maximum reaches the stop.
        let top = |amplitude: f64| {
            let model = Oscillator::new(c, omega, amplitude);
            let cycle = shooting.solve(&model, &State::at_rest(1)).unwrap();
            assert_eq!(cycle.crossing_count(), 0);
            let mut statistics = Statistics::new(&model, &["q0"]).unwrap();
            cycle.observe(&model, &mut statistics).unwrap();
            statistics.summary("q0").unwrap().max
        };
        let (low, high) = (0.1, 0.14);
        let graze = low + (1.0 - top(low)) * (high - low) / (top(high) - top(low));
        agrees(graze, "A_graze");
        // The orbit of one impact at A = 1, and the velocity after the impact.
        let v = get("v_at_A_1").unwrap();
        let model = Oscillator::new(c, omega, 1.0);
        assert!((model.closed(n, v).1 - 1.0).abs() < 1e-12);
        let mut cycle = shooting.solve(&model, &[model.guess(n, 1.001 * v)]).unwrap();
        let mut speed = f64::NAN;
        let mut watch = |step: &mut Step<'_>| {
            speed = if step.crossings().is_empty() { speed } else { -0.8 * step.v1()[0] };
            ControlFlow::Continue(())
        };
        cycle.observe(&model, &mut watch).unwrap();
        agrees(speed, "v_at_A_1");
        // Towards the bifurcation, each orbit is found from the previous one.
        let mut orbit = |amplitude: f64| {
            let model = Oscillator::new(c, omega, amplitude);
            cycle = shooting.solve_from(&model, &cycle).unwrap();
            assert_eq!(cycle.crossing_count(), 1);
            let product = 0.64 * (-c * n as f64 * model.period()).exp();
            let det = cycle.monodromy().determinant();
            assert!((det / product - 1.0).abs() < 1e-9, "{det} {product}");
            cycle.clone()
        };
        if get("A_period_doubling").is_some() {
            for amplitude in [0.9, 0.8, 0.7, 0.6] {
                orbit(amplitude);
            }
            agrees(
                secant(|amplitude| characteristic(&orbit(amplitude), -1.0), [0.55, 0.53]),
                "A_period_doubling",
            );
        } else {
            for amplitude in [0.7, 0.5, 0.35, 0.25, 0.2, 0.18] {
                orbit(amplitude);
            }
            agrees(fold(|amplitude| characteristic(&orbit(amplitude), 1.0), [0.17, 0.165, 0.16]), "A_fold");
        }
    }
}

/// At the least amplitude with an orbit of one impact in n periods, that is, where A(v) is smallest, the
/// multiplier is 1.
#[test]
fn shooting_at_a_fold_of_impact_orbits_says_that_it_is_singular() {
    let reference = &read("impacts.json")["impact_oscillator"];
    let mut singular = 0;
    for entry in reference["values"].as_array().unwrap() {
        let get = |name: &str| entry[name].as_f64();
        let Some(least) = get("A_fold") else { continue };
        let (c, omega, n) = (get("c").unwrap(), get("w").unwrap(), get("n").unwrap() as usize);
        let oscillator = Oscillator::new(c, omega, least);
        let (mut lo, mut hi) = (0.02 * get("v_at_A_1").unwrap(), get("v_at_A_1").unwrap());
        for _ in 0..100 {
            let [a, b] = [lo + (hi - lo) / 3.0, hi - (hi - lo) / 3.0];
            let less = oscillator.closed(n, a).1 < oscillator.closed(n, b).1;
            if less { hi = b } else { lo = a }
        }
        let v = 0.5 * (lo + hi);
        let amplitude = oscillator.closed(n, v).1;
        assert!((amplitude / least - 1.0).abs() < 1e-9, "{amplitude} {least}");
        // From the state of the fold, for amplitudes beside it, too.
        let at_fold = [0.0, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3].map(|off| (0.0, off));
        let beside_fold = [1e-12, 1e-10, 1e-8].map(|beside| (beside, 0.0));
        for (beside, off) in at_fold.into_iter().chain(beside_fold) {
            let model = Oscillator::new(c, omega, amplitude * (1.0 + beside));
            let state = model.guess(n, v * (1.0 + off));
            match Shooting::new().period_multiple(n).solve(&model, &[state]) {
                Err(ShootingError::Singular { .. }) => singular += 1,
                Ok(orbit) => {
                    let near = |z: &num_complex::Complex64| (z - 1.0).norm() < 1e-2;
                    assert!(orbit.multipliers().values().iter().any(near), "{beside} {off}");
                }
                Err(other) => panic!("{beside} {off}: {other}"),
            }
        }
    }
    assert!(singular > 0);
}

/// Orbits of one impact in n periods for 200 oscillators: trace and determinant of the monodromy matrix,
/// which is S M in closed form. The sample contains stable and unstable orbits.
#[test]
fn multipliers_of_orbits_of_one_impact() {
    let mut counts = [0, 0];
    for case in 0..200 {
        let part = |k: usize| {
            ((case * 7 + k) as f64 * 0.618_033_988_749_895 + (case * k) as f64 * 0.414_213_562).fract()
        };
        let (c, omega, n) = (0.02 + 0.3 * part(1), 0.5 + 2.5 * part(2), 1 + (3.0 * part(3)) as usize);
        let (e, v) = (0.3 + 0.69 * part(4), -0.05 - 2.0 * part(5));
        let mut model =
            Oscillator { restitution: Restitution::new(e).unwrap(), ..Oscillator::new(c, omega, 1.0) };
        let (t, amplitude) = model.closed(n, v);
        model.amplitude = amplitude;
        let span = n as f64 * model.period();
        let met = impacts(
            &Dop853::new().rtol(1e-12).atol(1e-13),
            &model,
            &State::new(t, &[1.0], &[v]),
            t + 1.001 * span,
        );
        if !met.is_ok_and(|met| met.len() == 1 && (met[0][0] - t - span).abs() < 1e-6) {
            continue; // another impact occurs before
        }
        let [before, behind] = [-v / e, v].map(|v| amplitude * (omega * t).cos() - c * v - 1.0);
        let s = DMatrix::from_row_slice(2, 2, &[-e, 0.0, (behind + e * before) / (-v / e), -e]);
        let free = model.free(span);
        let closed = s * DMatrix::from_row_slice(2, 2, &free.concat());
        let cycle = Shooting::new().period_multiple(n).solve(&model, &[model.guess(n, v)]).unwrap();
        let ours = cycle.monodromy();
        let off = (ours.trace() - closed.trace()).abs() / closed.amax()
            + (ours.determinant() / closed.determinant() - 1.0).abs();
        println!(
            "{case}: c {c:.3} w {omega:.3} n {n} e {e:.3} v {v:.3} trace {:.4}, off {off:.1e}",
            closed.trace()
        );
        // The bound holds for stable and for unstable orbits.
        assert!(off < 1e-9, "{off}");
        counts[usize::from(cycle.stability() == Stability::Stable)] += 1;
    }
    println!("{counts:?}");
    assert!(counts[0] > 10 && counts[1] > 10, "{counts:?}");
}

#[test]
fn the_bouncing_ball_between_its_bounds() {
    for entry in read("impacts.json")["bouncing_ball"]["values"].as_array().unwrap() {
        let get = |name: &str| entry[name].as_f64().unwrap();
        let (r, lower, doubling) = (get("r"), get("lower"), get("pd"));
        let start = Ball::new(0.6, r);
        let mut cycle = Shooting::new().solve(&start, &[start.top(lower)]).unwrap();
        let mut orbit = |gamma: f64| {
            cycle = Shooting::new().solve_from(&Ball::new(gamma, r), &cycle).unwrap();
            assert_eq!((cycle.crossing_count(), cycle.drift().0.len()), (1, 1));
            assert_eq!(cycle.drift().0, [0.0]);
            let det = cycle.monodromy().determinant();
            assert!((det / (r * r) - 1.0).abs() < 1e-9, "{det}");
            cycle.clone()
        };
        let at = secant(|gamma| characteristic(&orbit(gamma), -1.0), [0.9, 1.0]);
        println!("{at} {doubling}");
        assert!((at / doubling - 1.0).abs() < 1e-9, "{at} {doubling}");
        for gamma in [0.8, 0.6, 0.5, 0.45, 0.42] {
            orbit(gamma);
        }
        let at = fold(|gamma| characteristic(&orbit(gamma), 1.0), [0.41, 0.4, 0.39]);
        println!("{at} {lower}");
        assert!((at / lower - 1.0).abs() < 1e-9, "{at} {lower}");
    }
}

#[test]
fn exponents_of_a_ball_that_never_settles() {
    // Between bounces areas are preserved; at each bounce they shrink by r². The exponents therefore sum to
    // ln r² times the rate of bounces.
    let ball = Ball::new(5.0, 0.8);
    let period = ball.period();
    let exponents =
        Lyapunov::new().settle(0).align(0).measure(300).run(&ball, &State::new(0.0, &[3.0], &[0.2])).unwrap();
    let bounces = impacts(
        &Dop853::new().rtol(1e-12).atol(1e-13),
        &ball,
        &State::new(0.0, &[3.0], &[0.2]),
        20.0 * period,
    )
    .unwrap()
    .len();
    let sum: f64 = exponents.values().iter().sum();
    println!("{:?} {sum} {}", exponents.values(), bounces as f64 / (20.0 * period) * 0.64f64.ln());
    assert!(exponents.values()[0] > 0.01);
    let rate = sum / 0.64f64.ln() * 300.0 * period;
    assert!((rate - rate.round()).abs() < 1e-4 && rate > 30.0, "{rate}");
}

#[test]
fn stops_at_the_start_and_at_the_end_of_a_run() {
    let ball = Ball { amplitude: 0.0, ..Ball::new(0.0, 0.5) };
    let solver = Dop853::new().rtol(1e-12).atol(1e-14);
    // On the floor and moving into it: the same as after the impact.
    let hit = solver.end(&ball, &State::new(0.0, &[0.0], &[-1.0]), 0.3).unwrap();
    let behind = solver.end(&ball, &State::new(0.0, &[0.0], &[0.5]), 0.3).unwrap();
    assert!((hit.q[0] - behind.q[0]).abs() < 1e-15 && (hit.v[0] - behind.v[0]).abs() < 1e-15);
    // A run that ends at an impact ends behind it, or before it by rounding: of this run and the one that continues
    // one has the impact.
    let mut nothing = |_: &mut Step<'_>| ControlFlow::Continue(());
    let first = solver.run(&ball, &State::new(0.0, &[0.5], &[0.0]), 1.0, &mut nothing).unwrap();
    let halfway = first.state;
    assert!((halfway.v[0] - if first.stats.crossings == 1 { 0.5 } else { -1.0 }).abs() < 1e-12);
    let second = solver.run(&ball, &halfway, 1.5, &mut nothing).unwrap();
    assert_eq!(first.stats.crossings + second.stats.crossings, 1);
    let end = solver.end(&ball, &halfway, 1.5).unwrap();
    assert!((end.q[0] - 0.125).abs() < 1e-12 && end.v[0].abs() < 1e-12);
    // At the impact the velocity jumps across the level of the section.
    let mut section = Section::new(&ball, "v0", 0.0, Direction::Rising).unwrap();
    solver.run(&ball, &State::new(0.0, &[0.5], &[0.0]), 1.2, &mut section).unwrap();
    assert!(section.states().len() == 1 && (section.states()[0].t - 1.0).abs() < 1e-12);
}

#[test]
fn what_rests_on_a_stop_ends_the_run_with_what_there_is() {
    for (e, until) in [(0.5, 3.0), (0.9, 19.0), (0.0, 1.0)] {
        let ball = Ball { amplitude: 0.0, ..Ball::new(0.0, e) };
        // At a floor of -3 rounding is that of the height and not of zero.
        for floor in [0.0, -3.0] {
            struct On(Ball, f64);
            impl Model for On {
                fn dof(&self) -> usize {
                    1
                }
                fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
                    self.0.accel(u, q, v, a);
                }
                fn offers(&self) -> Offers<'_> {
                    Offers { stops: &[[true, true]], ..Offers::default() }
                }
                fn contacts(&self) -> usize {
                    1
                }
                fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
                    out[0] = Contact { deflection: q[0], rate: v[0], lower: self.1, ..Contact::default() };
                }
                fn impact(&self, _: usize, _: Piece, _: &[f64], _: &[f64], v: &mut [f64]) {
                    v[0] = self.0.restitution.rebound(v[0], 0.0);
                }
            }
            let on = On(Ball { ..Ball::new(0.0, e) }, floor);
            let failed = Dop853::new()
                .rtol(1e-12)
                .atol(1e-14)
                .trajectory(&on, &State::new(0.0, &[floor + 0.5], &[0.0]), 40.0)
                .unwrap_err();
            let IntegrateError::RestsOnStop { t, contact: 0 } = failed.error else {
                panic!("{}", failed.error)
            };
            println!("{e} {floor}: {t} after {} steps", failed.trajectory.len());
            assert!((t - until).abs() < 1e-5, "{t} {until}");
            assert!(failed.trajectory.len() < 1000 && *failed.trajectory.times().last().unwrap() <= t);
        }
        let tangent = Variation::new().run(&ball, &State::new(0.0, &[0.5], &[0.0]), 40.0);
        assert!(matches!(tangent, Err(IntegrateError::RestsOnStop { .. })));
        assert!(matches!(
            Rk4::new(0.01).end(&ball, &State::new(0.0, &[0.5], &[0.0]), 40.0),
            Err(IntegrateError::RestsOnStop { .. })
        ));
    }
    // A table that sinks faster than the ball falls releases it.
    let ball = Ball::new(3.0, 0.0);
    assert!(Dop853::new().end(&ball, &State::new(0.0, &[0.8], &[0.0]), 1.6).is_ok());
}

#[test]
fn stops_are_refused_where_they_cannot_be_kept() {
    for bad in [-0.1, 1.1, f64::INFINITY, f64::NAN] {
        let error = Restitution::new(bad).unwrap_err();
        match error {
            ParameterError::OutOfRange { name, value, allowed: "[0, 1]" } => {
                assert!(name == "restitution" && value == bad)
            }
            ParameterError::NotFinite { name, .. } => assert!(name == "restitution" && !bad.is_finite()),
            other => panic!("{other}"),
        }
    }
    let model = Oscillator::new(0.1, 0.8, 1.0);
    let rest = State::at_rest(1);
    assert_eq!(
        Rk4::new(0.01).plain().end(&model, &rest, 1.0),
        Err(IntegrateError::StopNotLocated { contact: 0 })
    );
    let held = Noisy::new(model);
    assert_eq!(
        Rk4::new(0.01).plain().end(&held, &rest, 1.0),
        Err(IntegrateError::StopNotLocated { contact: 0 })
    );
    let model = Oscillator::new(0.1, 0.8, 1.0);
    let beyond = Dop853::new().end(&model, &State::new(0.0, &[1.5], &[0.0]), 1.0);
    assert_eq!(beyond, Err(IntegrateError::BeyondStop { t: 0.0, contact: 0, depth: 0.5 }));
    let balance = Balance::new(Harmonics::up_to(5));
    let near = FourierOrbit::new(balance.harmonics(), model.period(), &[vec![0.0; 11]]).unwrap();
    let refused = BalanceError::RigidStop { contact: 0 };
    assert_eq!(balance.solve(&model, &near), Err(refused.clone()));
    assert_eq!(balance.linearised(&model, Piece::Gap), Err(refused.clone()));
    assert_eq!(balance.flank_jacobian(&model, Piece::Upper, &near).unwrap_err(), refused);
    let multipliers = Balance::new(near.harmonics().clone()).multipliers(&model, &near);
    assert_eq!(multipliers, Err(MultiplierError::RigidStop { contact: 0 }));
}

#[test]
fn a_stop_that_does_not_turn_its_contact_round_is_found() {
    let ball = Ball::new(0.6, 0.8);
    assert_eq!(check_periodic(&ball, &State::new(0.4, &[1.0], &[0.3])), []);
    assert_eq!(
        check_model(
            &Links { restitution: Restitution::new(0.0).unwrap() },
            &State::new(0.4, &[0.1, -0.2], &[0.3, 0.1])
        ),
        []
    );
    struct Wrong(Ball, f64);
    impl Model for Wrong {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
            self.0.accel(u, q, v, a);
        }
        fn base(&self) -> Option<&dyn Model> {
            Some(&self.0)
        }
        fn offers(&self) -> Offers<'_> {
            Offers { stops: &[[true, true]], ..Offers::default() }
        }
        fn impact(&self, _: usize, _: Piece, _: &[f64], _: &[f64], v: &mut [f64]) {
            v[0] *= self.1;
        }
    }
    for factor in [0.8, -1.1, 1.0] {
        let wrong = Wrong(Ball { amplitude: 0.0, ..Ball::new(0.0, 0.8) }, factor);
        let found = check_model(&wrong, &State::new(0.4, &[1.0], &[0.3]));
        assert!(matches!(found[..], [Inconsistency::Rebound { contact: 0, .. }]), "{found:?}");
        assert!(
            found[0]
                .to_string()
                .starts_with("impact: contact 0 meets its stop at the deflection 0 with a speed of")
        );
    }
    let stuck = Wrong(Ball { amplitude: 0.0, ..Ball::new(0.0, 0.8) }, 1.0);
    let error = Dop853::new().end(&stuck, &State::new(0.0, &[0.5], &[0.0]), 2.0).unwrap_err();
    assert!(matches!(error, IntegrateError::TooManyImpacts { contact: 0, .. }), "{error}");
}

/// Branches over the amplitude: the period doubling and the fold of orbits with one impact, and the grazing of
/// orbits without an impact, where their branch ends.
#[test]
fn branches_of_an_oscillator_with_a_stop() {
    use gear_dynamics::branches::{BranchEnd, Continuation, Family, PointKind};
    let data = read("impacts.json");
    for case in data["impact_oscillator"]["values"].as_array().unwrap() {
        let number = |key: &str| case[key].as_f64();
        let (c, w) = (number("c").unwrap(), number("w").unwrap());
        let family = Family::of([("amplitude", "1")], |[amplitude]| Ok(Oscillator::new(c, w, amplitude)));
        let start = Oscillator::new(c, w, 1.0).guess(1, number("v_at_A_1").unwrap());
        let branch =
            Continuation::new(1.0, 0.1).bounds(0.05, 1.1).max_points(120).run(&family, &[start]).unwrap();
        println!("{branch}");
        for (kind, key) in [(PointKind::PeriodDoubling, "A_period_doubling"), (PointKind::Fold, "A_fold")] {
            let Some(exact) = number(key) else { continue };
            let found = branch.of_kind(kind)[0].parameter;
            println!("{kind} {found} {exact} {:.1e}", found - exact);
            assert!((found - exact).abs() < 1e-10);
        }
        let rest = Continuation::new(0.1, 1.0).run(&family, &State::at_rest(1)).unwrap();
        println!("{rest}");
        let exact = number("A_graze").unwrap();
        let graze = rest.of_kind(PointKind::Grazing)[0].parameter;
        println!("grazing {graze} {exact} {:.1e}", graze - exact);
        assert_eq!(rest.end(), &BranchEnd::Stop { contact: 0 });
        assert!((graze - exact).abs() < 1e-10);
    }
}
