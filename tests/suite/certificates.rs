//! Certificates: known orbits proved, wrong ones refused.

use gear_dynamics::certify::{Certificate, Interval, Unproved};
use gear_dynamics::contact::{Backlash, Contact, Deflection, Piece, PieceChoice, Restitution};
use gear_dynamics::excitation::{Angle, Fourier, Side};
use gear_dynamics::model::{Channel, Drives, Scalar, Size};
use gear_dynamics::models::ring::RingSet;
use gear_dynamics::periodic::{ShootingOrbit, Stability};
use gear_dynamics::trains::{Body, Members, Planetary};
use gear_dynamics::{Machine, NfgPair, NfgParams, Ring, Settle, Shape, Shooting, State, Taylor, Wave};

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
                let at = Deflection { x: q[0], rate: v[0], lower: -b, upper: b };
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
        for (of, exact) in certificate.state(i).iter().zip(exact) {
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

#[test]
fn a_planetary_set_is_proved_and_crossings_in_phase_are_refused() {
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
    assert!(matches!(certified(1300.0), Err(Unproved::Together { .. })));
}

#[test]
fn rigid_motions_are_refused() {
    let ring = Ring::as_printed(&RingSet::set_a(3, 1000.0).params().unwrap()).unwrap();
    let orbit = Shooting::new().solve(&ring, None).unwrap();
    assert_eq!(orbit.certify(&ring), Err(Unproved::RigidMotion));
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
        for (of, x) in wide.state(0).iter().zip(at.q.iter().chain(&at.v)) {
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
