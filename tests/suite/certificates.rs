//! Certificates: known orbits proved, wrong ones refused.

use gear_dynamics::analysis::Rattle;
use gear_dynamics::certify::{Certificate, CertifiedCrossing, Interval, Unproved};
use gear_dynamics::contact::{Backlash, Contact, Deflection, Piece, PieceChoice, Restitution};
use gear_dynamics::excitation::{Angle, Fourier, RectangularWave, Side, earliest};
use gear_dynamics::model::{Channel, Drives, Scalar, Size};
use gear_dynamics::models::ring::RingSet;
use gear_dynamics::ode::Step;
use gear_dynamics::periodic::{ShootingOrbit, Stability};
use gear_dynamics::trains::{Body, Coordinates, Members, MeshPart, Parts, Planetary};
use gear_dynamics::{Budget, Machine, Model, NfgPair, NfgParams, Ring, Settle, Shape, Shooting};
use gear_dynamics::{State, Statistics, Taylor, Wave};
use std::ops::ControlFlow;

/// x'' + 2 ζ x' + k(φ) f(x) + γ x³ = F + A Ω² cos φ with half backlash b, φ = Ω t; without contact if b is 0,
/// with a rigid stop at x = 1 in place of the law if there is a restitution.
#[derive(PartialEq)]
struct Oscillator {
    stiffness: Wave,
    force: Wave,
    law: Option<Backlash>,
    stop: Option<Restitution>,
}

const STOP_ABOVE: [[bool; 2]; 1] = [[false, true]];

impl Shape for Oscillator {
    fn size(&self) -> Size {
        let contacts = usize::from(self.law.is_some() || self.stop.is_some());
        Size { dof: 1, waves: 2, contacts, constants: 6, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        ["speed", "load", "damping ratio", "half backlash", "amplitude", "cubic"]
            .map(|n| Channel::new(n, "1"))
            .into()
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u[0] = self.stiffness.value(angle, side);
        u[1] = self.force.value(angle, side);
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        earliest([self.stiffness.next_edge(angle), self.force.next_edge(angle)])
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let [k, _] = u.waves();
        let [_, _, b, ..] = u.constants::<5>();
        match &self.law {
            Some(of) => {
                let at = Deflection { d: q[0], rate: v[0], lower: -b, upper: b };
                let force = k * law.force(i, of, at);
                Contact { deflection: q[0], rate: v[0], lower: -b, upper: b, force, ..Contact::default() }
            }
            None => Contact { deflection: q[0], rate: v[0], upper: 1.0.into(), ..Contact::default() },
        }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [k, force] = u.waves();
        let [load, zeta, _, amplitude, cubic] = u.constants();
        let elastic = if self.law.is_some() { self.contact(law, 0, u, q, v).force } else { k * q[0] };
        let driven = load + amplitude * u.speed() * u.speed() * force;
        a[0] = driven - zeta * v[0] * 2.0 - elastic - cubic * q[0] * q[0] * q[0];
    }
    fn stops(&self) -> &[[bool; 2]] {
        if self.stop.is_some() { &STOP_ABOVE } else { &[] }
    }
    fn impact<S: Scalar>(&self, _: usize, _: Piece, _: Drives<'_, S>, _: &[S], v: &mut [S]) {
        if let Some(stop) = &self.stop {
            v[0] = stop.rebound(v[0], S::from(0.0));
        }
    }
}

fn cosine(mean: f64, amplitude: f64) -> Wave {
    Wave::new(Fourier::new(mean, &[[amplitude, 0.0]]).unwrap())
}

/// The pair of Kahraman and Singh with a stiffness wave and a force.
fn pair(stiffness: f64, amplitude: f64, speed: f64) -> Machine<Oscillator> {
    let law = Some(Backlash::new(1.0).unwrap());
    let shape = Oscillator { stiffness: cosine(1.0, stiffness), force: cosine(0.0, 1.0), law, stop: None };
    let constants = [
        ("speed", speed),
        ("load", 0.1),
        ("damping ratio", 0.05),
        ("half backlash", 1.0),
        ("amplitude", amplitude),
        ("cubic", 0.0),
    ];
    Machine::of_constants(shape, &constants).unwrap()
}

/// An oscillator without backlash: force A cos φ, damping c q'.
fn smooth(
    stop: Option<Restitution>,
    speed: f64,
    amplitude: f64,
    damping: f64,
    cubic: f64,
) -> Machine<Oscillator> {
    let shape = Oscillator { stiffness: cosine(1.0, 0.0), force: cosine(0.0, 1.0), law: None, stop };
    let constants = [
        ("speed", speed),
        ("load", 0.0),
        ("damping ratio", 0.5 * damping),
        ("half backlash", 0.0),
        ("amplitude", amplitude / (speed * speed)),
        ("cubic", cubic),
    ];
    Machine::of_constants(shape, &constants).unwrap()
}

fn orbit_from(model: &Machine<Oscillator>, x: [f64; 2]) -> ShootingOrbit {
    Shooting::new().solve(model, &[State::new(0.0, &[x[0]], &[x[1]])]).unwrap()
}

/// The points of the reference with their number of crossings and their multipliers: both branches, with and
/// without contact loss (the solutions of tests/data/classic_orbits.json, rounded).
#[test]
fn pairs_with_contact_loss_are_proved() {
    let points = [
        (0.0, 0.05, 0.75, [1.162_450_436_161_778, 0.008_029_341_792_232_577], 0, Stability::Stable),
        (0.0, 0.05, 0.75, [1.2287, 0.1647], 2, Stability::Unstable),
        (0.0, 0.05, 0.75, [0.8338, 0.1641], 2, Stability::Stable),
        (0.0, 0.05, 0.8, [1.245, 0.0749], 2, Stability::Unstable),
        (0.0, 0.05, 0.8, [0.8252, 0.1246], 2, Stability::Stable),
        (0.0, 0.05, 1.0, [0.906, 0.0558], 2, Stability::Stable),
        (-0.2, 0.0, 0.85, [1.1726, 0.0165], 0, Stability::Stable),
        (-0.2, 0.0, 0.85, [1.1976, 0.1324], 2, Stability::Unstable),
        (-0.2, 0.0, 0.85, [1.0582, 0.1692], 2, Stability::Stable),
        (-0.2, 0.0, 0.9, [1.1975, 0.0359], 0, Stability::Stable),
        (-0.2, 0.0, 0.9, [1.2135, 0.0611], 2, Stability::Unstable),
        (-0.2, 0.0, 0.9, [1.0067, 0.1343], 2, Stability::Stable),
        (-0.2, 0.0, 1.0, [0.9988, 0.0844], 2, Stability::Stable),
    ];
    for (stiffness, amplitude, speed, x, crossings, stability) in points {
        let model = pair(stiffness, amplitude, speed);
        let orbit = orbit_from(&model, x);
        let certificate = orbit.certify(&model).unwrap_or_else(|error| panic!("{speed} {x:?}: {error}"));
        assert!(certificate.radius() <= 1e-10, "{speed} {x:?}: {:e}", certificate.radius());
        assert_eq!(certificate.crossings().len(), crossings, "{speed} {x:?}");
        assert_eq!(certificate.stability(), stability, "{speed} {x:?}");
        for multiplier in orbit.multipliers().values() {
            let near = |disc: &gear_dynamics::certify::Disc| {
                (disc.re - multiplier.re).hypot(disc.im - multiplier.im) <= disc.radius + 1e-9
            };
            assert!(
                certificate.multipliers().iter().any(near),
                "{multiplier} of {:?}",
                certificate.multipliers()
            );
        }
        assert_eq!(certificate.check(&model), Ok(()));
    }
}

/// Closed form: x = Re X e^(iΩt) with X = A/(1 - Ω² + i c Ω), multipliers e^((-c/2 ± i √(1 - c²/4)) T).
#[test]
fn the_linear_oscillator_lies_in_its_boxes() {
    let (speed, amplitude, damping) = (0.7, 0.3, 0.1);
    let model = smooth(None, speed, amplitude, damping, 0.0);
    let certificate = orbit_from(&model, [0.1, 0.1]).certify(&model).unwrap();
    assert!(certificate.radius() <= 1e-12);
    let (re, im) = (1.0 - speed * speed, damping * speed);
    let size = amplitude / (re * re + im * im);
    for (i, t) in certificate.times().into_iter().enumerate() {
        let (sin, cos) = (speed * t).sin_cos();
        let exact = [size * (re * cos + im * sin), size * speed * (im * cos - re * sin)];
        for (of, exact) in certificate.states()[i].iter().zip(exact) {
            // The closed form is rounded, too.
            let around = *of + Interval::new(-1e-15, 1e-15).unwrap();
            assert!(around.contains(exact), "t = {t}: {exact} in {of}");
        }
    }
    let period = std::f64::consts::TAU / speed;
    assert!(certificate.period().contains(period));
    let (decay, turn) = ((-0.5 * damping * period).exp(), (1.0 - 0.25 * damping * damping).sqrt() * period);
    for disc in certificate.multipliers() {
        assert!(disc.radius < 1e-10);
        let (re, im) = (decay * turn.cos(), decay * turn.sin().abs());
        assert!((disc.re - re).hypot(disc.im.abs() - im) <= disc.radius + 1e-14, "{disc:?}");
    }
}

#[test]
fn a_duffing_oscillator_is_proved() {
    let model = smooth(None, 1.3, 0.4, 0.2, 0.5);
    let certificate = orbit_from(&model, [0.3, 0.1]).certify(&model).unwrap();
    assert!(certificate.radius() <= 1e-12);
    // Liouville: the product of the multipliers is e^(-c T).
    let [a, b] = certificate.multipliers() else { panic!("two multipliers") };
    let product = a.re * b.re - a.im * b.im;
    assert!((product - (-0.2 * std::f64::consts::TAU / 1.3).exp()).abs() < 1e-10);
}

/// x'' + 0.1 x' + x = A cos Ωt with a stop at 1: one impact in one period and in two
/// (tests/data/impacts.json).
#[test]
fn impacts_are_proved() {
    let stop = Some(Restitution::new(0.8).unwrap());
    for (speed, amplitude, multiple, v) in
        [(0.8, 1.0, 1, -1.472_8), (1.2, 1.0, 1, -1.618_1), (0.8, 0.5175, 2, -0.37)]
    {
        let model = smooth(stop, speed, amplitude, 0.1, 0.0);
        let start = State::new(0.0, &[0.9], &[v]);
        let start = match Settle::new().tolerance(1e-6).max_period_multiple(multiple).run(
            &Taylor::new(),
            &model,
            &start,
        ) {
            Ok(settled) => settled.state,
            Err(error) => error.last().cloned().unwrap(),
        };
        let orbit = Shooting::new().period_multiple(multiple).solve(&model, &[start]).unwrap();
        let certificate = orbit.certify(&model).unwrap();
        assert_eq!(certificate.crossings().len(), multiple);
        assert_eq!(certificate.stability(), Stability::Stable);
        assert!(certificate.radius() < 1e-10, "{:e}", certificate.radius());
        certificate.check(&model).unwrap();
    }
}

/// Planets in phase cross together; with damping in contact alone the forces jump there.
#[test]
fn a_planetary_set_is_proved_with_crossings_in_phase() {
    let wave = |k: f64| Wave::new(Fourier::new(k, &[[0.2 * k, 0.0]]).unwrap());
    let members = || Members {
        sun: (30, Body::new(1e-3)),
        planet: (30, Body::new(1e-3)),
        ring: (90, Body::new(5e-2).locked()),
        carrier: Body::new(3e-2),
    };
    let at = |speed: f64| {
        let set = Planetary::new(3, 0.03, members(), [wave(2e8), wave(2.5e8)]).unwrap();
        let set = set.damping(700.0).half_backlash(3e-5);
        set.parts().torque("drive", "sun", 80.0).load("carrier").build("sun", speed).unwrap()
    };
    let certified = |speed: f64| {
        let train = at(speed);
        let settled = Settle::new().tolerance(1e-6).run(&Taylor::new(), &train, None).unwrap();
        Shooting::new().solve(&train, &[settled.state]).unwrap().certify(&train)
    };
    let certificate = certified(400.0).unwrap();
    assert_eq!((certificate.crossings().len(), certificate.stability()), (0, Stability::Stable));
    let certificate = certified(1300.0).unwrap();
    assert!(certificate.radius() < 1e-10);
    assert_eq!((certificate.crossings().len() % 3, certificate.stability()), (0, Stability::Stable));
    assert!(!certificate.crossings().is_empty());
    // The three planets cross within one window each time.
    for three in certificate.crossings().chunks(3) {
        assert!(three.iter().all(|c| c.time == three[0].time && c.to == three[0].to));
        assert!(three[0].time.width() < 1e-9 * certificate.period().middle());
    }
    certificate.check(&at(1300.0)).unwrap();
}

/// In the angles of all bodies the set has a rigid motion, of which a mesh of planets moves three angles.
#[test]
fn inertial_coordinates_have_the_orbit_of_relative_ones() {
    let wave = |k: f64| cosine(k, 0.2 * k);
    let train = |coordinates| {
        let members = Members {
            sun: (30, Body::new(1e-3)),
            planet: (30, Body::new(1e-3)),
            ring: (90, Body::new(5e-2).locked()),
            carrier: Body::new(3e-2),
        };
        let set = Planetary::new(3, 0.03, members, [wave(2e8), wave(2.5e8)]).unwrap();
        let mut parts = set.damping(700.0).half_backlash(3e-5).parts();
        parts.torque("drive", "sun", 80.0).load("carrier").coordinates(coordinates);
        parts.build("sun", 400.0).unwrap()
    };
    let [relative, inertial] = [Coordinates::Relative, Coordinates::Inertial].map(|coordinates| {
        let train = train(coordinates);
        let orbit = Shooting::new().solve(&train, None).unwrap();
        (train.dof(), orbit.certify(&train).unwrap())
    });
    assert_eq!((relative.0 + 1, relative.1.relative_to()), (inertial.0, None));
    assert!(inertial.1.relative_to().is_some());
    assert_eq!(relative.1.stability(), inertial.1.stability());
    assert_eq!(relative.1.multipliers().len(), inertial.1.multipliers().len());
}

/// A shaft that is driven at a constant speed by way of a spring, with a mesh that loses contact.
#[test]
fn a_train_on_a_driven_shaft_is_proved() {
    let mut parts = Parts::new();
    parts.body("motor side", Body::new(2e-3).restrained(2e5, 5.0)).body("wheel", Body::new(8e-3));
    let mesh =
        MeshPart::external([20, 40], [0.03, 0.06], cosine(2e8, 5e7)).damping(900.0).half_backlash(2e-5);
    parts.mesh("mesh", "motor side", "wheel", mesh).torque("load", "wheel", -60.0);
    let train = parts.build("motor side", 600.0).unwrap();
    let settled = Settle::new().tolerance(1e-6).run(&Taylor::new(), &train, None).unwrap();
    let orbit = Shooting::new().solve(&train, &[settled.state]).unwrap();
    let certificate = orbit.certify(&train).unwrap();
    assert_eq!((certificate.relative_to(), certificate.stability()), (None, Stability::Stable));
    assert_eq!(certificate.crossings().len() as u64, orbit.crossing_count());
    certificate.check(&train).unwrap();
}

/// q'' + 0.1 q' + q = cos φ with a stop at 1 + B sin φ.
#[derive(PartialEq)]
struct MovingStop {
    force: Wave,
    edge: Wave,
    restitution: Restitution,
}

impl Shape for MovingStop {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 3, contacts: 1, constants: 1, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1")]
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        let edge = self.edge.jet(angle, side);
        u[0] = self.force.value(angle, side);
        (u[1], u[2]) = (edge.value, edge.rate);
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        _: &L,
        _: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let [_, upper, rate] = u.waves();
        let upper_rate = u.speed() * rate;
        let lower = S::from(f64::NEG_INFINITY);
        Contact { deflection: q[0], rate: v[0], lower, upper, upper_rate, ..Contact::default() }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [force, ..] = u.waves::<3>();
        a[0] = force - v[0] * 0.1 - q[0];
    }
    fn stops(&self) -> &[[bool; 2]] {
        &STOP_ABOVE
    }
    fn impact<S: Scalar>(&self, _: usize, _: Piece, u: Drives<'_, S>, _: &[S], v: &mut [S]) {
        let [_, _, rate] = u.waves();
        v[0] = self.restitution.rebound(v[0], u.speed() * rate);
    }
}

/// det ∂x(T)/∂x(0) = e² exp(-c T) for one impact on a stop, whether it moves or not.
#[test]
fn impacts_on_a_moving_stop_are_proved() {
    let shape = MovingStop {
        force: cosine(0.0, 1.0),
        edge: Wave::new(Fourier::new(1.0, &[[0.0, 0.05]]).unwrap()),
        restitution: Restitution::new(0.8).unwrap(),
    };
    let model = Machine::of_constants(shape, &[("speed", 0.8)]).unwrap();
    let start = State::new(0.0, &[0.9], &[-1.5]);
    let settled = Settle::new().tolerance(1e-6).run(&Taylor::new(), &model, &start).unwrap();
    let orbit = Shooting::new().solve(&model, &[settled.state]).unwrap();
    let certificate = orbit.certify(&model).unwrap();
    assert_eq!((certificate.crossings().len(), certificate.stability()), (1, Stability::Stable));
    assert!(certificate.radius() < 1e-10);
    certificate.check(&model).unwrap();
    let [a, b] = certificate.multipliers() else { panic!("two multipliers") };
    let product = a.re * b.re - a.im * b.im;
    let exact = 0.64 * (-0.1 * std::f64::consts::TAU / 0.8).exp();
    assert!((product - exact).abs() < 1e-9, "{product} {exact}");
    for multiplier in orbit.multipliers().values() {
        let near = |disc: &gear_dynamics::certify::Disc| {
            (disc.re - multiplier.re).hypot(disc.im - multiplier.im) <= disc.radius + 1e-8
        };
        assert!(certificate.multipliers().iter().any(near), "{multiplier}");
    }
}

/// Two oscillators with backlash, q_i'' + 2 ζ q_i' + k(φ) f(q_i) + c (q_i - q_j) = F, the second one with the load
/// F + ε; damping d q_i' in contact alone if `released`.
#[derive(PartialEq)]
struct Twins {
    stiffness: Wave,
    law: Backlash,
    released: bool,
}

impl Shape for Twins {
    fn size(&self) -> Size {
        Size { dof: 2, waves: 1, contacts: 2, constants: 6, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        ["speed", "load", "damping ratio", "half backlash", "coupling", "difference"]
            .map(|n| Channel::new(n, "1"))
            .into()
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u[0] = self.stiffness.value(angle, side);
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        i: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let ([k], [_, _, b, ..]) = (u.waves(), u.constants::<5>());
        let at = Deflection { d: q[i], rate: v[i], lower: -b, upper: b };
        let force = k * law.force(i, &self.law, at);
        let force = if self.released { force + law.touch(i, at) * v[i] * 0.01 } else { force };
        Contact { deflection: q[i], rate: v[i], lower: -b, upper: b, force, ..Contact::default() }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [load, zeta, _, coupling, difference] = u.constants();
        for i in 0..2 {
            let driven = if i == 0 { load } else { load + difference };
            let force = self.contact(law, i, u, q, v).force;
            a[i] = driven - zeta * v[i] * 2.0 - force - coupling * (q[i] - q[1 - i]);
        }
    }
}

fn twins(released: bool, difference: f64) -> (Machine<Twins>, ShootingOrbit) {
    let shape = Twins { stiffness: cosine(1.0, -0.2), law: Backlash::new(1.0).unwrap(), released };
    let constants = [
        ("speed", 1.0),
        ("load", 0.1),
        ("damping ratio", 0.05),
        ("half backlash", 1.0),
        ("coupling", 0.02),
        ("difference", difference),
    ];
    let model = Machine::of_constants(shape, &constants).unwrap();
    let orbit = Shooting::new().solve(&model, &[State::new(0.0, &[0.9988; 2], &[0.0844; 2])]).unwrap();
    (model, orbit)
}

/// In phase each of two coupled oscillators moves as one alone. Their crossings have no order; those of unequal
/// ones have one that is not found.
#[test]
fn twins_that_cross_together_are_proved() {
    let single = pair(-0.2, 0.0, 1.0);
    let alone = orbit_from(&single, [0.9988, 0.0844]);
    for difference in [0.0, 1e-13, -3e-12] {
        let (model, orbit) = twins(false, difference);
        let certificate = orbit.certify(&model).unwrap();
        assert_eq!((certificate.crossings().len(), certificate.stability()), (4, Stability::Stable));
        assert!(certificate.radius() < 1e-10, "{:e}", certificate.radius());
        certificate.check(&model).unwrap();
        for multiplier in orbit.multipliers().values() {
            let discs = certificate.multipliers().iter();
            let near = |disc: &gear_dynamics::certify::Disc| {
                (disc.re - multiplier.re).hypot(disc.im - multiplier.im) <= disc.radius + 1e-8
            };
            assert!(discs.clone().any(near), "{multiplier} of {:?}", certificate.multipliers());
        }
        for (i, t) in certificate.times().into_iter().enumerate() {
            let exact = alone.at(&single, t).unwrap();
            let of = &certificate.states()[i];
            for (k, exact) in [exact.q[0], exact.q[0], exact.v[0], exact.v[0]].into_iter().enumerate() {
                // Shooting has an error of its own, and ε displaces the orbit.
                let room = 1e-11 + 100.0 * difference.abs();
                assert!((of[k].middle() - exact).abs() < room, "t = {t}: {exact} in {}", of[k]);
            }
        }
    }
    let (model, orbit) = twins(true, 0.0);
    assert!(matches!(orbit.certify(&model), Err(Unproved::Jumps { .. })));
}

/// One window contains the crossings of all pairs within a tolerance, whichever of the two is first.
#[test]
fn windows_contain_both_orders() {
    let (model, orbit) = twins(false, 0.0);
    let tolerance = [("difference", Interval::around(0.0, 1e-10).unwrap())];
    let wide = orbit.certify_with(&model, &tolerance).unwrap();
    wide.check(&model).unwrap();
    for difference in [-1e-10, 1e-10] {
        let (model, orbit) = twins(false, difference);
        let mut times = Vec::new();
        let mut collect = |step: &mut Step<'_>| {
            times.extend(step.crossings().iter().map(|c| (c.contact, step.t1())));
            ControlFlow::Continue(())
        };
        orbit.observe(&model, &mut collect).unwrap();
        assert_eq!(times.len(), 4);
        for (contact, t) in times {
            let turn = orbit.period();
            let same = |c: &&CertifiedCrossing| {
                let apart = (t - c.time.middle()).rem_euclid(turn);
                c.contact == contact && apart.min(turn - apart) <= 0.5 * c.time.width() + 1e-13 * turn
            };
            assert!(wide.crossings().iter().any(|c| same(&c)), "{contact} at {t} in {:?}", wide.crossings());
        }
        for (i, t) in wide.times().into_iter().enumerate() {
            let exact = orbit.at(&model, t).unwrap();
            for (of, x) in wide.states()[i].iter().zip(exact.q.iter().chain(&exact.v)) {
                // Shooting has an error of its own.
                assert!((of.middle() - x).abs() <= 0.5 * of.width() + 1e-12, "t = {t}: {x} in {of}");
            }
        }
    }
}

/// A change of a stored certificate.
type Change<'c> = &'c dyn Fn(&mut serde_json::Value);

/// Windows with changed times, contacts and pieces.
#[test]
fn falsified_windows_do_not_hold() {
    let (model, orbit) = twins(false, 0.0);
    let certificate = orbit.certify(&model).unwrap();
    let stored = serde_json::to_value(&certificate).unwrap();
    let legs = stored["proposal"]["legs"].as_array().unwrap();
    let own = legs.iter().position(|leg| leg["crossings"].as_array().unwrap().len() == 2).unwrap();
    let [low, high] = [0, 1].map(|end| stored["crossings"][0]["time"][end].as_f64().unwrap());
    let middle = 0.5 * (low + high);
    let changes: [(&str, Change); 8] = [
        ("half a window", &|c| c["crossings"][0]["time"] = serde_json::json!([low, middle])),
        ("an instant", &|c| c["crossings"][1]["time"] = serde_json::json!([middle, middle])),
        ("a crossing left out", &|c| _ = c["crossings"].as_array_mut().unwrap().pop()),
        ("another contact", &|c| c["crossings"][0]["contact"] = 1.into()),
        ("a skipped crossing", &|c| {
            _ = c["proposal"]["legs"][own]["crossings"].as_array_mut().unwrap().pop();
        }),
        ("a contact twice", &|c| c["proposal"]["legs"][own]["crossings"][0]["contact"] = 1.into()),
        ("another piece", &|c| c["proposal"]["legs"][own]["crossings"][1]["to"] = "Lower".into()),
        ("another time", &|c| c["proposal"]["legs"][own]["crossings"][0]["near"] = (middle + 1.0).into()),
    ];
    for (name, change) in changes {
        let mut wrong = stored.clone();
        change(&mut wrong);
        assert_ne!(wrong, stored, "{name}");
        let wrong: Certificate = serde_json::from_value(wrong).unwrap();
        assert!(wrong.check(&model).is_err(), "{name}");
    }
    assert!(certificate.check(&twins(false, 1e-6).0).is_err());
    assert!(certificate.check(&twins(true, 0.0).0).is_err());
}

/// A ring in the angles of its bodies closes up to its rigid motion; with the torques of the paper it turns
/// faster and faster.
#[test]
fn rings_are_proved_apart_from_their_rigid_motion() {
    for (speed, loses_contact) in [(1000.0, false), (4000.0, true)] {
        let ring = Ring::as_printed(&RingSet::set_a(3, speed).params().unwrap()).unwrap();
        let orbit = Shooting::new().solve(&ring, None).unwrap();
        let certificate = orbit.certify(&ring).unwrap();
        assert_eq!(certificate.crossings().is_empty(), !loses_contact);
        assert_eq!(certificate.stability(), Stability::Stable);
        assert_eq!(certificate.multipliers().len(), 12);
        assert!(certificate.radius() < 1e-9, "{:e}", certificate.radius());
        certificate.check(&ring).unwrap();
        // The boxes contain the differences of the angles, which are all equal in the rigid motion.
        let k = certificate.relative_to().unwrap();
        let at = orbit.at(&ring, certificate.times()[0]).unwrap();
        for (half, x) in [&at.q, &at.v].into_iter().enumerate() {
            let others = x.iter().enumerate().filter(|(i, _)| *i != k);
            for ((i, other), of) in others.zip(&certificate.states()[0][6 * half..]) {
                // The angles grow, and shooting has an error of its own.
                let error = 0.5 * of.width() + 1e-9 * orbit.range()[7 * half + i] + 1e-13 * x[k].abs();
                assert!((other - x[k] - of.middle()).abs() < error, "{} in {of}", other - x[k]);
            }
        }
        let mut wrong = serde_json::to_value(&certificate).unwrap();
        wrong["proposal"]["relative_to"] = ((k + 1) % 7).into();
        let wrong: Certificate = serde_json::from_value(wrong).unwrap();
        assert!(matches!(wrong.check(&ring), Err(Unproved::Differs { what }) if what.contains("relative")));
    }
}

#[test]
#[ignore = "a minute without optimisation: cargo test --release --test suite face_gear_pairs_are_proved -- --ignored"]
fn face_gear_pairs_are_proved() {
    for (speed, crossings) in [(100.0, 0), (220.0, 252)] {
        let pair = NfgPair::new(&NfgParams { speed, ..NfgParams::table1() }).unwrap();
        let settled = Settle::new().run(&Taylor::new(), &pair, &pair.on_drive_flank().unwrap()).unwrap();
        let certificate = Shooting::new().solve(&pair, &[settled.state]).unwrap().certify(&pair).unwrap();
        assert_eq!((certificate.crossings().len(), certificate.stability()), (crossings, Stability::Stable));
        assert!(certificate.radius() < 1e-10);
    }
}

/// A tolerance of the load is proved for all its values, as far as the boxes stay apart from other motions.
#[test]
fn constants_may_be_intervals() {
    let model = pair(-0.2, 0.0, 1.0);
    let orbit = orbit_from(&model, [0.9988, 0.0844]);
    let load = |radius: f64| [("load", Interval::around(0.1, radius).unwrap())];
    let wide = orbit.certify_with(&model, &load(1e-8)).unwrap();
    for shifted in [0.1 - 1e-8, 0.1 + 1e-8] {
        let other = model.with("load", shifted).unwrap();
        let narrow = orbit_from(&other, [0.9988, 0.0844]);
        let at = narrow.at(&other, wide.times()[0]).unwrap();
        for (of, x) in wide.states()[0].iter().zip(at.q.iter().chain(&at.v)) {
            assert!(of.contains(*x), "{x} in {of}");
        }
    }
    assert!(orbit.certify_with(&model, &load(1e-2)).is_err());
    assert!(matches!(orbit.certify_with(&model, &[("mass", Interval::PI)]), Err(Unproved::Parameter(_))));
}

/// Certificates of other models, and certificates with changed numbers.
#[test]
fn wrong_certificates_do_not_hold() {
    let model = pair(-0.2, 0.0, 1.0);
    let certificate = orbit_from(&model, [0.9988, 0.0844]).certify(&model).unwrap();
    assert!(certificate.check(&model.with("load", 0.1 + 1e-6).unwrap()).is_err());
    assert!(certificate.check(&model.with("speed", 1.0 + 1e-6).unwrap()).is_err());
    let stored = serde_json::to_value(&certificate).unwrap();
    let nodes = stored["proposal"]["nodes"].as_array().unwrap().len();
    for trial in 0..200usize {
        let mut wrong = stored.clone();
        let node = trial % nodes;
        let shift = 1e-6 * (1.0 + (trial as f64 * 0.618_033_988_749_895).fract());
        match trial % 4 {
            0 => {
                wrong["proposal"]["nodes"][node][trial / 4 % 2] =
                    (stored["proposal"]["nodes"][node][trial / 4 % 2].as_f64().unwrap() + shift).into()
            }
            1 => wrong["radii"][node][0] = 1e-19.into(),
            2 => wrong["proposal"]["legs"][node]["pieces"][0] = "Lower".into(),
            _ => wrong["crossings"][trial / 4 % 2]["time"] = serde_json::json!([1.0, 1.0 + shift]),
        }
        let wrong: Certificate = serde_json::from_value(wrong).unwrap();
        assert!(wrong.check(&model).is_err(), "trial {trial}");
    }
}

/// The measured figures of an orbit lie in their intervals; the mean force is the load, the swing of the linear
/// oscillator twice the amplitude of the closed form.
#[test]
fn figures_are_enclosed() {
    let model = pair(-0.2, 0.0, 1.0);
    let orbit = orbit_from(&model, [0.9988, 0.0844]);
    let figures = orbit.certify(&model).unwrap().figures(&model).unwrap();
    let mut statistics = Statistics::new(&model, &["q0", "v0"]).unwrap();
    orbit.observe(&model, &mut statistics).unwrap();
    for (enclosed, name) in figures.peak_to_peak.iter().zip(["q0", "v0"]) {
        let measured = statistics.summary(name).unwrap().peak_to_peak();
        assert!(enclosed.width() < 1e-11 && (enclosed.middle() - measured).abs() < 1e-10, "{enclosed}");
    }
    let mut rattle = Rattle::new(&model);
    orbit.observe(&model, &mut rattle).unwrap();
    let [contact] = figures.contacts[..] else { panic!("one contact") };
    let measured = rattle.contacts()[0].loss_fraction();
    assert!(
        contact.loss_fraction.width() < 1e-11 && (contact.loss_fraction.middle() - measured).abs() < 1e-10
    );
    assert!(contact.mean_force.contains(0.1) && contact.mean_force.width() < 1e-11);

    let (speed, amplitude, damping) = (0.7f64, 0.3, 0.1);
    let model = smooth(None, speed, amplitude, damping, 0.0);
    let figures = orbit_from(&model, [0.1, 0.1]).certify(&model).unwrap().figures(&model).unwrap();
    let swing = 2.0 * amplitude / (1.0 - speed * speed).hypot(damping * speed);
    for (enclosed, exact) in figures.peak_to_peak.iter().zip([swing, speed * swing]) {
        assert!((*enclosed + Interval::new(-1e-15, 1e-15).unwrap()).contains(exact), "{exact} in {enclosed}");
        assert!(enclosed.width() < 1e-11, "{enclosed}");
    }
}

/// No contact is lost for any speed of a range: one branch. A range over the jump to contact loss stays open in
/// part, and the widths say where.
#[test]
fn no_rattle_for_any_speed_of_a_range() {
    let model = pair(-0.2, 0.0, 0.65);
    let orbit = orbit_from(&model, [1.1, 0.0]);
    let proved = orbit.certify_over(&model, "speed", Interval::new(0.6, 0.7).unwrap(), 1e-3).unwrap();
    assert!(proved.open.is_empty(), "{:?}", proved.open);
    let (mut from, mut widest) = (0.6, 0.0f64);
    for (speeds, certificate) in &proved.parts {
        assert_eq!((speeds.low(), certificate.crossings().len()), (from, 0));
        assert_eq!(certificate.check(&model), Ok(()));
        (from, widest) = (speeds.high(), widest.max(speeds.width()));
        // Another speed of the part has its orbit in the boxes.
        let other = model.with("speed", speeds.low()).unwrap();
        let at = orbit_from(&other, [1.1, 0.0]).at(&other, certificate.times()[1]).unwrap();
        for (of, x) in certificate.states()[1].iter().zip([at.q[0], at.v[0]]) {
            assert!(of.contains(x), "{x} in {of}");
        }
    }
    assert!(from == 0.7 && widest > 0.01);

    let lost = orbit.certify_over(&model, "speed", Interval::new(0.6, 1.0).unwrap(), 0.02).unwrap();
    assert!(!lost.open.is_empty() && !lost.parts.is_empty());
    let covered: f64 = lost.parts.iter().map(|(speeds, _)| speeds.high() - speeds.low()).sum();
    let open: f64 = lost.open.iter().map(|(speeds, _)| speeds.high() - speeds.low()).sum();
    assert!((covered + open - 0.4).abs() < 1e-12);
    let range = Interval::new(0.6, 0.7).unwrap();
    assert!(matches!(orbit.certify_over(&model, "mass", range, 1e-3), Err(Unproved::Parameter(_))));
    assert!(matches!(orbit.certify_over(&model, "speed", range, 0.0), Err(Unproved::Parameter(_))));
}

#[test]
fn a_spent_budget_is_named() {
    let model = pair(-0.2, 0.0, 1.0);
    let orbit = orbit_from(&model, [0.9988, 0.0844]).budget(Budget::new().steps(3));
    assert!(matches!(orbit.certify(&model), Err(Unproved::Exhausted { .. })));
}

/// x'' + 0.1 x' + x = A cos Ωt with a stop at 1. The orbit without impact has the amplitude
/// A/√((1 - Ω²)² + (0.1 Ω)²).
#[test]
fn grazing_is_refused_by_name() {
    let stop = Some(Restitution::new(0.8).unwrap());
    let speed = 0.8f64;
    let (re, im) = (1.0 - speed * speed, 0.1 * speed);
    let grazing = re.hypot(im);
    let amplitude = grazing - 1e-9;
    let model = smooth(stop, speed, amplitude, 0.1, 0.0);
    let size = amplitude / (re * re + im * im);
    let orbit = orbit_from(&model, [size * re, size * speed * im]);
    let certificate = orbit.certify(&model).unwrap();
    assert!(certificate.crossings().is_empty() && certificate.radius() < 1e-11);
    let square = speed * speed;
    let over = Interval::around(amplitude / square, 2e-9 / square).unwrap();
    let refused = orbit.certify_with(&model, &[("amplitude", over)]);
    assert!(
        matches!(
            refused,
            Err(Unproved::Leaves { contact: 0, .. } | Unproved::NearGrazing { contact: 0, .. })
        ),
        "{refused:?}"
    );
    let below = Interval::around(amplitude / square, 5e-11 / square).unwrap();
    assert!(orbit.certify_with(&model, &[("amplitude", below)]).is_ok());
}

/// One impact a period with the velocity v at the stop, in closed form: the free motion from the impact to the
/// next, and the forced motion that makes it hit. From v = 0.1 down to 1e-5 the derivative of the orbit grows as
/// 1/v.
#[test]
fn slow_impacts_are_proved_or_refused_by_name() {
    let (speed, damping, restitution) = (0.8f64, 0.1f64, 0.8);
    let (period, decay) = (std::f64::consts::TAU / speed, 0.5 * damping);
    let omega = (1.0 - decay * decay).sqrt();
    for v in [1e-1, 1e-3, 1e-5] {
        // e^(-decay t) (a cos ωt + b sin ωt): the same place at both ends, velocities apart by (1 + r) v.
        let (shrink, [sin, cos]) =
            ((-decay * period).exp(), [(omega * period).sin(), (omega * period).cos()]);
        let [p11, p12] = [1.0 - shrink * cos, -shrink * sin];
        let p21 = shrink * (-decay * cos - omega * sin) + decay;
        let p22 = shrink * (omega * cos - decay * sin) - omega;
        let jump = (1.0 + restitution) * v;
        let determinant = p11 * p22 - p12 * p21;
        let [a, b] = [-p12 * jump / determinant, p11 * jump / determinant];
        let [x, rate] = [1.0 - a, -restitution * v - (omega * b - decay * a)];
        // x cos Ωs + rate/Ω sin Ωs, s after the impact, is the forced motion Re X e^(i(Ωs + ψ)).
        let (re, im) = (1.0 - speed * speed, damping * speed);
        let amplitude = x.hypot(rate / speed) * re.hypot(im);
        let phase = (-rate / speed).atan2(x) + im.atan2(re);
        // The state half a period after the impact.
        let s = 0.5 * period;
        let (e, [sin, cos]) = ((-decay * s).exp(), [(omega * s).sin(), (omega * s).cos()]);
        let free =
            [e * (a * cos + b * sin), e * ((omega * b - decay * a) * cos - (omega * a + decay * b) * sin)];
        let (sin, cos) = (speed * s).sin_cos();
        let forced = [x * cos + rate / speed * sin, rate * cos - x * speed * sin];
        let t = (s + phase / speed).rem_euclid(period);
        let model = smooth(Some(Restitution::new(restitution).unwrap()), speed, amplitude, damping, 0.0);
        let start = State::new(t, &[free[0] + forced[0]], &[free[1] + forced[1]]);
        let orbit = Shooting::new().solve(&model, &[start]).unwrap();
        assert_eq!(orbit.crossing_count(), 1, "v = {v}");
        match orbit.certify(&model) {
            Ok(certificate) => {
                assert!(v >= 1e-3 && certificate.radius() < 1e-10, "v = {v}: {:e}", certificate.radius());
                assert_eq!(
                    (certificate.crossings().len(), certificate.stability()),
                    (1, Stability::Unstable)
                );
            }
            refused => {
                let named = matches!(refused, Err(Unproved::NearGrazing { contact: 0, .. }));
                assert!(v < 1e-3 && named, "v = {v}: {refused:?}");
            }
        }
    }
}

/// Rectangular stiffness: the drive edges are nodes of the chain.
#[test]
fn rectangular_stiffness_is_proved() {
    for (duty, phase, speed) in [(0.6, 0.0, 1.4), (0.6, 1.0, 1.0), (0.25, -2.0, 1.6)] {
        let rectangle = RectangularWave::new(0.9, 1.1, duty).unwrap();
        let of = pair(0.0, 0.0, speed);
        let shape = Oscillator {
            stiffness: Wave::new(rectangle).with_phase(phase).unwrap(),
            force: cosine(0.0, 1.0),
            law: Some(Backlash::new(1.0).unwrap()),
            stop: None,
        };
        let constants: Vec<(&str, f64)> =
            of.names().iter().map(|channel| channel.name.as_str()).zip(of.values().iter().copied()).collect();
        let model = Machine::of_constants(shape, &constants).unwrap();
        let settled = Settle::new().run(&Taylor::new(), &model, &State::new(0.0, &[1.1], &[0.0])).unwrap();
        let orbit = Shooting::new().solve(&model, &[settled.state]).unwrap();
        let certificate = orbit.certify(&model).unwrap_or_else(|error| panic!("{duty} {phase}: {error}"));
        assert!(certificate.radius() < 1e-11, "{:e}", certificate.radius());
        assert_eq!(certificate.crossings().len() as u64, orbit.crossing_count());
        assert_eq!(certificate.check(&model), Ok(()));
        for (t, around) in certificate.times().into_iter().zip(certificate.states()) {
            let at = orbit.at(&model, t).unwrap();
            for (of, x) in around.iter().zip([at.q[0], at.v[0]]) {
                assert!((of.middle() - x).abs() < 1e-10, "t = {t}: {x} in {of}");
            }
        }
        // Edges move with the speed: those of other speeds are not passed over.
        let speeds = Interval::around(speed, 1e-9).unwrap();
        let wide = orbit.certify_with(&model, &[("speed", speeds)]).unwrap();
        assert_eq!(wide.check(&model), Ok(()));
    }
}

/// An almost rigid motion has steps as short as its derivative asks for.
#[test]
fn motions_at_rest_are_proved() {
    let model = smooth(None, 0.1, 1e-14, 0.2, 0.0).with("load", 0.5).unwrap();
    let orbit = orbit_from(&model, [0.5, 0.0]);
    let certificate = orbit.certify(&model).unwrap();
    assert!(certificate.radius() < 1e-11 && certificate.stability() == Stability::Stable);
}

/// Certificates that were forged as a whole: contacts without their edges, and nodes that hide drive edges.
#[test]
fn forged_certificates_are_refused() {
    let changed = |certificate: &Certificate, change: &dyn Fn(&mut serde_json::Value)| -> Certificate {
        let mut stored = serde_json::to_value(certificate).unwrap();
        change(&mut stored);
        serde_json::from_value(stored).unwrap()
    };
    // A free motion of amplitude 2 passes a rigid stop at 1; another one lies beyond it.
    for (load, amplitude) in [(0.0, 1.0), (5.0, 0.1)] {
        let free = smooth(None, 1.0, amplitude, 0.5, 0.0).with("load", load).unwrap();
        let certificate = orbit_from(&free, [load, 0.0]).certify(&free).unwrap();
        let stop = Some(Restitution::new(0.8).unwrap());
        let stopped = smooth(stop, 1.0, amplitude, 0.5, 0.0).with("load", load).unwrap();
        for piece in ["Lower", "Upper", "Gap"] {
            let forged = changed(&certificate, &|stored| {
                for leg in stored["proposal"]["legs"].as_array_mut().unwrap() {
                    leg["pieces"] = serde_json::json!([piece]);
                }
            });
            assert!(forged.check(&stopped).is_err(), "{load} {piece}");
        }
    }
    // A pulse of 10 over a hundredth of a turn is hidden in nodes of a motion at rest, or lies far away.
    let rest = smooth(None, 1.0, 1e-14, 1.0, 0.0).with("load", 0.5).unwrap();
    let shape = Oscillator {
        stiffness: cosine(1.0, 0.0),
        force: Wave::new(RectangularWave::new(0.0, 1.0, 0.01).unwrap()),
        law: None,
        stop: None,
    };
    let constants = [
        ("speed", 1.0),
        ("load", 0.5),
        ("damping ratio", 0.5),
        ("half backlash", 0.0),
        ("amplitude", 10.0),
        ("cubic", 0.0),
    ];
    let pulsed = Machine::of_constants(shape, &constants).unwrap();
    orbit_from(&pulsed, [0.5, 0.0]).certify(&pulsed).unwrap();
    let certificate = orbit_from(&rest, [0.5, 0.0]).certify(&rest).unwrap();
    let period = certificate.period();
    let (turn, edge) = (std::f64::consts::TAU, 0.01 * std::f64::consts::PI);
    let nodes = |from: f64| -> Vec<[f64; 2]> {
        let end = |t: f64, past: f64| [t - past * f64::EPSILON * t, t + past * f64::EPSILON * t];
        let inner = (0..20).map(|i| end(from + turn * i as f64 / 20.0, 0.0));
        inner.chain([end(from + period.middle(), 8.0)]).collect()
    };
    let both = |mut times: Vec<[f64; 2]>| {
        times[10] = [turn - 0.05, turn + 0.05];
        times
    };
    let apart = |mut times: Vec<[f64; 2]>| {
        times[10] = [turn - edge - 1e-6, turn - edge + 1e-6];
        times.insert(11, [turn + edge - 1e-3, turn + edge + 0.08]);
        times
    };
    let last = |mut times: Vec<[f64; 2]>| {
        times.iter_mut().for_each(|time| *time = [time[0] - 0.5 * turn + 0.02, time[1] - 0.5 * turn + 0.02]);
        times[20] = [turn - 0.05, turn + 0.05];
        times
    };
    let half = 0.5 * turn;
    for times in [nodes(half), both(nodes(half)), apart(nodes(half)), last(nodes(half)), nodes(1e13)] {
        let count = times.len() - 1;
        let forged = changed(&certificate, &|stored| {
            let leg = |i: usize| serde_json::json!({"start": times[i], "end": times[i + 1], "pieces": [], "crossings": []});
            stored["proposal"]["legs"] = (0..count).map(leg).collect();
            stored["proposal"]["nodes"] = (0..count).map(|_| serde_json::json!([0.5, 0.0])).collect();
            stored["radii"] = (0..count).map(|_| serde_json::json!([1e-9, 1e-9])).collect();
            stored["multipliers"] = serde_json::json!([]);
        });
        // The motion at rest has such a certificate.
        assert_eq!(forged.check(&rest).is_ok(), times[0][0] < 1e12, "{times:?}");
        assert!(forged.check(&pulsed).is_err(), "{times:?}");
    }
}

/// A certificate that contradicts itself is refused with the name of the check that fails.
#[test]
fn contradictions_are_named() {
    let model = smooth(None, 1.0, 1.0, 0.5, 0.0);
    let certificate = orbit_from(&model, [0.0, 0.0]).certify(&model).unwrap();
    let stored = serde_json::to_value(&certificate).unwrap();
    let last = certificate.times().len() - 1;
    assert!(last > 1);
    type Change<'c> = &'c dyn Fn(&mut serde_json::Value);
    let changes: [(&str, Change<'_>); 6] = [
        ("multiples of the period", &|stored| stored["period"] = serde_json::json!([1.0, 1.0])),
        ("half widths of the boxes has", &|stored| drop(stored["radii"].as_array_mut().unwrap().pop())),
        ("half width of a box is 0.0", &|stored| stored["radii"][0][0] = 0.0.into()),
        ("contact 7 does not exist", &|stored| {
            let event = serde_json::json!({"contact": 7, "to": "Gap", "rebounds": false, "near": 0.1});
            stored["proposal"]["legs"][0]["crossings"] = serde_json::json!([event]);
        }),
        ("times of legs", &|stored| {
            stored["proposal"]["legs"][0]["end"] = stored["proposal"]["legs"][0]["start"].clone();
        }),
        ("first and the last node", &|stored| {
            let legs = &mut stored["proposal"]["legs"];
            legs[last]["end"] = legs[last]["start"].clone();
        }),
    ];
    for (named, change) in changes {
        let mut wrong = stored.clone();
        change(&mut wrong);
        // What contradicts itself is refused when it is read, what contradicts the model when it is checked.
        let what = match serde_json::from_value::<Certificate>(wrong) {
            Err(error) => error.to_string(),
            Ok(wrong) => match wrong.check(&model) {
                Err(Unproved::Differs { what }) => what,
                other => panic!("{named}: {other:?}"),
            },
        };
        assert!(what.contains(named), "{named}: {what}");
    }
}

/// Random changes of certificates: each is refused, or what it states is still true of the orbit.
#[test]
#[ignore = "a minute: cargo test --release --test suite ten_thousand_false_certificates -- --ignored"]
fn ten_thousand_false_certificates() {
    let stop = Some(Restitution::new(0.8).unwrap());
    let models = [
        (pair(-0.2, 0.0, 1.0), [0.9988, 0.0844], "load"),
        (pair(0.0, 0.05, 0.75), [1.2287, 0.1647], "amplitude"),
        (pair(-0.2, 0.0, 0.85), [1.1726, 0.0165], "damping ratio"),
        (smooth(stop, 0.8, 1.0, 0.1, 0.0), [0.9, -1.4728], "speed"),
        (smooth(None, 1.3, 0.4, 0.2, 0.5), [0.3, 0.1], "cubic"),
    ];
    let mut seed = 1u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let (mut refused, mut true_ones) = (0, 0);
    for (model, x, constant) in &models {
        let start = State::new(0.0, &[x[0]], &[x[1]]);
        let settled = Settle::new().run(&Taylor::new(), model, &start);
        let orbit = match model.shape().stop {
            Some(_) => Shooting::new().solve(model, &[settled.unwrap().state]).unwrap(),
            None => orbit_from(model, *x),
        };
        let certificate = orbit.certify(model).unwrap();
        let stored = serde_json::to_value(&certificate).unwrap();
        let others = [-1e-6, 1e-6].map(|by| {
            let value = model.values()[model.names().iter().position(|n| n.name == *constant).unwrap()];
            (value + by, model.with(constant, value + by).unwrap())
        });
        let count = certificate.times().len();
        for trial in 0..2200 {
            let mut wrong = stored.clone();
            let node = (random() * count as f64) as usize;
            let component = (random() * 2.0) as usize;
            let sign = if random() < 0.5 { -1.0 } else { 1.0 };
            let shift = sign * 10f64.powf(-4.0 - 9.0 * random());
            let add = |value: &mut serde_json::Value, by: f64| *value = (value.as_f64().unwrap() + by).into();
            let with_event: Vec<usize> = (0..count)
                .filter(|i| !stored["proposal"]["legs"][*i]["crossings"].as_array().unwrap().is_empty())
                .collect();
            let hit = with_event.get((random() * with_event.len() as f64) as usize).copied();
            let mut of = model;
            let mut never = false;
            match (trial % 14, hit) {
                (0, _) => {
                    add(&mut wrong["proposal"]["nodes"][node][component], sign * 1e-6 * (1.0 + random()));
                    never = true;
                }
                (1, _) => add(&mut wrong["proposal"]["nodes"][node][component], 1e-4 * shift),
                (2, _) => {
                    let factor = 10f64.powf(12.0 * random() - 6.0);
                    let radius = &mut wrong["radii"][node][component];
                    *radius = (factor * radius.as_f64().unwrap()).into();
                }
                (3, _) => {
                    let factor = 10f64.powf(8.0 * random() - 2.0);
                    for radius in wrong["radii"]
                        .as_array_mut()
                        .unwrap()
                        .iter_mut()
                        .flat_map(|r| r.as_array_mut().unwrap())
                    {
                        *radius = (factor * radius.as_f64().unwrap()).into();
                    }
                }
                (4, _) if stored["proposal"]["legs"][0]["pieces"].as_array().unwrap().is_empty() => {
                    wrong["proposal"]["legs"][node]["pieces"] = serde_json::json!(["Gap"]);
                    never = true;
                }
                (4, _) => {
                    let old = stored["proposal"]["legs"][node]["pieces"][0].as_str().unwrap();
                    let all = ["Lower", "Gap", "Upper"];
                    let new = all.into_iter().filter(|piece| *piece != old).nth(component).unwrap();
                    wrong["proposal"]["legs"][node]["pieces"][0] = new.into();
                    never = true;
                }
                (5, Some(_)) => {
                    let which = (random() * with_event.len() as f64) as usize;
                    for end in 0..2 {
                        add(&mut wrong["crossings"][which]["time"][end], shift);
                    }
                }
                (6, Some(_)) => {
                    wrong["crossings"].as_array_mut().unwrap().pop();
                    never = true;
                }
                (7, Some(_)) => {
                    let list = wrong["crossings"].as_array_mut().unwrap();
                    list.push(list[0].clone());
                    never = true;
                }
                (8, Some(hit)) => {
                    // The crossing is skipped, in the legs and in the list.
                    wrong["proposal"]["legs"][hit]["crossings"] = serde_json::json!([]);
                    let which = with_event.iter().position(|i| *i == hit).unwrap();
                    wrong["crossings"].as_array_mut().unwrap().remove(which);
                    never = true;
                }
                (9, Some(hit)) => match component {
                    0 => {
                        let old =
                            wrong["proposal"]["legs"][hit]["crossings"][0]["rebounds"].as_bool().unwrap();
                        wrong["proposal"]["legs"][hit]["crossings"][0]["rebounds"] = (!old).into();
                        never = true;
                    }
                    _ => add(&mut wrong["proposal"]["legs"][hit]["crossings"][0]["near"], shift),
                },
                (10, _) => {
                    let disc = &mut wrong["multipliers"][component];
                    match random() < 0.5 {
                        true => add(&mut disc["re"], shift),
                        false => disc["radius"] = (disc["radius"].as_f64().unwrap() * 2.0 * random()).into(),
                    }
                }
                (11, _) => {
                    let end = component;
                    add(&mut wrong["period"][end], shift);
                }
                (12, _) => {
                    let next = (node + 1) % count;
                    for end in 0..2 {
                        add(&mut wrong["proposal"]["legs"][node]["end"][end], shift);
                        add(&mut wrong["proposal"]["legs"][next]["start"][end], shift);
                    }
                }
                (_, _) => {
                    let (value, other) = &others[component];
                    match random() < 0.5 {
                        true => wrong["constants"] = serde_json::json!([[constant, [value, value]]]),
                        false => of = other,
                    }
                    never = true;
                }
            }
            // Ends out of order or names that do not exist are refused when they are read.
            let Ok(wrong) = serde_json::from_value::<Certificate>(wrong) else { continue };
            if wrong == certificate && !never {
                continue;
            }
            if wrong.check(of).is_err() {
                refused += 1;
                continue;
            }
            assert!(!never, "trial {trial} of {constant}");
            true_ones += 1;
            is_true(&wrong, &certificate, &orbit, model);
        }
    }
    println!("{refused} refused, {true_ones} true");
    assert!(refused + true_ones >= 10_000);
}

/// Whether what a certificate states is true of the orbit, up to the accuracy of shooting.
fn is_true(stated: &Certificate, known: &Certificate, orbit: &ShootingOrbit, model: &Machine<Oscillator>) {
    const ACCURACY: f64 = 1e-10;
    for (t, around) in stated.times().into_iter().zip(stated.states()) {
        let at = orbit.at(model, t).unwrap();
        for (of, x) in around.iter().zip([at.q[0], at.v[0]]) {
            assert!(of.low() - ACCURACY <= x && x <= of.high() + ACCURACY, "t = {t}: {x} in {of}");
        }
    }
    assert!(stated.period().contains(known.period().middle()));
    assert_eq!(stated.crossings().len(), known.crossings().len());
    for (stated, known) in stated.crossings().iter().zip(known.crossings()) {
        assert_eq!((stated.contact, stated.to), (known.contact, known.to));
        assert!(stated.time.common(known.time).is_some(), "{stated:?} {known:?}");
    }
    for multiplier in orbit.multipliers().values() {
        let near = |disc: &gear_dynamics::certify::Disc| {
            (disc.re - multiplier.re).hypot(disc.im - multiplier.im) <= disc.radius + 1e-9
        };
        assert!(stated.multipliers().iter().any(near), "{multiplier}");
    }
}
