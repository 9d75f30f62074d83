//! Drive edges close to one another and to knots of a speed law: none is passed over.

use crate::api::*;
use crate::common::random::Random;
use gear_dynamics::contact::PieceChoice;
use gear_dynamics::model::{Drives, Scalar, Size};
use gear_dynamics::{Machine, Shape};
use std::f64::consts::{PI, TAU};

/// q'' = Σ f_i(φ) with waves that are 1 on a share of their period and 0 elsewhere.
#[derive(PartialEq, Debug, Clone)]
struct Pulses {
    waves: Vec<Wave>,
    /// Order, phase and share of each wave.
    known: Vec<(u32, f64, f64)>,
}

impl Pulses {
    fn new(known: &[(u32, f64, f64)]) -> Self {
        let wave = |&(order, phase, share): &(u32, f64, f64)| {
            let pulse = Wave::new(RectangularWave::new(0.0, 1.0, share).unwrap());
            pulse.per_turn(order).unwrap().with_phase(phase).unwrap()
        };
        Pulses { waves: known.iter().map(wave).collect(), known: known.to_vec() }
    }
    /// ∫ Σ f_i dt up to the angle `end`, with the time t(φ).
    fn integral(&self, end: f64, time: impl Fn(f64) -> f64) -> f64 {
        let of_wave = |&(order, phase, share): &(u32, f64, f64)| {
            let (n, half) = (f64::from(order), PI * share);
            let last = ((n * end + phase) / TAU).ceil() as i64 + 1;
            let pulse = |k: i64| {
                let centre = TAU * k as f64 - phase;
                let [from, to] = [centre - half, centre + half].map(|own| (own / n).clamp(0.0, end));
                time(to) - time(from)
            };
            (-1..=last).map(pulse).sum::<f64>()
        };
        self.known.iter().map(of_wave).sum()
    }
}

impl Shape for Pulses {
    fn size(&self) -> Size {
        Size { dof: 1, waves: self.waves.len(), constants: 1, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "rad/s")]
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        self.waves.iter().zip(u).for_each(|(wave, u)| *u = wave.value(angle, side));
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        earliest(self.waves.iter().map(|wave| wave.next_edge(angle)))
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, _: &[S], _: &[S], a: &mut [S]) {
        a[0] = (0..self.waves.len()).fold(S::from(0.0), |sum, i| sum + u.waves_from::<1>(i)[0]);
    }
}

/// Waves, the second and the third with an edge beside one of the first, and the angle of that edge.
fn beside(random: &mut Random, nearest: f64, farthest: f64) -> (Pulses, f64) {
    let mut draw = || {
        let order = 1 + (random.next() * 6.0) as u32;
        (order, TAU * random.next(), 0.2 + 0.6 * random.next())
    };
    let mut known = [draw(), draw(), draw()];
    let (order, phase, share) = known[0];
    let turns = TAU * (1.0 + (random.next() * 3.0).floor());
    let common = (turns + PI * share - phase) / f64::from(order);
    for (order, phase, share) in &mut known[1..] {
        let apart = nearest * (farthest / nearest).powf(random.next());
        let at = common + if random.next() < 0.5 { apart } else { -apart };
        let edge = if random.next() < 0.5 { PI * *share } else { -PI * *share };
        *phase = (edge - f64::from(*order) * at).rem_euclid(TAU);
    }
    (Pulses::new(&known), common)
}

fn compare(model: &dyn Model, end: f64, expected: f64, within: f64, case: usize) {
    let start = State::at_rest(1);
    let found = [
        ("Taylor", Taylor::new().end(&model, &start, end).unwrap()),
        ("Dop853", Dop853::new().end(&model, &start, end).unwrap()),
    ];
    for (name, state) in found {
        let off = (state.v[0] - expected).abs();
        assert!(off < within, "case {case}, {name}: {} for {expected}, off {off:e}", state.v[0]);
    }
}

#[test]
fn edges_at_constant_speed_are_all_met() {
    let mut random = Random(77);
    for case in 0..3000 {
        let (pulses, common) = beside(&mut random, 1e-14, if case % 2 == 0 { 1e-12 } else { 1e-8 });
        let speed = 0.5 + 3.0 * random.next();
        let (expected, end) = (pulses.integral(common + 1.5, |angle| angle / speed), (common + 1.5) / speed);
        let machine = Machine::of_constants(pulses, &[("speed", speed)]).unwrap();
        compare(&machine, end, expected, 1e-9, case);
    }
}

#[test]
fn edges_under_a_speed_law_are_all_met() {
    let mut random = Random(78);
    for case in 0..1500 {
        let (pulses, common) = beside(&mut random, 1e-13, 1e-8);
        let [from, to] = [0.5 + 2.0 * random.next(), 0.5 + 2.0 * random.next()];
        // A knot beside the edges in every second case.
        let apart = 1e-8 * (random.next() - 0.5) * random.next().powi(4);
        let ramp = if case % 2 == 0 { 2.0 * (common + apart) / (from + to) } else { 3.0 };
        let slope = (to - from) / ramp;
        let knot = 0.5 * (from + to) * ramp;
        let time = |angle: f64| match angle < knot {
            true => 2.0 * angle / (from + (from * from + 2.0 * slope * angle).sqrt()),
            false => ramp + (angle - knot) / to,
        };
        let (expected, end) = (pulses.integral(common + 1.5, time), time(common + 1.5));
        let machine = Machine::of_constants(pulses, &[("speed", 1.0)]).unwrap();
        let law = SpeedLaw::ramp(from, to, ramp).unwrap();
        // Values beside an edge are those within 1e-9 rad.
        compare(&VaryingSpeed::new(machine, law), end, expected, 1e-7, case);
    }
}

/// φ = ω (t + a sin(ft)/f): the times of the angles follow from `SpeedLaw::time`, whose residual is checked.
#[test]
fn edges_under_a_fluctuating_speed_are_all_met() {
    let mut random = Random(79);
    for case in 0..500 {
        let (pulses, common) = beside(&mut random, 1e-13, 1e-8);
        let (speed, swing, frequency) =
            (0.5 + 3.0 * random.next(), 0.95 * random.next(), 0.3 + 5.0 * random.next());
        let law = SpeedLaw::fluctuation(speed, swing, frequency).unwrap();
        let time = |angle: f64| {
            let t = law.time(angle);
            let back = speed * (t + swing * (frequency * t).sin() / frequency);
            assert!((back - angle).abs() < 1e-13 * (1.0 + angle.abs()), "{case}: {back} {angle}");
            t
        };
        let (expected, end) = (pulses.integral(common + 1.5, time), time(common + 1.5));
        let machine = Machine::of_constants(pulses, &[("speed", 1.0)]).unwrap();
        // Values beside an edge are those within 1e-9 rad, at the lowest speed 0.025 rad/s for 4e-8 s.
        compare(&VaryingSpeed::new(machine, law.clone()), end, expected, 2e-7, case);
    }
}

/// After 10⁶ s at 1 rad/s the speed rises to 10⁴ rad/s: the last digit of the time is then 10⁻⁶ rad.
#[test]
fn edges_closer_than_the_digits_of_a_late_time_are_met() {
    let mut random = Random(80);
    for case in 0..50 {
        let (pulses, common) = beside(&mut random, 1e-13, 1e-8);
        let (late, fast, slow) = (1e6, 1e4, 1.0);
        let law = SpeedLaw::table(&[0.0, late, late + 1.0], &[slow, slow, fast]).unwrap();
        let turned = slow * late + 0.5 * (slow + fast);
        let end = late + 1.0 + 40.0 * (common + 1.5) / fast;
        let from = late + 1.0 + 10.0 / fast;
        let time = |angle: f64| late + 1.0 + (angle - turned) / fast;
        let whole =
            |t: f64| pulses.integral(turned + fast * (t - late - 1.0), |angle| time(angle) - time(0.0));
        let expected = whole(end) - whole(from);
        let machine = Machine::of_constants(pulses.clone(), &[("speed", 1.0)]).unwrap();
        let model = VaryingSpeed::new(machine, law);
        let start = State::new(from, &[0.0], &[0.0]);
        for state in
            [Taylor::new().end(&model, &start, end).unwrap(), Dop853::new().end(&model, &start, end).unwrap()]
        {
            // Three waves with up to 6 edges pairs a turn, each off by the digits of the time, 1.2e-10 s.
            let off = (state.v[0] - expected).abs();
            assert!(off < 1e-8 * (1.0 + common), "case {case}: {} for {expected}", state.v[0]);
        }
    }
}

/// Rows in lanes: v at the end is the largest v.
#[test]
fn lanes_meet_edges_beside_edges() {
    let mut random = Random(81);
    for case in 0..60 {
        let (pulses, _) = beside(&mut random, 1e-14, if case % 2 == 0 { 1e-12 } else { 1e-8 });
        let machine = Machine::of_constants(pulses.clone(), &[("speed", 1.0)]).unwrap();
        let points = Points::from(Axis::linear("speed", 0.5, 3.5, 8).unwrap());
        let sweep = Sweep::new(points).settle(1).measure(3).channels(&["v0"]);
        let engine = LaneTaylor::new(Taylor::new());
        let family = |p: &Point<'_>| machine.with("speed", p["speed"]);
        let rows = sweep.of(&engine, family).start(|_, _| State::at_rest(1)).run().unwrap();
        assert!(rows.errors().is_empty(), "{case}: {:?}", rows.errors());
        for (i, row) in rows.iter().enumerate() {
            let speed = 0.5 + 3.0 * i as f64 / 7.0;
            let expected = pulses.integral(4.0 * TAU, |angle| angle / speed);
            let found = row.channel("v0").unwrap().max;
            assert!((found - expected).abs() < 1e-9, "case {case}, {i}: {found} for {expected}");
        }
    }
}

/// Waves of other shafts, with edges beside those of the machine.
#[test]
fn edges_of_other_shafts_are_all_met() {
    let mut random = Random(82);
    for case in 0..500 {
        let (pulses, common) = beside(&mut random, 1e-14, 1e-8);
        let speed = 0.5 + 3.0 * random.next();
        // A wave of a further shaft on the slot of the first wave, with an edge beside those at `common`.
        let (other, share) = (0.5 + 3.0 * random.next(), 0.2 + 0.6 * random.next());
        let apart = 1e-14 * 1e6f64.powf(random.next()) * if random.next() < 0.5 { 1.0 } else { -1.0 };
        let at = other * common / speed + apart;
        let phase = (PI * share - at).rem_euclid(TAU);
        let added = Pulses::new(&[(1, phase, share)]);
        let end = (common + 1.5) / speed;
        let expected = pulses.integral(common + 1.5, |angle| angle / speed)
            + added.integral(other * end, |angle| angle / other);
        let machine = Machine::of_constants(pulses, &[("speed", speed)]).unwrap();
        let model =
            gear_dynamics::tori::WithShafts::new(machine).add(0, other, added.waves[0].clone()).unwrap();
        compare(&model, end, expected, 1e-9, case);
    }
}
