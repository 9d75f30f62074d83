//! Several impacts at one instant: rows of balls in closed form, symmetric sets, invariants of random sets,
//! derivatives and refusals.

use crate::api::*;
use crate::common::random::Random;
use gear_dynamics::contact::{Contact, PieceChoice};
use gear_dynamics::model::{Drives, Scalar, Size};
use gear_dynamics::{Machine, Shape};

/// Bodies on one line, with stops between pairs of them or to the ground: d = q_b - q_a - reach >= 0.
#[derive(Clone, PartialEq, Debug)]
struct Bodies {
    masses: Vec<f64>,
    /// First and second body; `None`: the ground.
    pairs: Vec<[Option<usize>; 2]>,
    restitution: Vec<f64>,
    pull: f64,
    rigid: Vec<[bool; 2]>,
}

impl Bodies {
    fn new(masses: &[f64], pairs: &[[Option<usize>; 2]], e: f64) -> Self {
        Bodies {
            masses: masses.to_vec(),
            pairs: pairs.to_vec(),
            restitution: vec![e; pairs.len()],
            pull: 0.0,
            rigid: vec![[true, false]; pairs.len()],
        }
    }
    /// A row of balls, each next to the one before.
    fn row(masses: &[f64], e: f64) -> Self {
        let pairs: Vec<_> = (1..masses.len()).map(|i| [Some(i - 1), Some(i)]).collect();
        Bodies::new(masses, &pairs, e)
    }
    /// Random bodies in a tree, some pairs with two contacts, and velocities; some of them are equal.
    fn random(random: &mut Random, case: usize) -> (Self, Vec<f64>) {
        let n = 2 + (random.next() * 5.0) as usize;
        let masses: Vec<f64> = (0..n).map(|_| 10f64.powf(2.0 * random.next() - 1.0)).collect();
        let mut pairs = Vec::new();
        for b in 1..n {
            let a = if random.next() < 0.5 { b - 1 } else { (random.next() * b as f64) as usize };
            pairs.push([Some(a), Some(b)]);
        }
        // A second contact of a pair that has one already.
        if random.next() < 0.3 {
            pairs.push(pairs[0]);
        }
        let grid = |random: &mut Random| match random.next() < 0.4 {
            true => (random.next() * 4.0).floor() - 2.0,
            false => 4.0 * random.next() - 2.0,
        };
        let v: Vec<f64> = (0..n).map(|_| grid(random)).collect();
        let e = [1.0, 0.0, random.next(), 0.9][(random.next() * 4.0) as usize];
        let mut bodies = Bodies::new(&masses, &pairs, e);
        if case.is_multiple_of(2) {
            bodies.restitution.iter_mut().for_each(|e| *e = random.next());
        }
        (bodies, v)
    }
    fn machine(&self) -> Machine<Bodies> {
        Machine::of_constants(self.clone(), &[("speed", 1.0)]).unwrap()
    }
    fn rate(&self, contact: usize, v: &[f64]) -> f64 {
        let [a, b] = self.pairs[contact].map(|body| body.map_or(0.0, |body| v[body]));
        b - a
    }
    fn sums(&self, v: &[f64]) -> [f64; 2] {
        let sum = |f: fn(f64) -> f64| self.masses.iter().zip(v).map(|(m, v)| m * f(*v)).sum();
        [sum(|v| v), sum(|v| v * v)]
    }
}

impl Shape for Bodies {
    fn size(&self) -> Size {
        Size { dof: self.masses.len(), contacts: self.pairs.len(), constants: 1, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1")]
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        _: &L,
        i: usize,
        _: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let of = |x: &[S]| {
            let [a, b] = self.pairs[i].map(|body| body.map_or(S::from(0.0), |body| x[body]));
            b - a
        };
        let infinite = S::from(f64::INFINITY);
        Contact { deflection: of(q), rate: of(v), lower: 0.0.into(), upper: infinite, ..Contact::default() }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, _: Drives<'_, S>, _: &[S], _: &[S], a: &mut [S]) {
        a.fill(self.pull.into());
    }
    fn stops(&self) -> &[[bool; 2]] {
        &self.rigid
    }
    fn impact<S: Scalar>(&self, i: usize, _: Piece, _: Drives<'_, S>, _: &[S], v: &mut [S]) {
        let (mut b, mut m) = (vec![S::from(0.0); v.len()], vec![S::from(0.0); v.len()]);
        let mut rate = S::from(0.0);
        for (body, sign) in self.pairs[i].into_iter().zip([-1.0, 1.0]) {
            if let Some(body) = body {
                (b[body], m[body]) = (sign.into(), (sign / self.masses[body]).into());
                rate = rate + v[body] * sign;
            }
        }
        Restitution::new(self.restitution[i]).unwrap().impulse(rate, &b, &m, v);
    }
}

/// The ends of one run by all methods.
fn ends(model: &Machine<Bodies>, start: &State, end: f64) -> Vec<State> {
    vec![
        Dop853::new().end(model, start, end).unwrap(),
        Rk45::new().end(model, start, end).unwrap(),
        Rk4::new(0.0371).end(model, start, end).unwrap(),
        Taylor::new().end(model, start, end).unwrap(),
    ]
}

fn close(found: &[f64], expected: &[f64], within: f64) {
    let off = found.iter().zip(expected).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
    assert!(off <= within, "{found:?} instead of {expected:?}");
}

#[test]
fn one_floor_stated_as_several_contacts_is_one_floor() {
    let (g, e): (f64, f64) = (9.81, 0.7);
    let hit = (2.0 / g).sqrt();
    let expected = e * g * hit * (0.7 - hit) - 0.5 * g * (0.7 - hit).powi(2); // 0.4676
    assert!((expected - 0.4676).abs() < 1e-4);
    for contacts in 1..=3 {
        let bodies = Bodies { pull: -g, ..Bodies::new(&[1.0], &vec![[None, Some(0)]; contacts], e) };
        for end in ends(&bodies.machine(), &State::new(0.0, &[1.0], &[0.0]), 0.7) {
            close(&end.q, &[expected], 1e-9);
        }
        let variation =
            Variation::new().run(&bodies.machine(), &State::new(0.0, &[1.0], &[0.0]), 0.7).unwrap();
        let one = Bodies { pull: -g, ..Bodies::new(&[1.0], &[[None, Some(0)]], e) };
        let alone = Variation::new().run(&one.machine(), &State::new(0.0, &[1.0], &[0.0]), 0.7).unwrap();
        assert!((variation.matrix - alone.matrix).amax() < 1e-9);
    }
}

#[test]
fn impacts_pass_through_a_row_of_balls() {
    let touching = |n: usize| (0..n).map(|i| if i == 0 { -1.0 } else { 0.0 }).collect::<Vec<f64>>();
    for n in [2, 3, 5, 9] {
        let mut v = vec![0.0; n];
        v[0] = 1.0;
        let start = State::new(0.0, &touching(n), &v);
        // e = 1: the last ball leaves with the speed of the first.
        for end in ends(&Bodies::row(&vec![1.0; n], 1.0).machine(), &start, 2.0) {
            let mut expected = vec![0.0; n];
            expected[n - 1] = 1.0;
            close(&end.v, &expected, 1e-12);
        }
        // e = 0: all move together, and go on together.
        for end in ends(&Bodies::row(&vec![1.0; n], 0.0).machine(), &start, 40.0) {
            close(&end.v, &vec![1.0 / n as f64; n], 1e-12);
            close(&end.q, &vec![39.0 / n as f64; n], 1e-8);
        }
    }
    // Two balls strike three: two leave. A ball between two balls that strike it at once stays.
    let five = Bodies::row(&[1.0; 5], 1.0).machine();
    for end in ends(&five, &State::new(0.0, &[-1.0, -1.0, 0.0, 0.0, 0.0], &[1.0, 1.0, 0.0, 0.0, 0.0]), 2.0) {
        close(&end.v, &[0.0, 0.0, 0.0, 1.0, 1.0], 1e-12);
    }
    let three = Bodies::row(&[1.0; 3], 1.0).machine();
    for end in ends(&three, &State::new(0.0, &[-1.0, 0.0, 1.0], &[1.0, 0.0, -1.0]), 2.0) {
        close(&end.v, &[-1.0, 0.0, 1.0], 1e-12);
    }
}

#[test]
fn collisions_before_a_wall_count_pi() {
    // Galperin: a ball of mass 1 rests on a wall, a ball of mass 10000 arrives: 314 impacts at one instant
    // turn the angle of (√M V, v) by 2 atan √(m/M) for each pair of impacts.
    let mass: f64 = 1e4;
    let pairs = [[Some(0), Some(1)], [Some(1), None]];
    let machine = Bodies::new(&[mass, 1.0], &pairs, 1.0).machine();
    let turn = 2.0 * (1.0 / mass.sqrt()).atan();
    let (mut v, mut impacts) = ([1.0, 0.0], 0);
    loop {
        if v[0] > v[1] {
            let common = (mass * v[0] + v[1]) / (mass + 1.0);
            v = v.map(|v| 2.0 * common - v);
        } else if v[1] > 0.0 {
            v[1] = -v[1];
        } else {
            break;
        }
        impacts += 1;
    }
    assert!(impacts == 314 && turn > 0.0);
    for end in ends(&machine, &State::new(0.0, &[-1.0, 0.0], &[1.0, 0.0]), 2.0) {
        close(&end.v, &v, 1e-9);
    }
}

#[test]
fn equal_members_of_a_set_stay_equal() {
    for (n, e) in [(2, 1.0), (3, 1.0), (5, 0.6), (4, 0.0)] {
        let mut masses = vec![10.0; n + 1];
        masses[0] = 1.0;
        let pairs: Vec<_> = (1..=n).map(|i| [Some(0), Some(i)]).collect();
        let (mut q, mut v) = (vec![0.0; n + 1], vec![0.0; n + 1]);
        (q[0], v[0]) = (-1.0, 1.0);
        // As one body of mass 10 n.
        let all = 10.0 * n as f64;
        let expected = (1.0 + e) / (1.0 + all);
        let bodies = Bodies::new(&masses, &pairs, e);
        let start = State::new(0.0, &q, &v);
        for end in ends(&bodies.machine(), &start, 1.9) {
            assert!((end.v[0] - (1.0 - e * all) / (1.0 + all)).abs() < 1e-12, "{:?}", end.v);
            end.v[1..].iter().for_each(|v| assert!((v - expected).abs() < 1e-12, "{:?}", end.v));
        }
        // Neighbours strike one member first: there is not one derivative.
        let refused = Variation::new().run(&bodies.machine(), &start, 1.9).unwrap_err();
        assert!(matches!(refused, IntegrateError::SimultaneousImpacts { .. }), "{refused}");
    }
}

#[test]
fn random_impacts_keep_momentum_and_lose_energy() {
    let mut random = Random(481);
    let mut several = 0;
    for case in 0..3000 {
        let (bodies, v) = Bodies::random(&mut random, case);
        // All touch at the start: the impacts happen at the start of the run.
        let machine = bodies.machine();
        let n = bodies.masses.len();
        let start = State::new(0.0, &vec![0.0; n], &v);
        let end = Dop853::new().end(&machine, &start, 1e-3).unwrap_or_else(|e| panic!("case {case}: {e}"));
        let [before, after] = [&v, &end.v].map(|v| bodies.sums(v));
        let size: f64 = bodies.masses.iter().zip(&v).map(|(m, v)| m * v.abs()).sum();
        assert!((after[0] - before[0]).abs() <= 1e-12 * size, "case {case}: momentum");
        assert!(after[1] <= before[1] * (1.0 + 1e-12), "case {case}: energy {before:?} {after:?}");
        if bodies.restitution.iter().all(|e| *e == 1.0) {
            assert!(
                (after[1] - before[1]).abs() <= 1e-10 * before[1],
                "case {case}: energy {before:?} {after:?}"
            );
        }
        let pairs = bodies.pairs.len();
        let fastest = (0..pairs).fold(0.0f64, |m, i| m.max(-bodies.rate(i, &v)));
        several += usize::from((0..pairs).filter(|i| bodies.rate(*i, &v) < 0.0).count() > 1);
        for i in 0..pairs {
            assert!(
                bodies.rate(i, &end.v) >= -1e-12 * (1.0 + fastest),
                "case {case}: contact {i} approaches"
            );
        }
    }
    assert!(several > 1000, "{several}");
}

/// Bodies that touch at the start leave one another for good: all methods, and rows in lanes, have the velocities
/// after the impacts at the start. Bodies that stay together by e = 0 are not moved onto one another by rounding.
#[test]
fn bodies_that_touch_at_a_start_leave_one_another() {
    let mut random = Random(482);
    for case in 0..400 {
        let (bodies, mut v) = Bodies::random(&mut random, case);
        let drift = if case % 3 == 0 { 1e3 * random.next() } else { 0.0 };
        v.iter_mut().for_each(|v| *v += drift);
        let (machine, n) = (bodies.machine(), bodies.masses.len());
        let start = State::new(0.0, &vec![0.0; n], &v);
        let first = Dop853::new().end(&machine, &start, 1e-3).unwrap_or_else(|e| panic!("case {case}: {e}"));
        let size = v.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        for (method, end) in ends(&machine, &start, 30.0).into_iter().enumerate() {
            let off = end.v.iter().zip(&first.v).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
            assert!(off <= 1e-11 * size, "case {case}, method {method}: {:?} {:?}", end.v, first.v);
        }
        let sweep = Sweep::new(Points::from(Axis::linear("speed", 1.0, 2.0, 2).unwrap()));
        let sweep = sweep.settle(1).measure(1).channels(&["v0"]);
        let engine = LaneTaylor::new(Taylor::new());
        let family = |p: &Point<'_>| machine.with("speed", p["speed"]);
        let rows = sweep.of(&engine, family).start(|_, _| start.clone()).run().unwrap();
        assert!(rows.errors().is_empty(), "case {case}: {:?}", rows.errors());
        for row in rows.iter() {
            let found = row.channel("v0").unwrap();
            let off = (found.max - first.v[0]).abs().max((found.min - first.v[0]).abs());
            assert!(off <= 1e-11 * size, "case {case}: {found:?} {:?}", first.v);
        }
    }
}

#[test]
fn the_derivative_follows_the_order_of_the_impacts() {
    // One ball strikes a row that touches. Neighbours with gaps have the same order of impacts.
    for e in [1.0, 0.8] {
        let machine = Bodies { pull: 0.0, ..Bodies::row(&[1.0, 2.0, 0.5], e) }.machine();
        let start = State::new(0.0, &[-1.0, 0.0, 0.0], &[1.0, 0.0, 0.0]);
        let matrix = Variation::new().run(&machine, &start, 1.6).unwrap().matrix.clone();
        let end = Dop853::new().end(&machine, &start, 1.6).unwrap();
        let h = 1e-6;
        for direction in [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, 1.0, 2.0]] {
            let q: Vec<f64> = start.q.iter().zip(direction).map(|(q, d)| q + h * d).collect();
            let moved = Dop853::new().end(&machine, &State::new(0.0, &q, &start.v), 1.6).unwrap();
            for i in 0..3 {
                let slope: f64 = (0..3).map(|j| matrix[(i, j)] * direction[j]).sum();
                assert!(((moved.q[i] - end.q[i]) / h - slope).abs() < 1e-5, "{i} {direction:?}");
            }
        }
    }
}

#[test]
fn walls_that_move_together_on_a_body_are_refused_in_their_own_words() {
    // Two heavy bodies squeeze a light one without end.
    let machine = Bodies::row(&[1e9, 1e-9, 1e9], 1.0).machine();
    let start = State::new(0.0, &[-1.0, 0.0, 1.0], &[1.0, 0.0, -1.0]);
    let refused = Dop853::new().end(&machine, &start, 2.0).unwrap_err();
    assert!(matches!(refused, IntegrateError::TooManyImpacts { limit: 20_000, .. }), "{refused}");
    assert!(refused.to_string().starts_with("too many impacts at one instant"), "{refused}");
}

/// A light ball between two heavy ones: all three go on together with the speed of their centre, 1/2.03. The last impacts
/// are slower than the rounding of the velocities.
#[test]
fn impacts_slower_than_the_rounding_of_the_velocities_end() {
    for e in [0.4, 0.5, 0.6, 0.65] {
        for tenths in 1..=10 {
            let gap = 0.1 * f64::from(tenths);
            for v in [0.0, -0.2, -0.4] {
                let row = Bodies::row(&[1.0, 0.03, 1.0], e).machine();
                let start = State::new(0.0, &[-1.0, 0.0, gap], &[1.0, 0.0, v]);
                let end = Dop853::new().end(&row, &start, 30.0).unwrap();
                let momentum = end.v[0] + 0.03 * end.v[1] + end.v[2];
                assert!((momentum - 1.0 - v).abs() < 1e-12, "{e} {gap} {v} {end:?}");
                assert!(
                    end.v[0] <= end.v[1] + 1e-12 && end.v[1] <= end.v[2] + 1e-12,
                    "{e} {gap} {v} {end:?}"
                );
                if (e, tenths, v) == (0.6, 1, 0.0) {
                    assert!(end.v.iter().all(|v| (v - 1.0 / 2.03).abs() < 1e-8), "{end:?}");
                }
            }
        }
    }
}

/// Both rigid stops of a contact at one place are refused by name, whatever the absolute tolerance.
#[test]
fn stops_at_one_place_are_refused_by_name() {
    struct Held;
    impl Model for Held {
        fn dof(&self) -> usize {
            1
        }
        fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) {
            a[0] = 0.0;
        }
        fn contacts(&self) -> usize {
            1
        }
        fn contact(&self, _: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
            out[0] = Contact { deflection: q[0], rate: v[0], lower: 0.0, upper: 0.0, ..Contact::default() };
        }
        fn impact(&self, _: usize, _: gear_dynamics::contact::Piece, _: &[f64], _: &[f64], v: &mut [f64]) {
            v[0] *= -0.5;
        }
        fn offers(&self) -> gear_dynamics::model::Offers<'_> {
            gear_dynamics::model::Offers { stops: &[[true, true]], ..Default::default() }
        }
    }
    for atol in [1e-3, 1e-12, 1e-40, 1e-90] {
        let refused = Dop853::new().atol(atol).end(&Held, &State::new(0.0, &[0.0], &[1.0]), 1.0);
        let refused = refused.unwrap_err();
        assert!(matches!(refused, IntegrateError::NoRoomBetweenStops { contact: 0, .. }), "{refused}");
    }
}
