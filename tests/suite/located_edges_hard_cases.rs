//! Location of edges in difficult cases: simultaneous, tangent, chattering, moving and jumping edges, edges
//! at the start and the end, runs in parts. Each result is compared with a closed form or a brute-force
//! solution of this file, for every solver.

use crate::api::*;
use crate::common::random::Random;
use gear_dynamics::model::recording::{Expand, Node, Recorded};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// One mass between springs: q'' = a - Σ_i (k_i ξ_i + c_i ξ_i'). ξ_i is the penetration of stop i, whose edge
/// is e_i + A_i sin(ω_i t + φ_i).
#[derive(Clone, Debug, Default)]
struct Stops {
    pull: f64,
    all: Vec<Stop>,
    /// All edges move up by the second number at the end of the first interval of the first number's length,
    /// and back at the end of the next one.
    jumps: Option<[f64; 2]>,
}

/// A stop above the mass, or below it.
#[derive(Clone, Copy, Debug, Default)]
struct Stop {
    below: bool,
    edge: f64,
    stiffness: f64,
    damping: f64,
    /// Amplitude, frequency and phase of its edge.
    shake: [f64; 3],
}

impl Stops {
    fn jump(&self, t: f64, side: Side) -> f64 {
        let Some([hold, size]) = self.jumps else {
            return 0.0;
        };
        let mut k = (t / hold).round();
        let at = k * hold == t;
        if !at {
            k = (t / hold).floor();
        } else if side == Side::Before {
            k -= 1.0;
        }
        if k.rem_euclid(2.0) == 1.0 { size } else { 0.0 }
    }
    /// Edge and its rate; u contains the time and the jump.
    fn edge(stop: &Stop, u: &[f64]) -> (f64, f64) {
        let [size, omega, phase] = stop.shake;
        let angle = omega * u[0] + phase;
        (stop.edge + u[1] + size * angle.sin(), size * omega * angle.cos())
    }
    fn touches(stop: &Stop) -> Piece {
        if stop.below { Piece::Lower } else { Piece::Upper }
    }
    /// q'' with every stop on a given piece.
    fn held(&self, pieces: impl Fn(usize) -> Piece, u: &[f64], q: f64, v: f64) -> f64 {
        self.all.iter().enumerate().fold(self.pull, |a, (i, stop)| {
            let (edge, rate) = Stops::edge(stop, u);
            let touches = pieces(i) == Stops::touches(stop);
            a - if touches { stop.stiffness * (q - edge) + stop.damping * (v - rate) } else { 0.0 }
        })
    }
    fn of(stop: &Stop, u: &[f64], q: f64, v: f64) -> Contact {
        let (edge, rate) = Stops::edge(stop, u);
        let contact = Contact { deflection: q, rate: v, ..Contact::default() };
        if stop.below {
            Contact { lower: edge, lower_rate: rate, ..contact }
        } else {
            Contact { upper: edge, upper_rate: rate, ..contact }
        }
    }
}

impl Model for Stops {
    fn dof(&self) -> usize {
        1
    }
    fn drives(&self) -> usize {
        2
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        u.copy_from_slice(&[t, self.jump(t, side)]);
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        self.jumps.map(|[hold, _]| {
            let k = (t / hold).floor();
            if (k + 1.0) * hold > t { (k + 1.0) * hold } else { (k + 2.0) * hold }
        })
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = self.held(|i| Stops::of(&self.all[i], u, q[0], v[0]).piece(), u, q[0], v[0]);
    }
    fn offers(&self) -> Offers<'_> {
        Offers { pieces: true, expansion: Some(self), ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        self.all.len()
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        for (contact, stop) in out.iter_mut().zip(&self.all) {
            *contact = Stops::of(stop, u, q[0], v[0]);
        }
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = self.held(|i| pieces[i], u, q[0], v[0]);
    }
}

impl Expand for Stops {
    fn record(&self, _: &dyn Fn(usize) -> bool) -> Recorded {
        Recorded::of(1, 2, &|_| None, |every, u, q, v, a| {
            let edges: Vec<_> = self
                .all
                .iter()
                .map(|stop| {
                    let [size, omega, phase] = stop.shake;
                    let (sin, cos) = (u[0] * omega + Node::from(phase)).sin_cos();
                    (u[1] + sin * size + Node::from(stop.edge), cos * (size * omega))
                })
                .collect();
            a[0] = Node::from(self.pull);
            for (i, (stop, &(edge, rate))) in self.all.iter().zip(&edges).enumerate() {
                a[0] = a[0]
                    - every.choice(i, 1, |pieces| match pieces[0] == Stops::touches(stop) {
                        true => (q[0] - edge) * stop.stiffness + (v[0] - rate) * stop.damping,
                        false => Node::from(0.0),
                    });
            }
            let (low, high) = (Node::from(f64::NEG_INFINITY), Node::from(f64::INFINITY));
            let mut contacts = Vec::new();
            for (stop, &(edge, _)) in self.all.iter().zip(&edges) {
                let (lower, upper) = if stop.below { (edge, high) } else { (low, edge) };
                contacts.push(Contact { deflection: q[0], lower, upper, ..Contact::default() });
            }
            contacts
        })
    }
    fn drive_series(&self, t: f64, coefficients: usize, u: &mut [Series]) {
        u.copy_from_slice(&[Series::variable(t, 1.0, coefficients), Series::from(self.jump(t, Side::After))]);
    }
}

/// All crossings with their times, the last state, and the largest penetration of a contact that stood on
/// another piece than its step stated.
#[derive(Clone, Debug)]
struct Seen {
    events: Vec<(f64, Crossing)>,
    end: State,
    astray: f64,
}

impl Seen {
    fn of(solver: &impl Integrator, model: &Stops, start: &State, end: f64) -> Seen {
        let (mut events, mut astray) = (Vec::new(), 0.0f64);
        let mut watch = |step: &mut Step<'_>| {
            events.extend(step.crossings().iter().map(|crossing| (step.t1(), *crossing)));
            let pieces = step.pieces().map(<[Piece]>::to_vec).unwrap_or_default();
            for i in 1..8 {
                let t = step.t0() + (step.t1() - step.t0()) * f64::from(i) / 8.0;
                let (mut y, mut u) = ([0.0; 2], [0.0; 2]);
                step.at(t, &mut y);
                model.drive(t, Side::After, &mut u);
                for (stop, piece) in model.all.iter().zip(&pieces) {
                    let contact = Stops::of(stop, &u, y[0], y[1]);
                    if contact.piece() != *piece {
                        astray = astray.max(contact.penetration().abs());
                    }
                }
            }
            ControlFlow::Continue(())
        };
        let end = solver.run(model, start, end, &mut watch).unwrap().state;
        Seen { events, end, astray }
    }
    /// The same run in parts that end at the times `cuts`.
    fn cut(solver: &impl Integrator, model: &Stops, start: &State, cuts: &[f64]) -> Seen {
        let mut whole = Seen { events: Vec::new(), end: start.clone(), astray: 0.0 };
        for &to in cuts {
            let part = Seen::of(solver, model, &whole.end, to);
            whole.events.extend(part.events);
            (whole.end, whole.astray) = (part.end, whole.astray.max(part.astray));
        }
        whole
    }
    fn times(&self) -> Vec<f64> {
        self.events.iter().map(|event| event.0).collect()
    }
}

/// Calls `check` for every solver; `step` is the fixed step of Rk4.
fn each(step: f64, check: impl Fn(&str, &dyn Fn(&Stops, &State, &[f64]) -> Seen)) {
    let (rk4, rk45, dop853) =
        (Rk4::new(step), Rk45::new().rtol(1e-10).atol(1e-13), Dop853::new().rtol(1e-11).atol(1e-14));
    check("Rk4", &|model, start, cuts| Seen::cut(&rk4, model, start, cuts));
    check("Rk45", &|model, start, cuts| Seen::cut(&rk45, model, start, cuts));
    check("Dop853", &|model, start, cuts| Seen::cut(&dop853, model, start, cuts));
    check("Taylor", &|model, start, cuts| Seen::cut(&Taylor::new(), model, start, cuts));
}

/// Brute force: RK4 with very small steps across the edges. Returns the times at which a penetration changes
/// sign, and the last q and v.
fn brute(model: &Stops, start: &State, end: f64, steps: usize) -> (Vec<f64>, f64, f64) {
    let h = (end - start.t) / steps as f64;
    let (mut q, mut v, mut times) = (start.q[0], start.v[0], Vec::new());
    let accel = |t: f64, q: f64, v: f64| {
        let u = [t, model.jump(t, Side::After)];
        model.held(|i| Stops::of(&model.all[i], &u, q, v).piece(), &u, q, v)
    };
    let depths = |t: f64, q: f64| -> Vec<f64> {
        let u = [t, model.jump(t, Side::After)];
        model.all.iter().map(|stop| Stops::of(stop, &u, q, 0.0).penetration()).collect()
    };
    let mut before = depths(start.t, q);
    for i in 0..steps {
        let t = start.t + h * i as f64;
        let (k1, l1) = (v, accel(t, q, v));
        let (k2, l2) = (v + 0.5 * h * l1, accel(t + 0.5 * h, q + 0.5 * h * k1, v + 0.5 * h * l1));
        let (k3, l3) = (v + 0.5 * h * l2, accel(t + 0.5 * h, q + 0.5 * h * k2, v + 0.5 * h * l2));
        let (k4, l4) = (v + h * l3, accel(t + h, q + h * k3, v + h * l3));
        q += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        v += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
        let after = depths(t + h, q);
        for (a, b) in before.iter().zip(&after) {
            if (*a > 0.0) != (*b > 0.0) {
                times.push(t + h * a / (a - b));
            }
        }
        before = after;
    }
    (times, q, v)
}

/// The first zero of f after t0, by dense sampling and bisection.
fn first_zero(f: impl Fn(f64) -> f64, t0: f64, spacing: f64, until: f64) -> Option<f64> {
    let positive = f(t0) > 0.0;
    let mut lo = t0;
    while lo < until {
        let mut hi = lo + spacing;
        if (f(hi) > 0.0) != positive {
            for _ in 0..80 {
                let middle = 0.5 * (lo + hi);
                if (f(middle) > 0.0) == positive { lo = middle } else { hi = middle }
            }
            return Some(hi);
        }
        lo = hi;
    }
    None
}

/// Checks that times agree one by one.
fn close(name: &str, seen: &[f64], expected: &[f64], within: f64) {
    assert_eq!(seen.len(), expected.len(), "{name}: {seen:?}, expected {expected:?}");
    for (a, b) in seen.iter().zip(expected) {
        assert!((a - b).abs() < within, "{name}: {a} {b} in {seen:?}, expected {expected:?}");
    }
}

/// q'' = -1 above a table E sin ωt. The motion of the table does not enter any error estimate. Returns the
/// number of balls whose first contact is missed or off by more than 1e-8.
fn first_touches(solver: &impl Integrator, omega: f64, balls: usize) -> usize {
    let size = 0.05;
    let mut random = Random(omega as u64);
    let mut missed = 0;
    for _ in 0..balls {
        let (height, speed, phase) = (0.1 + random.next(), 2.0 * random.next() - 1.0, TAU * random.next());
        let table = Stop { below: true, stiffness: 1e4, shake: [size, omega, phase], ..Stop::default() };
        let model = Stops { pull: -1.0, all: vec![table], jumps: None };
        // Above E there is no contact: the parabola reaches E at one time and -E at a later one.
        let reaches = |level: f64| speed + (speed * speed + 2.0 * (height - level)).sqrt();
        let gap = |t: f64| height + speed * t - 0.5 * t * t - size * (omega * t + phase).sin();
        let expected = first_zero(gap, reaches(size), TAU / omega / 500.0, reaches(-size) + 0.1).unwrap();
        let mut touched = f64::NAN;
        let mut watch = |step: &mut Step<'_>| {
            if step.crossings().is_empty() {
                return ControlFlow::Continue(());
            }
            touched = step.t1();
            ControlFlow::Break(())
        };
        solver.run(&model, &State::new(0.0, &[height], &[speed]), 4.0, &mut watch).unwrap();
        missed += usize::from((touched - expected).abs().is_nan() || (touched - expected).abs() > 1e-8);
    }
    missed
}

fn shaking_table(balls: usize) {
    let mut missed = Vec::new();
    for omega in [1.0, 10.0, 100.0, 1000.0] {
        missed.push([
            first_touches(&Rk4::new(0.01), omega, balls),
            first_touches(&Rk45::new(), omega, balls),
            first_touches(&Dop853::new(), omega, balls),
        ]);
    }
    assert_eq!(missed, [[0; 3]; 4], "missed of {balls} at 1, 10, 100, 1000 rad/s, by Rk4, Rk45, Dop853");
}

#[test]
fn a_shaking_table_is_met_at_every_frequency() {
    shaking_table(50);
}

#[test]
#[ignore = "a minute without optimisation: cargo test --release --test suite located_edges_hard_cases -- --ignored"]
fn a_shaking_table_is_met_by_400_balls() {
    shaking_table(400);
}

/// A mass at rest and an edge that comes down, overlaps it by δ and leaves. q is constant; only the edge
/// moves.
#[test]
fn an_edge_that_moves_over_a_mass_at_rest() {
    let model = Stops {
        all: vec![Stop { edge: 1.0, shake: [1.0, 1.0, 0.0], ..Stop::default() }],
        ..Stops::default()
    };
    for depth in [1e-2, 1e-4, 1e-6, 1e-8] {
        // 1 + sin t < q = depth around t = 3π/2 + 2πk, for cos(t - 3π/2) > 1 - depth.
        let half = 2.0 * (0.5 * depth).sqrt().asin();
        let expected: Vec<f64> =
            (0..5).flat_map(|k| [-half, half].map(|s| 0.75 * TAU + TAU * f64::from(k) + s)).collect();
        each(0.02, |name, run| {
            let seen = run(&model, &State::new(0.0, &[depth], &[0.0]), &[5.0 * TAU]);
            close(&format!("{name}, {depth:e}"), &seen.times(), &expected, 1e-10 / half + 1e-9);
            let none = run(&model, &State::new(0.0, &[-depth], &[0.0]), &[5.0 * TAU]);
            assert!(none.events.is_empty(), "{name}: {none:?}");
        });
    }
}

/// A ball that is thrown up to a ceiling and exceeds it by δ, or misses it by δ: the parabola and the contact
/// in closed form.
#[test]
fn a_ball_that_grazes_a_ceiling() {
    let model =
        Stops { pull: -1.0, all: vec![Stop { edge: 1.0, stiffness: 1.0, ..Stop::default() }], jumps: None };
    for depth in [1e-3, 1e-5, 1e-7, 1e-9f64] {
        each(0.005, |name, run| {
            let start = |apex: f64| State::new(0.0, &[0.0], &[(2.0 * apex).sqrt()]);
            let miss = run(&model, &start(1.0 - depth), &[2.5]);
            assert!(miss.events.is_empty(), "{name}: {miss:?}");
            let touch = run(&model, &start(1.0 + depth), &[2.5]);
            // In contact x'' = -1 - x from x = 0 with the speed s = √(2δ); x returns to 0 after 2 atan s.
            let (speed, up) = ((2.0 * depth).sqrt(), (2.0 * (1.0 + depth)).sqrt() - (2.0 * depth).sqrt());
            close(&format!("{name}, {depth:e}"), &touch.times(), &[up, up + 2.0 * speed.atan()], 1e-8);
        });
    }
}

/// Three springs with equal edges and a fourth one within rounding of them act like one spring of their total
/// stiffness.
#[test]
fn several_edges_at_one_place() {
    let stop = |edge: f64, stiffness: f64| Stop { edge, stiffness, ..Stop::default() };
    let four = Stops {
        all: vec![stop(1.0, 1.0), stop(1.0, 3.0), stop(1.0, 4.0), stop(1.0 + 1e-14, 1.0)],
        ..Stops::default()
    };
    let wall = Stop { below: true, edge: -1.0, stiffness: 9.0, ..Stop::default() };
    let both = Stops { all: [four.all.clone(), vec![wall]].concat(), ..four };
    // A flight of 2 takes 2 s, a contact π/3 s on either side.
    let contact = std::f64::consts::PI / 3.0;
    each(2e-3, |name, run| {
        let seen = run(&both, &State::new(0.0, &[0.0], &[1.0]), &[20.0]);
        let mut expected = vec![1.0];
        while expected[expected.len() - 1] < 20.0 {
            let flight = if expected.len() % 2 == 0 { 2.0 } else { contact };
            expected.push(expected[expected.len() - 1] + flight);
        }
        expected.retain(|t| *t < 20.0);
        let mut times = seen.times();
        times.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        close(name, &times, &expected, 1e-7);
        // Entries and exits alternate above (four contacts each) and below (one contact).
        let above = expected.iter().enumerate().filter(|(i, _)| i % 4 < 2).count();
        assert_eq!(seen.events.len(), 4 * above + (expected.len() - above), "{name}: {:?}", seen.events);
        assert!(seen.astray < 1e-9, "{name}: {}", seen.astray);
    });
}

/// A damped ball comes to rest in ever shorter hops, each of them in closed form.
#[test]
fn hops_that_die_out() {
    let (k, c) = (2500.0, 2.0f64);
    let floor = Stop { below: true, stiffness: k, damping: c, ..Stop::default() };
    let model = Stops { pull: -1.0, all: vec![floor], jumps: None };
    let (decay, omega) = (0.5 * c, (k - 0.25 * c * c).sqrt());
    let (mut t, mut speed, mut expected) = (1.0, 1.0, vec![]);
    while t < 60.0 {
        expected.push(t);
        // In contact x = -1/k + e^(-decay s)(cos ωs/k + (decay/k - speed) sin ωs/ω).
        let (a, b) = (1.0 / k, (decay / k - speed) / omega);
        let x = |s: f64| -1.0 / k + (-decay * s).exp() * (a * (omega * s).cos() + b * (omega * s).sin());
        let Some(s) = first_zero(x, 1e-9, 1e-5, 0.2).filter(|s| *s > 1e-8) else {
            break; // the ball no longer lifts off
        };
        let wave = (-decay * s).exp();
        speed = wave
            * ((omega * b - decay * a) * (omega * s).cos() - (omega * a + decay * b) * (omega * s).sin());
        expected.push(t + s);
        t += s + 2.0 * speed;
    }
    assert!(expected.len() > 20 && expected.len() % 2 == 1, "{}", expected.len());
    each(1e-3, |name, run| {
        let seen = run(&model, &State::new(0.0, &[0.5], &[0.0]), &[60.0]);
        close(name, &seen.times(), &expected, if name == "Rk4" { 1e-3 } else { 1e-6 });
        assert!(
            (seen.end.q[0] + 1.0 / k).abs() < 1e-6 && seen.end.v[0].abs() < 1e-4,
            "{name}: {:?}",
            seen.end
        );
    });
}

/// A mass between two moving stops of different frequencies.
fn rattling() -> (Stops, State) {
    let below = Stop { below: true, edge: -0.4, stiffness: 60.0, damping: 0.0, shake: [0.1, 7.0, 0.3] };
    let above = Stop { edge: 0.5, stiffness: 40.0, shake: [0.05, 3.0, 1.0], ..Stop::default() };
    (Stops { pull: -0.3, all: vec![below, above], jumps: None }, State::new(0.0, &[0.0], &[1.2]))
}

#[test]
fn shaken_stops_against_brute_force() {
    let (model, start) = rattling();
    let (times, q, v) = brute(&model, &start, 6.0, 300_000);
    assert!(times.len() >= 8, "{times:?}");
    each(2e-3, |name, run| {
        let seen = run(&model, &start, &[6.0]);
        close(name, &seen.times(), &times, 1e-6);
        assert!(
            (seen.end.q[0] - q).abs() < 1e-6 && (seen.end.v[0] - v).abs() < 1e-5,
            "{name}: {:?}, {q} {v}",
            seen.end
        );
        assert!(seen.astray < 1e-8, "{name}: {}", seen.astray);
    });
}

/// Runs in parts that end at round times, at random times, at every crossing and just beside it: the same
/// crossings and the same last state.
#[test]
fn a_run_in_pieces_is_the_same_run() {
    // Under a constant load alone the distances between impacts are parabolas.
    let floor = Stop { below: true, edge: -0.4, stiffness: 60.0, ..Stop::default() };
    let dropped = Stops { pull: -1.0, all: vec![floor], jumps: None };
    for (model, start) in [rattling(), (dropped, State::new(0.0, &[0.0], &[1.2]))] {
        let mut random = Random(7);
        each(2e-3, |name, run| {
            let whole = run(&model, &start, &[6.0]);
            let round: Vec<f64> = (1..=12).map(|i| 0.5 * f64::from(i)).collect();
            let at: Vec<f64> = [whole.times(), vec![6.0]].concat();
            let beside =
                |by: f64| -> Vec<f64> { whole.times().iter().map(|t| t + by).chain([6.0]).collect() };
            for cuts in [round, at, beside(1e-7), beside(-1e-7), beside(1e-12), beside(-1e-12)] {
                let parts = run(&model, &start, &cuts);
                close(&format!("{name}, cut at {cuts:?}"), &parts.times(), &whole.times(), 1e-7);
                let order = |seen: &Seen| seen.events.iter().map(|event| event.1).collect::<Vec<_>>();
                assert_eq!(order(&parts), order(&whole), "{name}");
                assert!(
                    (parts.end.q[0] - whole.end.q[0]).abs() < 1e-7,
                    "{name}: {:?} {:?}",
                    parts.end,
                    whole.end
                );
            }
        });
        let mut cuts: Vec<f64> = (0..40).map(|_| 6.0 * random.next()).chain([6.0]).collect();
        cuts.sort_by(f64::total_cmp);
        each(2e-3, |name, run| {
            close(name, &run(&model, &start, &cuts).times(), &run(&model, &start, &[6.0]).times(), 1e-7)
        });
    }
}

/// Starts exactly on an edge: towards it, away from it, at rest, and at rest with a load to either side; ends
/// exactly on an edge.
#[test]
fn edges_at_start_and_end() {
    let ceiling = |pull: f64| Stops {
        pull,
        all: vec![Stop { edge: 1.0, stiffness: 4.0, ..Stop::default() }],
        jumps: None,
    };
    let contact = std::f64::consts::FRAC_PI_2;
    each(1e-3, |name, run| {
        let into = run(&ceiling(0.0), &State::new(0.0, &[1.0], &[1.0]), &[3.0]);
        assert!((into.end.q[0] - (1.0 - (3.0 - contact))).abs() < 1e-8, "{name}: {into:?}");
        assert!((into.times()[into.events.len() - 1] - contact).abs() < 1e-8, "{name}: {into:?}");
        let away = run(&ceiling(0.0), &State::new(0.0, &[1.0], &[-1.0]), &[3.0]);
        assert!((away.end.q[0] + 2.0).abs() < 1e-12 && away.events.is_empty(), "{name}: {away:?}");
        let rests = run(&ceiling(0.0), &State::new(0.0, &[1.0], &[0.0]), &[3.0]);
        assert_eq!((rests.end.q[0], rests.events.len()), (1.0, 0), "{name}");
        // With a load into the stop from rest x = (1 - cos 2t)/4; it touches the edge again at π without
        // leaving.
        let pushed = run(&ceiling(1.0), &State::new(0.0, &[1.0], &[0.0]), &[3.0]);
        assert!((pushed.end.q[0] - (1.0 + 0.25 * (1.0 - 6f64.cos()))).abs() < 1e-8, "{name}: {pushed:?}");
        let pulled = run(&ceiling(-1.0), &State::new(0.0, &[1.0], &[0.0]), &[3.0]);
        assert!((pulled.end.q[0] + 3.5).abs() < 1e-8 && pulled.events.is_empty(), "{name}: {pulled:?}");
        // The edge is reached at t = 1, at the end of one run and the start of the next: one crossing in all.
        let met = run(&ceiling(0.0), &State::new(0.0, &[0.0], &[1.0]), &[1.0, 1.0 + contact, 4.0]);
        close(name, &met.times(), &[1.0, 1.0 + contact], 1e-8);
        assert!((met.end.q[0] - (1.0 - (3.0 - contact))).abs() < 1e-7, "{name}: {met:?}");
    });
}

/// A mass starts on an edge that moves as 1 + A sin t, with its velocity. A small acceleration -ε pulls it
/// away: the distance ε t²/2 - A (t - sin t) is positive at first and vanishes near 3ε/A.
/// This is in the middle of a fixed step: a crossing within 1e-10 of its start is not reported.
#[test]
fn a_start_at_rest_on_an_edge_belongs_to_the_piece_into_which_it_moves() {
    let shake = 0.1;
    for pull in [1.117e-3, 3.117e-3, 1.0517e-2] {
        let stop = Stop { edge: 1.0, stiffness: 4.0, shake: [shake, 1.0, 0.0], ..Stop::default() };
        let model = Stops { pull: -pull, all: vec![stop], jumps: None };
        let (mut low, mut high) = (pull / shake, 6.0 * pull / shake);
        for _ in 0..60 {
            let t: f64 = 0.5 * (low + high);
            let apart = 0.5 * pull * t * t - shake * (t - t.sin());
            if apart > 0.0 { low = t } else { high = t }
        }
        // An edge counts as met within 1e-10.
        let close_to = 1e-8 + 2e-10 / (shake * (1.0 - low.cos()) - pull * low);
        each(1e-3, |name, run| {
            let seen = run(&model, &State::new(0.0, &[1.0], &[shake]), &[0.5]);
            close(&format!("{name}, {pull}"), &seen.times(), &[low], close_to);
        });
    }
}

/// An edge that jumps into a mass at rest and back again pushes it in between: parabolas and arcs in closed
/// form.
#[test]
fn edges_that_jump() {
    // The floor is at -0.3 and jumps to 0.2 for every second interval of 0.1 s. The mass at 0 is then pressed
    // by 0.2 with stiffness 100.
    let floor = Stop { below: true, edge: -0.3, stiffness: 100.0, ..Stop::default() };
    let model = Stops { pull: 0.0, all: vec![floor], jumps: Some([0.1, 0.5]) };
    let (w, push) = (10.0f64, 0.2);
    let (q, v) = (push - push * (w * 0.1).cos(), push * w * (w * 0.1).sin());
    each(5e-4, |name, run| {
        let seen = run(&model, &State::new(0.0, &[0.0], &[0.0]), &[0.25]);
        assert!(
            (seen.end.q[0] - (q + 0.05 * v)).abs() < 1e-8 && (seen.end.v[0] - v).abs() < 1e-7,
            "{name}: {:?}",
            seen.end
        );
        assert!(seen.astray < 1e-9, "{name}: {}", seen.astray);
        let parts = run(&model, &State::new(0.0, &[0.0], &[0.0]), &[0.05, 0.1, 0.1 + 1e-9, 0.15, 0.2, 0.25]);
        assert!((parts.end.q[0] - seen.end.q[0]).abs() < 1e-8, "{name}: {:?} {:?}", parts.end, seen.end);
    });
    let (_, q, v) = brute(&model, &State::new(0.0, &[0.0], &[-1.0]), 1.0, 200_000);
    each(1e-3, |name, run| {
        let seen = run(&model, &State::new(0.0, &[0.0], &[-1.0]), &[1.0]);
        assert!(
            (seen.end.q[0] - q).abs() < 1e-3 && (seen.end.v[0] - v).abs() < 1e-2,
            "{name}: {:?}, {q} {v}",
            seen.end
        );
    });
}
