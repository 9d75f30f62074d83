//! Waves that are finite Fourier series are written from one sine and cosine; all others by their excitations.

use gear_dynamics::contact::PieceChoice;
use gear_dynamics::excitation::{
    Angle, Fourier, InstantCentre, Jet, Product, RectangularWave, Scaled, Side, Sum, earliest,
};
use gear_dynamics::model::{Channel, Drives, Scalar, Size};
use gear_dynamics::{Dop853, Integrator, Machine, Model, Shape, State, Taylor, Wave};
use proptest::prelude::*;

/// Value, first and second derivative of each wave, then 2 f_0 + f_last - 1.
#[derive(PartialEq)]
struct Jets(Vec<Wave>);

impl Shape for Jets {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 3 * self.0.len() + 1, constants: 1, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1")]
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        for (u, wave) in u.as_chunks_mut::<3>().0.iter_mut().zip(&self.0) {
            let jet = wave.jet(angle, side);
            *u = [jet.value, jet.rate, jet.second];
        }
        let last = self.0[self.0.len() - 1].value(angle, side);
        u[3 * self.0.len()] = self.0[0].value(angle, side) * 2.0 + last - A::Number::from(1.0);
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        earliest(self.0.iter().map(|wave| wave.next_edge(angle)))
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, _: Drives<'_, S>, q: &[S], _: &[S], a: &mut [S]) {
        a[0] = -q[0];
    }
}

/// The waves by `Model::drive` and by `Model::redrive` from another angle, which must be equal.
fn driven(machine: &Machine<Jets>, angle: f64, side: Side) -> Vec<f64> {
    let [mut u, mut again] = [vec![f64::NAN; machine.drives()], vec![0.0; machine.drives()]];
    machine.drive(angle, side, &mut u);
    machine.drive(angle + 1.0, Side::After, &mut again);
    machine.redrive(&[angle], side, &mut again);
    assert_eq!(u, again);
    u.truncate(machine.size().waves);
    u
}
fn machine(waves: Vec<Wave>) -> Machine<Jets> {
    Machine::of_constants(Jets(waves), &[("speed", 1.0)]).unwrap()
}
fn by_excitations(machine: &Machine<Jets>, angle: f64, side: Side) -> Vec<f64> {
    let mut u = vec![0.0; machine.size().waves];
    machine.shape().waves(angle, side, &mut u);
    u
}

/// A random series.
type Term = (f64, Vec<[f64; 2]>);

/// Value, derivatives and magnitudes of a series with the order n at an angle whose products with all orders
/// are exact.
fn direct((mean, pairs): &Term, n: u32, angle: f64) -> [[f64; 2]; 3] {
    let mut sums = [[*mean, mean.abs()], [0.0; 2], [0.0; 2]];
    for (h, [a, b]) in (1..).zip(pairs) {
        let w = f64::from(h * n);
        let (s, c) = libm::sincos(w * angle);
        let terms = [a * c + b * s, w * (b * c - a * s), -w * w * (a * c + b * s)];
        for (k, (sum, term)) in sums.iter_mut().zip(terms).enumerate() {
            *sum = [sum[0] + term, sum[1] + w.powi(k as i32) * (a.abs() + b.abs())];
        }
    }
    sums
}

proptest! {
    /// Orders up to 200, angles up to 10⁶ rad.
    #[test]
    fn series_are_exact_to_rounding(
        terms in prop::collection::vec(
            (-2.0..2.0, prop::collection::vec([0.1..1.0, -1.0..1.0f64], 1..21)), 1..4),
        n in 1u32..11,
        steps in -64_000_000i64..64_000_000,
    ) {
        let angle = steps as f64 / 64.0; // 26 bits
        let series = |(mean, pairs): &Term| Wave::new(Fourier::new(*mean, pairs).unwrap()).per_turn(n).unwrap();
        let mut waves: Vec<Wave> = terms.iter().map(series).collect();
        waves.push(Wave::new(Sum::new(vec![waves[0].clone(), Wave::new(Scaled::new(-3.0, waves[0].clone()).unwrap())])));
        let last = terms.len();
        let u = driven(&machine(waves), angle, Side::After);
        // Sums of at most 20 orders, eight rotations: at most 64 roundings of the magnitude.
        let near = |found: f64, [value, size]: [f64; 2]| (found - value).abs() <= 64.0 * f64::EPSILON * size;
        let first = direct(&terms[0], n, angle);
        for (k, term) in terms.iter().enumerate() {
            let direct = direct(term, n, angle);
            for (i, direct) in direct.into_iter().enumerate() {
                prop_assert!(near(u[3 * k + i], direct), "{} instead of {direct:?}", u[3 * k + i]);
            }
        }
        for (i, first) in first.into_iter().enumerate() {
            prop_assert!(near(u[3 * last + i], [-2.0 * first[0], 4.0 * first[1]]));
        }
        // 2 f_0 - 2 f_0 - 1
        prop_assert!(near(u[3 * last + 3], [-1.0, 4.0 * first[0][1] + 1.0]));
    }
}

#[test]
fn products_phases_and_constants_agree_with_their_excitations() {
    let wave = |mean: f64, pairs: &[[f64; 2]]| Wave::new(Fourier::new(mean, pairs).unwrap());
    let teeth = wave(1.0, &[[0.3, 0.0]]).per_turn(63).unwrap().with_phase(0.7).unwrap();
    let turn = wave(1.0, &[[0.4, 0.1]]).with_phase(2.0).unwrap();
    let product = Wave::new(Product::new(vec![teeth.clone(), turn.clone(), turn.clone()]));
    let machine = machine(vec![product, teeth.clone(), Wave::constant(2.5).unwrap(), turn, teeth]);
    for i in 0..1000 {
        let angle = f64::from(i) * 0.0571 - 20.0;
        let found = driven(&machine, angle, Side::After);
        for (k, (a, b)) in found.iter().zip(by_excitations(&machine, angle, Side::After)).enumerate() {
            // n φ has a rounding error of 63 · 40 · 1.1e-16; each derivative multiplies by up to 65.
            let size = 4.0 * 65f64.powi([0, 1, 2][k % 3]);
            assert!((a - b).abs() < 1e-12 * size, "wave {k} at {angle}: {a} {b}");
        }
    }
}

/// Waves with edges, closures and the instantaneous centre are evaluated as before, bit for bit, and on both
/// sides of a jump.
#[test]
fn other_waves_are_written_by_their_excitations() {
    let smooth = || Wave::new(Fourier::new(1.0, &[[0.2, 0.1]]).unwrap());
    let rectangle = Wave::new(RectangularWave::new(1.0, 2.0, 0.4).unwrap());
    let closure = Wave::new(gear_dynamics::excitation::Function::new(|x: Jet| (x.cos() * 0.5).exp()));
    let centre = Wave::new(InstantCentre::new(0.3).unwrap().rotation());
    for other in [rectangle, closure, centre] {
        let edge = other.next_edge(0.0);
        let machine = machine(vec![smooth(), other, smooth()]);
        for angle in [0.0, 0.3, 5.0, 1e4].into_iter().chain(edge) {
            for side in [Side::Before, Side::After] {
                assert_eq!(driven(&machine, angle, side), by_excitations(&machine, angle, side));
            }
        }
        if let Some(edge) = edge {
            let [before, after] = [Side::Before, Side::After].map(|side| driven(&machine, edge, side)[3]);
            assert!((before - after).abs() > 0.5, "{before} {after}");
        }
    }
}

/// q'' = u(t), a wave of the angle.
#[derive(PartialEq)]
struct Pushed(Wave);

impl Shape for Pushed {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 1, constants: 1, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "1")]
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        u[0] = self.0.value(angle, side);
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, _: &[S], _: &[S], a: &mut [S]) {
        [a[0]] = u.waves();
    }
}

/// The harmonics of an instantaneous centre fall like powers of its eccentric ratio: at 0.95 more than 512 stand above
/// rounding, too many for the sums. The series of the excitation is taken, and the motion is that of `Dop853`.
#[test]
fn more_harmonics_than_the_sums_hold() {
    for eccentric in [0.3, 0.5, 0.9, 0.94, 0.95, 0.96, 0.99] {
        let wave = Wave::new(InstantCentre::new(eccentric).unwrap().rotation());
        let machine = Machine::of_constants(Pushed(wave), &[("speed", 1.0)]).unwrap();
        let start = State::at_rest(1);
        let expected = Dop853::new().rtol(1e-10).end(&machine, &start, 1.0).unwrap();
        let state = Taylor::new().rtol(1e-10).end(&machine, &start, 1.0).unwrap();
        assert!((state.q[0] / expected.q[0] - 1.0).abs() < 1e-8, "{eccentric}: {state:?}, {expected:?}");
    }
}
