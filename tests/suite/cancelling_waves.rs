//! Taylor series of waves that cancel one another: a sum is 0 with many coefficients at one angle and large at the
//! next, although each of its terms varies.

use crate::api::*;
use crate::lane_taylor::rows;
use crate::steep_forces::driven_from_rest;
use gear_dynamics::contact::Deflection;
use gear_dynamics::drives::{SpeedLaw, VaryingSpeed};
use gear_dynamics::excitation::RectangularWave;
use gear_dynamics::linear::static_state;
use gear_dynamics::sweep::{Axis, Points};
use gear_dynamics::trains::{Body, MeshPart, Parts};
use std::f64::consts::TAU;

/// Where the terms of the pulse are added.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Added {
    /// Each wave has one order; the algebra adds them.
    ByAlgebra,
    /// Each wave has one order; the algebra multiplies them by constants, and adds them.
    WithConstants,
    /// Each wave has three orders.
    InThrees,
    /// The pulse and another wave, less that wave.
    AsDifference,
    /// In one wave of a shape with an edge.
    BesideAnEdge,
    /// As two Fourier series in one wave of a shape with an edge.
    AsTwoSeries,
}

/// x'' = ((1 - cos φ)/2)^n - 0.2 x' - x, the pulse as a sum of cosines.
#[derive(PartialEq)]
struct Cancelling {
    /// The coefficients, by order from 0.
    a: Vec<f64>,
    added: Added,
    /// The two halves of the series, and a wave with an edge.
    parts: [Wave; 3],
}

impl Cancelling {
    fn new(n: usize, added: Added) -> Self {
        // ((1 - cos φ)/2)^n = C(2n, n)/4^n + Σ 2 (-1)^k C(2n, n - k)/4^n cos kφ.
        let binomial = |k: usize| (0..k).fold(1.0, |c, i| c * (2 * n - i) as f64 / (i + 1) as f64);
        let weight = |k: usize| if k == 0 { 1.0 } else { 2.0 * (-1f64).powi(k as i32) };
        let a: Vec<f64> = (0..=n).map(|k| weight(k) * binomial(n - k) / 4f64.powi(n as i32)).collect();
        let part = |orders: std::ops::RangeInclusive<usize>| {
            let pairs: Vec<_> =
                (1..=n).map(|k| [if orders.contains(&k) { a[k] } else { 0.0 }, 0.0]).collect();
            Wave::new(Fourier::new(0.0, &pairs).unwrap())
        };
        let jump = Wave::new(RectangularWave::new(0.0, 0.0, 0.5).unwrap());
        let parts = [part(1..=n / 2), part(n / 2 + 1..=n), jump];
        Cancelling { a, added, parts }
    }
    fn orders(&self) -> usize {
        self.a.len() - 1
    }
}

impl Shape for Cancelling {
    fn size(&self) -> Size {
        let (waves, constants) = match self.added {
            Added::ByAlgebra => (self.orders(), 1),
            Added::WithConstants => (self.orders(), 1 + self.orders()),
            Added::InThrees => (self.orders().div_ceil(3), 1),
            _ => (2, 1),
        };
        Size { dof: 1, waves, constants, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        let factors = (1..self.size().constants).map(|k| Channel::new(format!("factor {k}"), "1"));
        std::iter::once(Channel::new("speed", "rad/s")).chain(factors).collect()
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        matches!(self.added, Added::BesideAnEdge | Added::AsTwoSeries)
            .then(|| self.parts[2].next_edge(angle))?
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        let cos = |k: usize| (angle.number() * k as f64).cos();
        let sum = |first: usize, last: usize, from: A::Number| {
            (first..=last.min(self.orders())).fold(from, |sum, k| sum + cos(k) * self.a[k])
        };
        let none = A::Number::from(0.0);
        match self.added {
            Added::ByAlgebra | Added::WithConstants => (1..).zip(u).for_each(|(k, u)| *u = cos(k)),
            Added::InThrees => (0..).zip(u).for_each(|(i, u)| *u = sum(3 * i + 1, 3 * i + 3, none)),
            Added::AsDifference => {
                let other = cos(2) * 0.3 + cos(3) * 0.2;
                (u[0], u[1]) = (sum(1, self.orders(), other), other);
            }
            Added::BesideAnEdge => (u[0], u[1]) = (sum(1, self.orders(), none), none),
            Added::AsTwoSeries => {
                let [first, second, jump] = self.parts.each_ref().map(|part| part.value(angle, side));
                (u[0], u[1]) = (first + second, jump);
            }
        }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let (waves, constants) = (u.all_waves(), u.all_constants());
        let terms = waves.iter().enumerate().map(|(i, u)| match self.added {
            Added::ByAlgebra => *u * self.a[i + 1],
            Added::WithConstants => *u * constants[i],
            Added::AsDifference if i == 1 => -*u,
            _ => *u,
        });
        let pulse = terms.fold(S::from(self.a[0]), |sum, term| sum + term);
        a[0] = pulse - v[0] * 0.2 - q[0];
    }
}

fn machine(n: usize, added: Added) -> Machine<Cancelling> {
    let shape = Cancelling::new(n, added);
    let factors: Vec<f64> = if added == Added::WithConstants { shape.a[1..].to_vec() } else { Vec::new() };
    let names: Vec<String> = shape.names().iter().map(|name| name.name.clone()).collect();
    let values = std::iter::once(1.0).chain(factors);
    let constants: Vec<(&str, f64)> = names.iter().map(String::as_str).zip(values).collect();
    Machine::of_constants(shape, &constants).unwrap()
}

/// Closed forms of x from rest, the force as the pulse itself.
#[test]
fn pulses_added_across_waves() {
    use Added::{AsDifference, AsTwoSeries, BesideAnEdge, ByAlgebra, InThrees, WithConstants};
    for added in [ByAlgebra, WithConstants, InThrees, AsDifference, BesideAnEdge, AsTwoSeries] {
        for n in [8, 12, 16, 20, 30] {
            let machine = machine(n, added);
            let pulse = |cos: f64| (0.5 - 0.5 * cos).powi(n as i32);
            for rtol in [1e-4, 1e-6, 1e-8, 1e-10] {
                let taylor = Taylor::new().rtol(rtol).atol(1e-2 * rtol);
                let exact = driven_from_rest(pulse, 1.0, 2.0 * TAU);
                let found = taylor.end(&machine, &State::at_rest(1), 2.0 * TAU).unwrap().q[0];
                let within = 10.0 * rtol + 1e-12;
                assert!((found - exact).abs() < within, "{added:?} {n}, {rtol:e}: {found} {exact}");
                let points = Axis::of_values("speed", &[0.5, 1.0]).map(Points::from).unwrap();
                let sweep = Sweep::new(points).settle(1).measure(1).channels(&["q0"]).strobe(1);
                let rows = rows(&sweep, &LaneTaylor::new(taylor), &machine, &State::at_rest(1));
                for (i, speed) in [0.5, 1.0].into_iter().enumerate() {
                    let exact = driven_from_rest(pulse, speed, 2.0 * TAU / speed);
                    let found = rows.get(i).unwrap().strobes().last().unwrap()[0];
                    assert!((found - exact).abs() < within, "{added:?} {n}, lane {i}, {rtol:e}: {found}");
                }
            }
        }
    }
}

/// x'' = w - 0.2 x' - x with w = Σ (-1)^j C(7, j)/128 cos (first + j) φ.
#[derive(PartialEq)]
struct Beat {
    first: u32,
    /// The wave as a Fourier series; without it as a sum of cosines.
    series: Option<Wave>,
}

impl Beat {
    const WEIGHTS: [f64; 8] = [1.0, -7.0, 21.0, -35.0, 35.0, -21.0, 7.0, -1.0];

    fn new(first: u32, as_series: bool) -> Self {
        let mut pairs = vec![[0.0; 2]; first as usize + 7];
        pairs[first as usize - 1..].iter_mut().zip(Self::WEIGHTS).for_each(|(pair, c)| pair[0] = c / 128.0);
        let series = Wave::new(Fourier::new(0.0, &pairs).unwrap());
        Beat { first, series: as_series.then_some(series) }
    }
}

impl Shape for Beat {
    fn size(&self) -> Size {
        Size { dof: 1, waves: 1, constants: 1, contacts: 1, ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        vec![Channel::new("speed", "rad/s")]
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        if let Some(series) = &self.series {
            return u[0] = series.value(angle, side);
        }
        let wave =
            |(j, weight): (u32, f64)| (angle.number() * f64::from(self.first + j)).cos() * (weight / 128.0);
        u[0] = (0..).zip(Self::WEIGHTS).map(wave).fold(A::Number::from(0.0), |sum, wave| sum + wave);
    }
    fn contact<S: Scalar, L: PieceChoice<S>>(
        &self,
        law: &L,
        _: usize,
        u: Drives<'_, S>,
        q: &[S],
        v: &[S],
    ) -> Contact<S> {
        let [wave] = u.waves();
        let (lower, upper) = (S::from(f64::NEG_INFINITY), S::from(0.5));
        let deflection = Deflection { d: q[0] - wave * 0.3, rate: v[0], lower, upper };
        let force = law.force(0, &Backlash::new(0.0).unwrap(), deflection) * 5.0;
        Contact { deflection: deflection.d, rate: v[0], lower, upper, force, ..Contact::default() }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, law: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let [wave] = u.waves();
        a[0] = wave * 0.1 + S::from(0.05) - v[0] * 0.1 - q[0] * 0.5 - self.contact(law, 0, u, q, v).force;
    }
}

/// At late times the angles of high orders had fewer digits than the tolerances ask for, and steps did not end.
#[test]
fn checked_waves_at_late_times() {
    for (first, as_series) in [(40, true), (100, true), (40, false), (100, false)] {
        let machine = Machine::of_constants(Beat::new(first, as_series), &[("speed", 1.0)]).unwrap();
        let run = |periods: f64, rtol: f64| {
            let (from, taylor) = (periods * TAU, Taylor::new().rtol(rtol).atol(1e-2 * rtol).max_steps(2000));
            let mut none = |_: &mut Step<'_>| std::ops::ControlFlow::Continue(());
            let start = State::new(from, &[0.3], &[0.1]);
            let finish = taylor.run(&machine, &start, from + 2.0 * TAU, &mut none).unwrap();
            (finish.state.q[0], finish.stats.steps)
        };
        for rtol in [1e-9, 1e-11, 1e-12, 1e-13] {
            let (exact, steps) = run(0.0, rtol);
            for periods in [100.0, 1e3, 1e4, 1e5] {
                let (late, late_steps) = run(periods, rtol);
                // Rounding of the time: half a unit in its last digit, times the speed, for some instants.
                let within = 1e-11 + 100.0 * rtol + 1e-15 * periods * TAU * f64::from(first);
                assert!((late - exact).abs() < within, "{first}, {rtol:e}, {periods}: {late} for {exact}");
                assert!(late_steps < 2 * steps, "{first}, {rtol:e}, {periods}: {late_steps} for {steps}");
            }
        }
    }
}

/// The recurrence of the orders of a Fourier series counted as a product of high degree, and steps ended at its zeros.
#[test]
fn many_orders_under_a_speed_law() {
    for orders in [2, 5, 8, 20] {
        let pairs: Vec<[f64; 2]> = (1..=orders).map(|k| [4e7 / f64::from(k), 2e7 / f64::from(k)]).collect();
        let stiffness = Wave::new(Fourier::new(2e8, &pairs).unwrap());
        let mut parts = Parts::new();
        parts.body("pinion", Body::new(1e-3)).body("wheel", Body::new(4e-3));
        let mesh = MeshPart::external([20, 40], [0.03, 0.06], stiffness).half_backlash(5e-5).damping(2000.0);
        parts.mesh("mesh", "pinion", "wheel", mesh);
        parts.torque("drive", "pinion", 60.0).torque("load", "wheel", -120.0);
        let train = parts.build("pinion", 100.0).unwrap();
        let start = State::new(0.0, &static_state(&train, None).unwrap().state.q, &vec![0.0; train.dof()]);
        let varying = VaryingSpeed::new(train, SpeedLaw::ramp(100.0, 150.0, 0.1).unwrap());
        let taylor = Taylor::new().rtol(1e-8).atol(1e-14).max_steps(5000).end(&varying, &start, 0.1).unwrap();
        let dop = Dop853::new().rtol(1e-10).atol(1e-16).end(&varying, &start, 0.1).unwrap();
        let apart = taylor.q.iter().zip(&dop.q).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        assert!(apart < 1e-10, "{orders}: {apart:e}");
    }
}
