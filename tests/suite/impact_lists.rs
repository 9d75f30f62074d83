//! Lists of impacts: instants, speeds, impulses and the rattle index against closed forms.

use crate::api::*;
use crate::common::FreeDeadZone;
use crate::common::oscillators::Idler;
use std::f64::consts::PI;

/// m x'' = -m g - W above a flank at x = 0, W = -(k y + c y') with the depth y = -x past it. A rigid stop takes
/// the place of the flank if there is a restitution.
pub(crate) struct Ball {
    mass: f64,
    gravity: f64,
    stiffness: f64,
    damping: f64,
    stop: Option<Restitution>,
}

impl Ball {
    fn elastic(mass: f64, gravity: f64, stiffness: f64) -> Self {
        Ball { mass, gravity, stiffness, damping: 0.0, stop: None }
    }
    /// A ball of mass 1 on a rigid floor.
    pub(crate) fn with_stop(gravity: f64, stop: Restitution) -> Self {
        Ball { stop: Some(stop), ..Ball::elastic(1.0, gravity, 0.0) }
    }
    fn force(&self, piece: Piece, x: f64, v: f64) -> f64 {
        if piece == Piece::Lower { self.stiffness * x + self.damping * v } else { 0.0 }
    }
}

impl Model for Ball {
    fn dof(&self) -> usize {
        1
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let piece = if q[0] < 0.0 && self.stop.is_none() { Piece::Lower } else { Piece::Gap };
        self.accel_on_pieces(&[piece], u, q, v, a);
    }
    fn offers(&self) -> Offers<'_> {
        let stops: &[[bool; 2]] = if self.stop.is_some() { &[[true, false]] } else { &[] };
        Offers { pieces: true, stops, ..Offers::default() }
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let free = Contact { deflection: q[0], rate: v[0], lower: 0.0, ..Contact::default() };
        let force = if self.stop.is_some() { 0.0 } else { self.force(free.piece(), q[0], v[0]) };
        out[0] = Contact { force, ..free };
    }
    fn accel_on_pieces(&self, pieces: &[Piece], _: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        a[0] = -self.gravity - self.force(pieces[0], q[0], v[0]) / self.mass;
    }
    fn impact(&self, _: usize, _: Piece, _: &[f64], _: &[f64], v: &mut [f64]) {
        if let Some(restitution) = self.stop {
            v[0] = restitution.rebound(v[0], 0.0);
        }
    }
}

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() < tolerance, "{found} is not {expected}: {:e}", found - expected);
}

/// x'' + g(x) = 0 from x = 0 at x' = 1: flights of 2 between contacts of π on alternate flanks, each with the
/// impulse v_in + v_out = 2.
#[test]
fn a_free_mass_between_two_flanks() {
    fn check<I: Integrator>(solver: &I, tolerance: f64) {
        let model = FreeDeadZone { b: 1.0 };
        let (mut impacts, mut rattle) = (Impacts::new(&model), Rattle::new(&model));
        let (count, turn) = (6, PI + 2.0);
        let end = 1.0 + f64::from(count) * turn;
        solver
            .run(&model, &State::new(0.0, &[0.0], &[1.0]), end - 0.5, &mut (&mut impacts, &mut rattle))
            .unwrap();
        assert_eq!(impacts.all().len(), count as usize);
        assert_eq!(rattle.contacts()[0].impacts, [3, 3]);
        for (k, impact) in impacts.all().iter().enumerate() {
            assert_eq!(impact.flank, if k % 2 == 0 { Piece::Upper } else { Piece::Lower });
            near(impact.t, 1.0 + k as f64 * turn, tolerance);
            near(impact.speed, 1.0, tolerance);
            near(impact.separation.unwrap(), 1.0, tolerance);
            near(impact.impulse.unwrap(), 2.0, tolerance);
            near(impact.duration().unwrap(), PI, tolerance);
            assert_eq!(impact.flight.is_none(), k == 0);
            near(impact.flight.unwrap_or(2.0), 2.0, tolerance);
        }
        let summary = impacts.summaries()[0];
        assert_eq!((summary.count, summary.time), (6, end - 0.5));
        near(summary.rms_speed, 1.0, tolerance);
        near(summary.max_speed, 1.0, tolerance);
        near(summary.rms_impulse.unwrap(), 2.0, tolerance);
        // R = √(n P²/(T τ))/F.
        let expected = (6.0 * 4.0 / (summary.time * 0.5)).sqrt() / 3.0;
        near(summary.rattle_index(3.0, 0.5).unwrap(), expected, tolerance);
    }
    check(&Dop853::new().rtol(1e-12).atol(1e-14), 1e-10);
    check(&Rk45::new().rtol(1e-11).atol(1e-13), 1e-8);
    check(&Rk4::new(0.01), 1e-8);
    // Five samples a step, without located edges: the step across an edge is of order 2.
    check(&Rk4::new(0.002).plain(), 1e-5);
}

/// Damping in contact alone: the ratio of the speeds is exp(-π ζ/√(1 - ζ²)), and the impulse is m (v_in +
/// v_out), although the force jumps at both edges and pulls at the end.
#[test]
fn a_damped_flank() {
    let model = Ball { damping: 6.0, ..Ball::elastic(2.0, 0.0, 50.0) };
    let zeta = 6.0 / (2.0 * (2.0 * 50.0f64).sqrt());
    let omega = 5.0 * (1.0 - zeta * zeta).sqrt();
    let mut impacts = Impacts::new(&model);
    let solver = Dop853::new().rtol(1e-12).atol(1e-14);
    solver.run(&model, &State::new(0.0, &[3.0], &[-1.5]), 4.0, &mut impacts).unwrap();
    let [hit] = impacts.all() else { panic!("{:?}", impacts.all()) };
    let out = 1.5 * (-PI * zeta / (1.0 - zeta * zeta).sqrt()).exp();
    assert_eq!((hit.flank, hit.contact, hit.flight), (Piece::Lower, 0, None));
    near(hit.t, 2.0, 1e-10);
    near(hit.speed, 1.5, 1e-10);
    near(hit.separation.unwrap(), out, 1e-10);
    near(hit.duration().unwrap(), PI / omega, 1e-10);
    near(hit.impulse.unwrap(), 2.0 * (1.5 + out), 1e-10);
}

/// A ball that bounces on a spring: with the contact time t_c the impulse is m (2 v + g t_c), the whole weight
/// over the flight 2 v/g and the contact. The rattle index over the time of a bounce is 1.
#[test]
fn the_load_is_carried_by_impacts() {
    let (m, g, k, v) = (2.0, 10.0, 8e3, 3.0);
    let model = Ball::elastic(m, g, k);
    let omega = (k / m).sqrt();
    let sag = g / (omega * omega);
    let contact = 2.0 * (PI - (v / omega).atan2(sag)) / omega;
    let bounce = contact + 2.0 * v / g;
    let mut impacts = Impacts::new(&model);
    let solver = Dop853::new().rtol(1e-12).atol(1e-15);
    // From the top of a flight to the top of another.
    let top = State::new(0.0, &[v * v / (2.0 * g)], &[0.0]);
    solver.run(&model, &top, 20.0 * bounce, &mut impacts).unwrap();
    assert_eq!(impacts.all().len(), 20);
    for impact in impacts.all() {
        near(impact.impulse.unwrap(), m * g * bounce, 1e-9);
        near(impact.duration().unwrap(), contact, 1e-10);
        near(impact.flight.unwrap_or(2.0 * v / g), 2.0 * v / g, 1e-10);
    }
    let summary = impacts.summaries()[0];
    near(summary.rate(), 1.0 / bounce, 1e-9);
    near(summary.rattle_index(m * g, bounce).unwrap(), 1.0, 1e-9);
    // Two bounces a period, half a bounce a period.
    near(summary.rattle_index(m * g, 2.0 * bounce).unwrap(), 0.5f64.sqrt(), 1e-9);
    near(summary.rattle_index(m * g, 0.5 * bounce).unwrap(), 2.0f64.sqrt(), 1e-9);
}

/// Restitution e: speeds v e^n, flights 2 v e^n/g, impulses m (1 + e) v e^n.
#[test]
fn rigid_stops() {
    let (e, g, v) = (0.6, 10.0, 4.0);
    let model = Ball { stop: Some(Restitution::new(e).unwrap()), ..Ball::elastic(1.5, g, 0.0) };
    let start = State::new(0.0, &[0.0], &[v]);
    let solver = Dop853::new().rtol(1e-12).atol(1e-14);
    // Impacts at 2 v/g (1 + e + e² + ..): 0.8, 1.28, 1.568, 1.7408.
    let mut with_mass = Impacts::new(&model).effective_mass(0, 1.5).unwrap();
    let (mut without, mut rattle) = (Impacts::new(&model), Rattle::new(&model));
    let mut three = (&mut with_mass, &mut without);
    solver.run(&model, &start, 1.8, &mut (&mut three, &mut rattle)).unwrap();
    assert_eq!((with_mass.all().len(), rattle.contacts()[0].impacts), (4, [4, 0]));
    for (n, impact) in with_mass.all().iter().enumerate() {
        let speed = v * e.powi(n as i32);
        near(impact.speed, speed, 1e-10);
        near(impact.separation.unwrap(), e * speed, 1e-10);
        near(impact.impulse.unwrap(), 1.5 * (1.0 + e) * speed, 1e-10);
        near(impact.flight.unwrap_or(2.0 * v / g), 2.0 * speed / g, 1e-10);
        assert_eq!((impact.duration(), impact.flank), (Some(0.0), Piece::Lower));
    }
    let squares: f64 = (0..4).map(|n| (1.5 * 1.6 * v * e.powi(n)).powi(2)).sum();
    near(with_mass.summaries()[0].rms_impulse.unwrap(), (squares / 4.0).sqrt(), 1e-9);
    assert!(without.all().iter().all(|impact| impact.impulse.is_none() && impact.separation.is_some()));
    assert!(matches!(without.summaries()[0].rattle_index(1.0, 1.0), Err(ParameterError::NotSet { .. })));
    // A run that ends with an impact: the speed after it is not known yet. The next run tells it.
    let mut impacts = Impacts::new(&model).effective_mass(0, 1.5).unwrap();
    let mut stop = |step: &mut Step<'_>| {
        if step.crossings().is_empty() {
            std::ops::ControlFlow::Continue(())
        } else {
            std::ops::ControlFlow::Break(())
        }
    };
    let first = solver.run(&model, &start, 1.8, &mut (&mut impacts, &mut stop)).unwrap();
    assert!(first.stopped && impacts.all().len() == 1);
    assert_eq!((impacts.all()[0].separation, impacts.all()[0].impulse), (None, None));
    assert_eq!(impacts.summaries()[0].rms_impulse, Some(0.0));
    solver.run(&model, &first.state, 1.8, &mut impacts).unwrap();
    near(impacts.all()[0].impulse.unwrap(), 1.5 * 1.6 * v, 1e-9);
}

/// Contacts at the start are no impacts; the flight after them is known. At the end of a run the impulse is
/// that so far, and the next run adds the rest.
#[test]
fn runs_that_start_and_end_in_contact() {
    let model = FreeDeadZone { b: 1.0 };
    let solver = Dop853::new().rtol(1e-12).atol(1e-14);
    // From the middle of a contact on the upper flank: it lasts until π/2, the next begins 2 later.
    let start = State::new(0.0, &[2.0], &[0.0]);
    let mut impacts = Impacts::new(&model);
    let end = 0.5 * PI + 2.0 + 0.25 * PI;
    let half = solver.run(&model, &start, end, &mut impacts).unwrap();
    let [hit] = *impacts.all() else { panic!("{:?}", impacts.all()) };
    assert_eq!((hit.flank, hit.left, hit.separation, hit.duration()), (Piece::Lower, None, None, None));
    near(hit.flight.unwrap(), 2.0, 1e-10);
    near(hit.impulse.unwrap(), 1.0 - 0.5f64.sqrt(), 1e-10);
    near(impacts.summaries()[0].time, end, 1e-14);
    // The next run continues the first.
    solver.run(&model, &half.state, 12.0, &mut impacts).unwrap();
    near(impacts.all()[0].impulse.unwrap(), 2.0, 1e-10);
    near(impacts.all()[0].duration().unwrap(), PI, 1e-10);
    near(impacts.all()[1].flight.unwrap(), 2.0, 1e-10);
    // A run from another time is separate: its first flight and the last contact have no end.
    let before = impacts.all().len();
    solver.run(&model, &State::new(100.0, &[0.0], &[1.0]), 102.0, &mut impacts).unwrap();
    solver.run(&model, &State::new(200.0, &[0.0], &[1.0]), 202.0, &mut impacts).unwrap();
    let separate = &impacts.all()[before..];
    assert_eq!(separate.len(), 2);
    for hit in separate {
        assert_eq!((hit.flight, hit.left), (None, None));
        near(hit.impulse.unwrap(), 1.0 - 1f64.cos(), 1e-10);
    }
}

/// The list has as many impacts as `Rattle` counts, and their instants and impulses do not depend on the
/// solver: the face gear pair at 180 rad/s over a turn, with two methods.
#[test]
fn a_rattling_pair_by_two_methods() {
    let pair = NfgPair::new(&NfgParams { speed: 180.0, ..NfgParams::table1() }).unwrap();
    let start = Settle::new()
        .tolerance(1e-7)
        .run(&Dop853::new().rtol(1e-9).atol(1e-14), &pair, &pair.on_drive_flank().unwrap())
        .unwrap()
        .state;
    let end = start.t + pair.period();
    let (mut by_taylor, mut by_dop853, mut rattle) =
        (Impacts::new(&pair), Impacts::new(&pair), Rattle::new(&pair));
    Taylor::new().run(&pair, &start, end, &mut by_taylor).unwrap();
    let solver = Dop853::new().rtol(1e-12).atol(1e-17);
    solver.run(&pair, &start, end, &mut (&mut by_dop853, &mut rattle)).unwrap();
    let (a, b) = (by_taylor.all(), by_dop853.all());
    assert_eq!((a.len(), a.len() as u64), (b.len(), rattle.contacts()[0].impact_count()));
    let period = pair.period() / 63.0;
    let (mut times, mut impulses, mut speeds): (f64, f64, f64) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        assert_eq!((a.flank, a.contact), (b.flank, b.contact));
        times = times.max((a.t - b.t).abs() / period);
        speeds = speeds.max((a.speed / b.speed - 1.0).abs());
        impulses = impulses.max((a.impulse.unwrap() / b.impulse.unwrap() - 1.0).abs());
    }
    let index = by_taylor.summaries()[0].rattle_index(270.27, period).unwrap();
    println!(
        "{} impacts, R = {index}: times {times:.1e}, speeds {speeds:.1e}, impulses {impulses:.1e}",
        a.len()
    );
    assert!(times < 1e-6 && speeds < 1e-5 && impulses < 1e-5);
    assert!(index > 1.0);
}

/// No gap, no edges: nothing separates, nothing is listed.
#[test]
fn without_a_gap_there_are_no_impacts() {
    struct Closed {
        half_backlash: Option<f64>,
    }
    impl Model for Closed {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = -q[0];
        }
        fn contacts(&self) -> usize {
            1
        }
        fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
            let free = Contact { deflection: q[0], rate: v[0], force: q[0], ..Contact::default() };
            out[0] = self.half_backlash.map_or(free, |b| Contact { lower: -b, upper: b, ..free });
        }
    }
    for half_backlash in [None, Some(0.0)] {
        for plain in [true, false] {
            let model = Closed { half_backlash };
            let mut impacts = Impacts::new(&model);
            let solver = if plain { Rk4::new(0.01).plain() } else { Rk4::new(0.01) };
            solver.run(&model, &State::new(0.0, &[1.0], &[0.0]), 20.0, &mut impacts).unwrap();
            assert!(impacts.all().is_empty());
            let summary = impacts.summaries()[0];
            assert_eq!((summary.count, summary.rms_speed, summary.rms_impulse), (0, 0.0, Some(0.0)));
            assert_eq!(summary.rattle_index(1.0, 1.0), Ok(0.0));
        }
    }
}

#[test]
fn refused_input() {
    let model = FreeDeadZone { b: 1.0 };
    for mass in [0.0, -1.0, f64::NAN, 1e60] {
        assert!(Impacts::new(&model).effective_mass(0, mass).is_err(), "{mass}");
    }
    let summary = Impacts::new(&model).summaries()[0];
    assert_eq!((summary.rate(), summary.rattle_index(1.0, 1.0)), (0.0, Ok(0.0)));
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(summary.rattle_index(wrong, 1.0).is_err() && summary.rattle_index(1.0, wrong).is_err());
    }
    let large = ImpactSummary { count: 1, time: 1e-300, rms_impulse: Some(1e300), ..summary };
    assert!(matches!(large.rattle_index(1e-50, 1e-50), Err(ParameterError::Overflow { .. })));
}

/// A mass of 2 and a flank of stiffness 50 whose edge is at `edge` t, or from t = 1 on at -1 + `jump`.
struct MovingFlank {
    edge: f64,
    jump: f64,
}

impl Model for MovingFlank {
    fn dof(&self) -> usize {
        1
    }
    fn drives(&self) -> usize {
        2
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        let jumped = t > 1.0 || (t == 1.0 && side == Side::After);
        u[0] = self.edge * t - 1.0 + if jumped { self.jump } else { 0.0 };
        u[1] = self.edge;
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        (self.jump != 0.0 && t < 1.0).then_some(1.0)
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let mut contact = [Contact::default()];
        self.contact(u, q, v, &mut contact);
        a[0] = -contact[0].force / 2.0;
    }
    fn contacts(&self) -> usize {
        1
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        let force = -50.0 * (u[0] - q[0]).max(0.0);
        out[0] = Contact {
            deflection: q[0],
            rate: v[0],
            lower: u[0],
            lower_rate: u[1],
            force,
            ..Contact::default()
        };
    }
}

/// The speed is that relative to the edge. An edge that jumps onto a mass at rest touches it without speed.
#[test]
fn edges_that_move_and_jump() {
    let solver = Dop853::new().rtol(1e-12).atol(1e-14);
    // The edge comes from -1 at 0.75 towards a mass at 1 that comes at 0.25: they meet at t = 2.
    let model = MovingFlank { edge: 0.75, jump: 0.0 };
    let mut impacts = Impacts::new(&model);
    solver.run(&model, &State::new(0.0, &[1.0], &[-0.25]), 4.0, &mut impacts).unwrap();
    let [hit] = *impacts.all() else { panic!("{:?}", impacts.all()) };
    near(hit.t, 2.0, 1e-11);
    near(hit.speed, 1.0, 1e-11);
    near(hit.separation.unwrap(), 1.0, 1e-11);
    near(hit.impulse.unwrap(), 4.0, 1e-10);
    near(hit.duration().unwrap(), PI / 5.0, 1e-11);
    // At t = 1 the edge jumps 0.5 beyond a mass at rest: a quarter of a period in contact, at the end the speed
    // 0.5·5.
    let model = MovingFlank { edge: 0.0, jump: 1.5 };
    let mut impacts = Impacts::new(&model);
    solver.run(&model, &State::at_rest(1), 3.0, &mut impacts).unwrap();
    let [hit] = *impacts.all() else { panic!("{:?}", impacts.all()) };
    assert_eq!((hit.t, hit.speed, hit.flight), (1.0, 0.0, None));
    near(hit.duration().unwrap(), PI / 10.0, 1e-10);
    near(hit.separation.unwrap(), 2.5, 1e-10);
    near(hit.impulse.unwrap(), 5.0, 1e-10);
}

/// Two contacts that rattle: each has as many impacts in the list as `Rattle` counts, with located edges in
/// order of time, and without located edges nearly the same instants.
#[test]
fn several_contacts() {
    let model = Idler { omega: 1.1, phase: 1.0 };
    let start = State::new(0.0, &[1.8, 0.3], &[0.6, -0.9]);
    let (mut exact, mut rattle) = (Impacts::new(&model), Rattle::new(&model));
    let solver = Dop853::new().rtol(1e-11).atol(1e-13);
    solver.run(&model, &start, 60.0, &mut (&mut exact, &mut rattle)).unwrap();
    assert!(exact.all().windows(2).all(|pair| pair[0].t <= pair[1].t));
    let mut sampled = Impacts::new(&model);
    // Steps across the edges have errors of order 2: 1.0e-5 with the step 1e-3.
    Rk4::new(5e-4).plain().run(&model, &start, 60.0, &mut sampled).unwrap();
    for i in 0..2 {
        let (a, b): (Vec<_>, Vec<_>) = (exact.of(i).collect(), sampled.of(i).collect());
        println!("contact {i}: {} impacts", a.len());
        assert!(a.len() > 5 && a.len() == b.len());
        assert_eq!(a.len() as u64, rattle.contacts()[i].impact_count());
        assert_eq!(exact.summaries()[i].count, a.len() as u64);
        for (a, b) in a.iter().zip(b) {
            assert_eq!((a.flank, a.contact), (b.flank, i));
            near(a.t, b.t, 1e-5);
            near(a.speed, b.speed, 1e-5);
        }
    }
}
