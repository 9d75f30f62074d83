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
