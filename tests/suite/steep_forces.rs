//! Taylor series with steep smooth forces and drives, in single runs and in lanes: the last coefficients at the start of
//! a step do not show what the step passes.

use crate::api::*;
use crate::lane_taylor::{axis, rows};
use gear_dynamics::branches::{Continuation, Family};
use gear_dynamics::excitation::RectangularWave;
use gear_dynamics::models::Oscillator;
use gear_dynamics::sweep::{Axis, Points};
use std::f64::consts::{FRAC_2_PI, TAU};

/// x'' = cos φ + P e^(-((1 - cos (φ - 1))/d)²) - x - A tanh(x'/v0) - A e^(-(x/v0)²).
#[derive(PartialEq)]
struct Steep;

impl Shape for Steep {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 2, constants: 5, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        ["speed", "v0", "friction", "bump", "pulse"].map(|name| Channel::new(name, "1")).into()
    }
    fn waves<A: Angle>(&self, angle: A, _: Side, u: &mut [A::Number]) {
        let one = A::Number::from(1.0);
        u[0] = angle.number().cos();
        // Too narrow for a Fourier series with as few harmonics as are expanded.
        let place = (one - (angle.number() - one).cos()) * 2e4;
        u[1] = (-(place * place)).exp();
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let ([cos, pulse], [width, friction, bump, height]) = (u.waves(), u.constants());
        let (one, place) = (S::from(1.0), q[0] / width);
        let tanh = one - S::from(2.0) / ((v[0] * 2.0 / width).exp() + one);
        a[0] = cos + height * pulse - q[0] - friction * tanh - bump * (-(place * place)).exp();
    }
}

fn machine(speed: f64, width: f64, friction: f64, bump: f64, pulse: f64) -> Machine<Steep> {
    let constants =
        [("speed", speed), ("v0", width), ("friction", friction), ("bump", bump), ("pulse", pulse)];
    Machine::of_constants(Steep, &constants).unwrap()
}

/// x(60) from rest to six digits, by two programs of other methods.
#[test]
fn friction_by_tanh() {
    for (width, exact) in [(0.03, -1.122234), (0.1, -1.119359)] {
        let machine = machine(0.7, width, 0.2, 0.0, 0.0);
        for rtol in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
            let end = Taylor::new().rtol(rtol).end(&machine, &State::at_rest(1), 60.0).unwrap();
            // Errors of all steps remain: friction forgets half of them in a period.
            let within = 100.0 * rtol + 1e-6;
            assert!((end.q[0] - exact).abs() < within, "{width}, {rtol:e}: {} for {exact}", end.q[0]);
        }
    }
}

/// Every term alone, against DOP853 with steps that are shorter than the narrow features. The coefficients of
/// e^(2 v/v0) do not overflow: speeds remain below 7.
#[test]
fn steep_terms_against_short_steps() {
    for terms in [[0.2, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 3.0], [0.1, 0.3, 2.0]] {
        let [friction, bump, pulse] = terms;
        let machine = machine(0.9, 0.025, friction, bump, pulse);
        let start = State::new(0.0, &[0.8], &[0.3]);
        let short = Dop853::new().rtol(1e-13).atol(1e-15).max_step(2e-3);
        let exact = short.end(&machine, &start, 15.0).unwrap().q[0];
        for rtol in [1e-5, 1e-8, 1e-11] {
            let found = Taylor::new().rtol(rtol).end(&machine, &start, 15.0).unwrap().q[0];
            assert!((found - exact).abs() < 300.0 * rtol, "{terms:?}, {rtol:e}: {found} for {exact}");
        }
    }
}

/// Rows in lanes end where single runs with short steps do, and do not depend on their neighbours.
#[test]
fn steep_terms_in_lanes() {
    let machine = machine(0.9, 0.02, 0.1, 0.3, 2.0);
    let start = State::new(0.0, &[0.8], &[0.3]);
    let sweep = |from: f64, to: f64, count: usize| {
        let points = axis("v0", from, to, count);
        Sweep::new(points).settle(1).measure(1).channels(&["q0"]).strobe(1)
    };
    for rtol in [1e-6, 1e-10] {
        let engine = LaneTaylor::new(Taylor::new().rtol(rtol));
        let together = rows(&sweep(0.025, 0.115, 10), &engine, &machine, &start);
        for i in 0..10 {
            let row = together.get(i).unwrap();
            let width = 0.025 + 0.01 * i as f64;
            let own = machine.with("v0", width).unwrap();
            let short = Dop853::new().rtol(1e-13).atol(1e-15).max_step(2e-3);
            let exact = short.end(&own, &start, 2.0 * own.period()).unwrap().q[0];
            let found = row.strobes().last().unwrap()[0];
            assert!((found - exact).abs() < 300.0 * rtol, "{width}, {rtol:e}: {found} for {exact}");
        }
        let other = rows(&sweep(0.025, 0.2, 2), &engine, &machine, &start);
        assert!(other.get(0).unwrap().strobes().eq(together.get(0).unwrap().strobes()));
    }
}

/// A limit: where coefficients of e^(2 v/v0) overflow, single runs and rows end in an error, not in a wrong number. In this
/// motion 2 v/v0 reaches 700 at about t = 12.6.
#[test]
fn overflow_is_an_error() {
    let (machine, start) = (machine(0.9, 0.01, 0.2, 0.0, 0.0), State::new(0.0, &[0.8], &[0.3]));
    for rtol in [1e-5, 1e-8, 1e-11] {
        let taylor = Taylor::new().rtol(rtol);
        let Err(IntegrateError::NoSeriesAt { t, .. }) = taylor.end(&machine, &start, 15.0) else {
            panic!("{rtol:e}: no error");
        };
        let exponent = Dop853::new().end(&machine, &start, t).unwrap().v[0] / 0.005;
        assert!((600.0..710.0).contains(&exponent), "{rtol:e}: e^{exponent}");
        let sweep = Sweep::new(axis("v0", 0.01, 0.1, 2)).settle(1).measure(1).channels(&["q0"]).strobe(1);
        let rows = rows(&sweep, &LaneTaylor::new(taylor), &machine, &start);
        assert!(matches!(rows.errors()[&0], PointError::Integrate(IntegrateError::NoSeriesAt { .. })));
    }
}

/// x'' = cos φ + P ((1 + cos (φ - 1))/2)^n - x - 0.1 x' + F (1 - (x/4)²)^n with n = 256 or 1024: products only.
#[derive(PartialEq)]
struct Peaks {
    squarings: usize,
}

impl Peaks {
    fn power<S: Scalar>(&self, x: S) -> S {
        (0..self.squarings).fold(x, |x, _| x * x)
    }
}

impl Shape for Peaks {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 2, constants: 3, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        ["speed", "pulse", "force"].map(|name| Channel::new(name, "1")).into()
    }
    fn waves<A: Angle>(&self, angle: A, _: Side, u: &mut [A::Number]) {
        let one = A::Number::from(1.0);
        u[0] = angle.number().cos();
        u[1] = self.power((one + (angle.number() - one).cos()) * 0.5);
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let ([cos, pulse], [height, force]) = (u.waves(), u.constants());
        let place = q[0] * 0.25;
        let peak = self.power(S::from(1.0) - place * place);
        a[0] = cos + height * pulse - q[0] - v[0] * 0.1 + force * peak;
    }
}

/// x'' = ((1 - cos φ)/2)^n - 0.2 x' - x: a drive by products of its wave, and a wave without a finite series beside it.
#[derive(PartialEq)]
struct FlatPulse {
    degree: u32,
    beside: f64,
}

impl Shape for FlatPulse {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 1, constants: 1, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "rad/s")]
    }
    fn waves<A: Angle>(&self, angle: A, _: Side, u: &mut [A::Number]) {
        let cos = angle.number().cos();
        let flat = (A::Number::from(1.0) - cos) * 0.5;
        u[0] = (1..self.degree).fold(flat, |power, _| power * flat) + (cos * 0.5).exp() * self.beside;
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [pulse] = u.waves();
        a[0] = pulse - v[0] * 0.2 - q[0];
    }
}

/// x(t) from rest for the drive Σ c_k cos kωt, from its Fourier coefficients by 256 samples.
pub(crate) fn driven_from_rest(drive: impl Fn(f64) -> f64, speed: f64, t: f64) -> f64 {
    let samples: Vec<f64> = (0..256).map(|i| drive((TAU * f64::from(i) / 256.0).cos())).collect();
    let (mut x, mut start) = (0.0, [0.0; 2]);
    for k in 0..64 {
        let sum = (0..256).map(|i| samples[i] * (TAU * (k * i % 256) as f64 / 256.0).cos()).sum::<f64>();
        let (c, w) = (sum / if k == 0 { 256.0 } else { 128.0 }, k as f64 * speed);
        let (stiffness, damping) = (1.0 - w * w, 0.2 * w);
        let size = c / (stiffness * stiffness + damping * damping);
        let [of_cos, of_sin] = [size * stiffness, size * damping];
        x += of_cos * (w * t).cos() + of_sin * (w * t).sin();
        start = [start[0] + of_cos, start[1] + w * of_sin];
    }
    // The free motion takes back what the forced one has at t = 0.
    let free = 0.99f64.sqrt();
    let [a, b] = [-start[0], -(start[1] + 0.1 * start[0]) / free];
    x + (-0.1 * t).exp() * (a * (free * t).cos() + b * (free * t).sin())
}

/// Waves whose terms cancel at the start of a step: at φ = 0 a pulse of degree n is 0 with 2n coefficients.
#[test]
fn flat_pulses_as_drives() {
    for (degree, beside) in [(10, 0.0), (12, 0.0), (16, 0.0), (24, 0.0), (12, 0.01), (14, 0.01), (20, 0.01)] {
        let machine = Machine::of_constants(FlatPulse { degree, beside }, &[("speed", 1.0)]).unwrap();
        let drive = |cos: f64| (0.5 - 0.5 * cos).powi(degree as i32) + beside * (0.5 * cos).exp();
        for rtol in [1e-4, 1e-5, 1e-6, 1e-7, 1e-9, 1e-11] {
            let taylor = Taylor::new().rtol(rtol).atol(1e-3 * rtol);
            let exact = driven_from_rest(drive, 1.0, 12.0);
            let found = taylor.end(&machine, &State::at_rest(1), 12.0).unwrap().q[0];
            assert!((found - exact).abs() < 10.0 * rtol, "{degree}, {rtol:e}: {found} for {exact}");
            let points = Axis::of_values("speed", &[0.5, 1.0]).map(Points::from).unwrap();
            let sweep = Sweep::new(points).settle(1).measure(1).channels(&["q0"]).strobe(1);
            let rows = rows(&sweep, &LaneTaylor::new(taylor), &machine, &State::at_rest(1));
            for (i, speed) in [0.5, 1.0].into_iter().enumerate() {
                let exact = driven_from_rest(drive, speed, 2.0 * TAU / speed);
                let found = rows.get(i).unwrap().strobes().last().unwrap()[0];
                assert!((found - exact).abs() < 10.0 * rtol, "{degree}, lane {i}, {rtol:e}: {found} {exact}");
            }
        }
    }
}

/// The same pulse as a Fourier series that a shape gives as its wave.
#[test]
fn flat_pulses_as_fourier_series() {
    // ((1 - cos φ)/2)^12 = C(24, 12)/2^24 + Σ 2 (-1)^k C(24, 12 - k)/2^24 cos kφ.
    let binomial = |k: u32| (0..k).fold(1.0, |c, i| c * f64::from(24 - i) / f64::from(i + 1));
    let pairs: Vec<[f64; 2]> =
        (1..=12).map(|k| [2.0 * (-1f64).powi(k as i32) * binomial(12 - k) / 2f64.powi(24), 0.0]).collect();
    let pulse = Fourier::new(binomial(12) / 2f64.powi(24), &pairs).unwrap();
    let jump = RectangularWave::new(0.0, 0.0, 0.5).unwrap();
    #[derive(PartialEq)]
    struct Pulses([Wave; 2]);
    impl Shape for Pulses {
        fn size(&self) -> Size {
            Size { dof: 1, waves: 2, constants: 1, ..Size::default() }
        }
        fn names(&self) -> Vec<Channel> {
            vec![Channel::new("speed", "rad/s")]
        }
        fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
            u.iter_mut().zip(&self.0).for_each(|(u, wave)| *u = wave.value(angle, side));
        }
        fn accel<S: Scalar, L: PieceChoice<S>>(
            &self,
            _: &L,
            u: Drives<'_, S>,
            q: &[S],
            v: &[S],
            a: &mut [S],
        ) {
            let [pulse, none] = u.waves();
            a[0] = pulse + none - v[0] * 0.2 - q[0];
        }
        fn next_edge(&self, angle: f64) -> Option<f64> {
            self.0[1].next_edge(angle)
        }
    }
    let exact = driven_from_rest(|cos| (0.5 - 0.5 * cos).powi(12), 1.0, 12.0);
    // With edges beside it the series is expanded by itself.
    for other in [Wave::constant(0.0).unwrap(), Wave::new(jump)] {
        let shape = Pulses([Wave::new(pulse.clone()), other]);
        let machine = Machine::of_constants(shape, &[("speed", 1.0)]).unwrap();
        for rtol in [1e-4, 1e-5, 1e-6, 1e-7, 1e-9, 1e-11] {
            let taylor = Taylor::new().rtol(rtol).atol(1e-3 * rtol);
            let found = taylor.end(&machine, &State::at_rest(1), 12.0).unwrap().q[0];
            assert!((found - exact).abs() < 10.0 * rtol, "{rtol:e}: {found} for {exact}");
        }
    }
}

/// Powers of high degree by products, against short steps: they vanish in all coefficients away from their peak.
#[test]
fn products_of_high_degree() {
    for (squarings, pulse, force, start) in [
        (8, 3.0, 0.0, [0.8, 0.3]),
        (10, 3.0, 0.0, [0.8, 0.3]),
        (12, 3.0, 0.0, [0.8, 0.3]),
        (8, 0.0, 2.0, [3.0, 0.3]),
        (10, 0.0, 2.0, [3.0, 0.3]),
    ] {
        let constants = [("speed", 0.7), ("pulse", pulse), ("force", force)];
        let machine = Machine::of_constants(Peaks { squarings }, &constants).unwrap();
        let start = State::new(0.0, &start[..1], &start[1..]);
        let short = Dop853::new().rtol(1e-13).atol(1e-15).max_step(5e-3);
        let exact = short.end(&machine, &start, 30.0).unwrap().q[0];
        let sweep = Sweep::new(axis("speed", 0.7, 0.8, 2)).settle(1).measure(1).channels(&["q0"]).strobe(1);
        let turns = short.end(&machine, &start, 2.0 * machine.period()).unwrap().q[0];
        for rtol in [1e-6, 1e-8, 1e-10, 1e-12] {
            let taylor = Taylor::new().rtol(rtol);
            let found = taylor.end(&machine, &start, 30.0).unwrap().q[0];
            let within = 3000.0 * rtol + 1e-9;
            assert!((found - exact).abs() < within, "{squarings}, {force}, {rtol:e}: {found} for {exact}");
            let rows = rows(&sweep, &LaneTaylor::new(taylor), &machine, &start);
            let found = rows.get(0).unwrap().strobes().last().unwrap()[0];
            assert!((found - turns).abs() < within, "{squarings}, {force}, {rtol:e}: {found} for {turns}");
        }
    }
}

/// x'' = cos φ - x - A tanh(x'/v0), with tanh w = 2 h/(1 + h²) and h = tanh(w/2) = 1 - 2/(e^w + 1), whose
/// coefficients do not overflow for |x'| below 600 v0.
#[derive(PartialEq)]
struct Friction;

impl Shape for Friction {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 1, constants: 3, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        ["speed", "v0", "friction"].map(|name| Channel::new(name, "1")).into()
    }
    fn waves<A: Angle>(&self, angle: A, _: Side, u: &mut [A::Number]) {
        u[0] = angle.number().cos();
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let ([cos], [width, friction], one) = (u.waves(), u.constants(), S::from(1.0));
        let half = one - S::from(2.0) / ((v[0] / width).exp() + one);
        a[0] = cos - q[0] - friction * (half * 2.0 / (one + half * half));
    }
}

const METHODS: [FlowMethod; 2] = [FlowMethod::Taylor, FlowMethod::Dop853];

fn rubbing(width: f64) -> Machine<Friction> {
    Machine::of_constants(Friction, &[("speed", 0.7), ("v0", width), ("friction", 0.2)]).unwrap()
}

fn settled(machine: &Machine<Friction>) -> State {
    Settle::new().run(&Dop853::new(), machine, &State::at_rest(1)).unwrap().state
}

/// The state one period of the drive later, by steps that are shorter than the reversal of the friction.
fn return_of(machine: &Machine<Friction>, start: &State, width: f64) -> [f64; 2] {
    let short = Dop853::new().rtol(1e-13).atol(1e-15).max_step(0.05 * width);
    let end = short.end(machine, start, start.t + machine.period()).unwrap();
    [end.q[0], end.v[0]]
}

/// Orbits by both flows close under short steps, and have the same multipliers and exponents: their product
/// is exp ∫ -A tanh'(x'/v0)/v0 dt, and the sum of the exponents is its logarithm.
#[test]
fn orbits_and_exponents_with_friction_by_tanh() {
    for width in [0.03, 0.003] {
        let machine = rubbing(width);
        let start = settled(&machine);
        let orbits =
            METHODS.map(|method| Shooting::new().flow_method(method).solve(&machine, &start).unwrap());
        for orbit in &orbits {
            let state = &orbit.states()[0];
            let [q, v] = return_of(&machine, state, width);
            assert!((q - state.q[0]).abs() < 1e-11 && (v - state.v[0]).abs() < 1e-11, "{width}: {q} {v}");
        }
        let [a, b] = orbits.each_ref().map(|orbit| &orbit.states()[0]);
        assert!((a.q[0] - b.q[0]).abs() < 1e-11 && (a.v[0] - b.v[0]).abs() < 1e-11, "{width}: {a:?} {b:?}");
        let [a, b] = orbits.each_ref().map(|orbit| orbit.multipliers().values());
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).norm() < 1e-9, "{width}: {a} {b}");
        }
        let shrinks = (a[0] * a[1]).re.ln();
        for (method, tolerance) in METHODS.into_iter().flat_map(|method| [(method, 1e-9), (method, 1e-11)]) {
            let lyapunov = Lyapunov::new().settle(20).align(5).measure(40).flow_tolerance(tolerance);
            let exponents = lyapunov.flow_method(method).run(&machine, &start).unwrap();
            let (found, bars) = (exponents.per_period(), exponents.standard_error());
            // Local errors of some 60 steps in a period, larger ones in the reversals of a pair.
            let off = found[0] + found[1] - shrinks;
            assert!(off.abs() < 300.0 * tolerance, "{width}, {method:?}, {tolerance:e}: {off:e}");
            // A pair of complex multipliers has two equal exponents.
            let apart = (found[0] - 0.5 * shrinks).abs();
            assert!(apart < 3.0 * bars[0], "{width}: {found:?} {bars:?}");
        }
    }
}

/// A branch over the strength of the friction: every orbit closes under short steps.
#[test]
fn a_branch_with_friction_by_tanh() {
    for width in [0.03, 0.003] {
        let machine = rubbing(width);
        let start = settled(&machine);
        let ends = METHODS.map(|method| {
            let family = Family::over(&machine, ["friction"]).unwrap();
            let settings = Continuation::new(0.2, 0.24).shooting(Shooting::new().flow_method(method));
            let branch = settings.run(&family, &start).unwrap();
            assert!(branch.points().len() > 5, "{width}: {}", branch.points().len());
            for point in branch.points() {
                let (own, state) =
                    (machine.with("friction", point.parameter).unwrap(), &point.orbit.states()[0]);
                let [q, v] = return_of(&own, state, width);
                let off = (q - state.q[0]).abs().max((v - state.v[0]).abs());
                assert!(off < 1e-10, "{width}, {}: {off:e}", point.parameter);
            }
            let last = branch.points().last().unwrap();
            assert_eq!(last.parameter, 0.24);
            last.orbit.multipliers().values().to_vec()
        });
        for (a, b) in ends[0].iter().zip(&ends[1]) {
            assert!((a - b).norm() < 1e-9, "{width}: {a} {b}");
        }
    }
}

/// q'' = -f(q/w) with f(x) = x/√(1 + x²), a smooth step of plain `Scalar` operations.
#[derive(PartialEq)]
struct RootStep;

impl Shape for RootStep {
    fn size(&self) -> Size {
        Size { dof: 1, constants: 2, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        ["speed", "width"].map(|name| Channel::new(name, "1")).into()
    }
    fn waves<A: Angle>(&self, _: A, _: Side, _: &mut [A::Number]) {}
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], _: &[S], a: &mut [S]) {
        let [width] = u.constants();
        let x = q[0] / width;
        a[0] = -x / (S::from(1.0) + x * x).sqrt();
    }
}

/// Smooth steps x/√(1 + x²) and arctan x of the width w keep their energy v²/2 + w √(1 + x²) and v²/2 + w (x
/// arctan x - ln(1 + x²)/2), x = q/w. `Scalar` has no arctan: such a model is one of plain numbers.
#[test]
fn smooth_steps_keep_their_energy() {
    let start = State::new(0.0, &[1.0], &[0.0]);
    for width in [0.1, 0.01, 1e-3] {
        let arctan = from_fn(1, |_, q, _, a| a[0] = -(q[0] / width).atan()).unwrap();
        let of_arctan = |state: &State| {
            let x = state.q[0] / width;
            0.5 * state.v[0] * state.v[0] + width * (x * x.atan() - 0.5 * (x * x).ln_1p())
        };
        let root = Machine::of_constants(RootStep, &[("speed", 1.0), ("width", width)]).unwrap();
        let of_root = |state: &State| 0.5 * state.v[0] * state.v[0] + state.q[0].hypot(width);
        for rtol in [1e-6, 1e-9, 1e-12] {
            let (high, series) = (Dop853::new().rtol(rtol).atol(rtol / 100.0), Taylor::new().rtol(rtol));
            let found = [
                of_arctan(&high.end(&arctan, &start, 30.0).unwrap()) - of_arctan(&start),
                of_root(&high.end(&root, &start, 30.0).unwrap()) - of_root(&start),
                of_root(&series.end(&root, &start, 30.0).unwrap()) - of_root(&start),
            ];
            // About 20 passages and 100 to 600 steps, each with an error of the tolerance.
            assert!(found.iter().all(|off| off.abs() < 300.0 * rtol), "{width}, {rtol:e}: {found:?}");
        }
    }
}

/// Friction by arctan, x'' = cos 0.7t - x - 0.2 (2/π) arctan(x'/v0), against steps shorter than its reversal.
#[test]
fn friction_by_arctan() {
    for width in [0.03, 0.003] {
        let rubbing = from_fn(1, |t, q, v, a| {
            a[0] = (0.7 * t).cos() - q[0] - 0.2 * FRAC_2_PI * (v[0] / width).atan();
        });
        let rubbing = rubbing.unwrap().with_period(TAU / 0.7).unwrap();
        let rest = State::at_rest(1);
        let exact =
            Dop853::new().rtol(1e-13).atol(1e-15).max_step(0.05 * width).end(&rubbing, &rest, 60.0).unwrap();
        for rtol in [1e-6, 1e-8, 1e-10] {
            let high = Dop853::new().rtol(rtol).atol(rtol).end(&rubbing, &rest, 60.0).unwrap();
            assert!(
                (high.q[0] - exact.q[0]).abs() < 100.0 * rtol,
                "{width}, {rtol:e}: {}",
                high.q[0] - exact.q[0]
            );
        }
        let orbit = Shooting::new().solve(&rubbing, &exact).unwrap();
        let state = &orbit.states()[0];
        let short = Dop853::new().rtol(1e-13).atol(1e-15).max_step(0.05 * width);
        let end = short.end(&rubbing, state, state.t + rubbing.period()).unwrap();
        let off = (end.q[0] - state.q[0]).abs().max((end.v[0] - state.v[0]).abs());
        assert!(off < 1e-8, "{width}: {off:e}");
    }
}

/// q'' = 1 - q³ from rest at 0: the series has the orders 2, 8, 14, 20, .. only, and the last two may both be 0. The energy
/// q'²/2 - q + q⁴/4 stays 0, and q between 0 and 4^(1/3).
#[test]
fn series_with_gaps_from_rest() {
    let given = [("speed", 1.0), ("cubic stiffness", 1.0), ("mean force", 1.0)];
    let model = Oscillator::new(&given).unwrap();
    let rest = State::at_rest(1);
    let energy = |end: &State| 0.5 * end.v[0].powi(2) - end.q[0] + 0.25 * end.q[0].powi(4);
    for rtol in [1e-6, 3e-7, 1e-7, 1e-8, 1e-9, 1e-10, 1e-12] {
        let taylor = Taylor::new().rtol(rtol).atol(1e-2 * rtol);
        let end = taylor.end(&model, &rest, 10.0).unwrap();
        assert!(energy(&end).abs() < 100.0 * rtol, "{rtol:e}: {end:?}");
        let found = rows(
            &Sweep::new(axis("mean force", 1.0, 1.1, 2)).settle(0).measure(2).channels(&["q0"]),
            &LaneTaylor::new(taylor),
            &model,
            &rest,
        );
        for row in found.iter() {
            let q = row.channel("q0").unwrap();
            assert!(q.min > -1e-3 && q.max < 1.7, "{rtol:e}: {q:?}");
        }
    }
    for order in 4..=28 {
        let end = Taylor::new().order(order).end(&model, &rest, 10.0).unwrap();
        assert!(energy(&end).abs() < 1e-7, "order {order}: {end:?}");
    }
}

/// x'' = F - c x' - A sin¹²(x): near x = 0 the force lies below rounding, and the steps are long.
#[derive(PartialEq)]
struct PowerOfSine(u32);

impl Shape for PowerOfSine {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 0, constants: 4, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        ["speed", "force", "damping", "height"].map(|name| Channel::new(name, "1")).into()
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [force, damping, height] = u.constants();
        let sine = q[0].sin();
        a[0] = force - damping * v[0] - height * (1..self.0).fold(sine, |power, _| power * sine);
    }
}

#[test]
fn powers_of_sines_are_not_passed() {
    for exponent in [6, 9, 12, 13, 16] {
        let given = [("speed", 1.0), ("force", 0.3), ("damping", 0.1), ("height", 0.4)];
        let model = Machine::of_constants(PowerOfSine(exponent), &given).unwrap();
        let exact = Dop853::new().rtol(1e-12).atol(1e-14).end(&model, &State::at_rest(1), 12.0).unwrap();
        for rtol in [1e-6, 1e-9, 1e-12] {
            let end =
                Taylor::new().rtol(rtol).atol(1e-2 * rtol).end(&model, &State::at_rest(1), 12.0).unwrap();
            let off = (end.q[0] - exact.q[0]).abs();
            assert!(off < 1e3 * rtol + 1e-9, "sin^{exponent}, {rtol:e}: {off:e}");
        }
    }
}
