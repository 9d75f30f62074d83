//! Pulses as sums of waves that cancel one another: added by the algebra, in waves, beside an edge, as Fourier series.

use crate::checks::powers::compare_with;
use crate::draw::Draw;
use crate::{Check, Outcome};
use gear_dynamics::Wave;
use gear_dynamics::contact::PieceChoice;
use gear_dynamics::excitation::{Angle, Fourier, RectangularWave, Side};
use gear_dynamics::model::{Channel, Drives, Scalar, Shape, Size};

/// The checks of this file.
pub const CHECKS: [Check; 1] = [Check { name: "cancelling-waves", run: cancelling }];

/// Where the terms of the pulse are added.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Added {
    /// Waves of this number of orders each; the algebra adds them.
    InGroups(usize),
    /// The pulse and another wave, less that wave.
    AsDifference,
    /// In one wave of a shape with an edge.
    BesideAnEdge,
    /// As two Fourier series, with an edge beside them or without one.
    AsTwoSeries(bool),
}

/// q'' = F + P p(Ωt) - c q' - k q - A q³, p = ((1 - cos (φ - φ0))/2)ⁿ as Σ a_k cos kφ + b_k sin kφ.
#[derive(Clone, Debug, PartialEq)]
struct Cancelling {
    mean: f64,
    pairs: Vec<[f64; 2]>,
    added: Added,
    parts: [Wave; 3],
}

impl Cancelling {
    fn new(n: usize, phase: f64, added: Added) -> Result<Self, String> {
        let binomial = |k: usize| (0..k).fold(1.0, |c, i| c * (2 * n - i) as f64 / (i + 1) as f64);
        let share = |k: usize| (-1f64).powi(k as i32) * binomial(n - k) / 4f64.powi(n as i32);
        let pairs: Vec<[f64; 2]> = (1..=n)
            .map(|k| {
                let (sin, cos) = (k as f64 * phase).sin_cos();
                [2.0 * share(k) * cos, 2.0 * share(k) * sin]
            })
            .collect();
        let part = |first: usize, last: usize| {
            let of = |k: usize| if (first..=last).contains(&k) { pairs[k - 1] } else { [0.0; 2] };
            Fourier::new(0.0, &(1..=n).map(of).collect::<Vec<_>>()).map(Wave::new)
        };
        let jump = RectangularWave::new(0.0, 0.0, 0.4).map(Wave::new);
        let parts = part(1, n / 2).and_then(|first| Ok([first, part(n / 2 + 1, n)?, jump?]));
        let parts = parts.map_err(|error| error.to_string())?;
        Ok(Cancelling { mean: share(0), pairs, added, parts })
    }
}

const NAMES: [&str; 6] = ["speed", "mean force", "force", "damping", "stiffness", "cubic"];

impl Shape for Cancelling {
    fn size(&self) -> Size {
        let waves = match self.added {
            Added::InGroups(orders) => self.pairs.len().div_ceil(orders),
            _ => 2,
        };
        Size { dof: 1, waves, constants: NAMES.len(), ..Size::default() }
    }
    fn names(&self) -> Vec<Channel> {
        NAMES.map(|name| Channel::new(name, "1")).into()
    }
    fn next_edge(&self, angle: f64) -> Option<f64> {
        match self.added {
            Added::BesideAnEdge | Added::AsTwoSeries(true) => self.parts[2].next_edge(angle),
            _ => None,
        }
    }
    fn waves<A: Angle>(&self, angle: A, side: Side, u: &mut [A::Number]) {
        let wave = |k: usize, [a, b]: [f64; 2]| {
            let (sin, cos) = (angle.number() * k as f64).sin_cos();
            cos * a + sin * b
        };
        let orders = self.pairs.len();
        let sum = |first: usize, count: usize, from: A::Number| {
            let last = (first + count).min(orders + 1);
            (first..last).fold(from, |sum, k| sum + wave(k, self.pairs[k - 1]))
        };
        let none = A::Number::from(0.0);
        match self.added {
            Added::InGroups(count) => {
                u.iter_mut().enumerate().for_each(|(i, u)| *u = sum(1 + i * count, count, none));
            }
            Added::AsDifference => {
                let other = wave(2, [0.3, 0.1]) + wave(3, [0.1, -0.2]);
                (u[0], u[1]) = (sum(1, orders, other), other);
            }
            Added::BesideAnEdge => (u[0], u[1]) = (sum(1, orders, none), none),
            Added::AsTwoSeries(_) => {
                let [first, second, jump] = self.parts.each_ref().map(|part| part.value(angle, side));
                (u[0], u[1]) = (first + second, jump);
            }
        }
    }
    fn accel<S: Scalar, L: PieceChoice<S>>(&self, _: &L, u: Drives<'_, S>, q: &[S], v: &[S], a: &mut [S]) {
        let waves = u.all_waves();
        let [mean, force, damping, stiffness, cubic] = u.constants();
        let sign = |i: usize| if i == 1 && self.added == Added::AsDifference { -1.0 } else { 1.0 };
        let from = S::from(self.mean);
        let pulse = waves.iter().enumerate().fold(from, |sum, (i, u)| sum + *u * sign(i));
        let x = q[0];
        a[0] = mean + force * pulse - damping * v[0] - stiffness * x - cubic * (x * x * x);
    }
}

fn cancelling(draw: &mut Draw) -> Outcome {
    let n = 4 + draw.below(25);
    let ways =
        [Added::AsDifference, Added::BesideAnEdge, Added::AsTwoSeries(true), Added::AsTwoSeries(false)];
    let added = if draw.below(2) == 0 { Added::InGroups(1 + draw.below(5)) } else { draw.one_of(&ways) };
    let phase = if draw.below(2) == 0 { 0.0 } else { draw.within(0.0, std::f64::consts::TAU) };
    let shape = match Cancelling::new(n, phase, added) {
        Ok(shape) => shape,
        Err(error) => return Outcome::Fails(error),
    };
    let or_none = |draw: &mut Draw, x: f64| if draw.below(2) == 0 { 0.0 } else { x };
    let [mean, damping, cubic] = [draw.scale(0.05, 0.5), draw.scale(0.01, 0.3), draw.scale(0.1, 1.0)];
    let values = [
        draw.scale(0.3, 2.0),
        or_none(draw, mean),
        draw.scale(0.1, 3.0),
        or_none(draw, damping),
        draw.scale(0.1, 2.0),
        or_none(draw, cubic),
    ];
    let start =
        if draw.below(2) == 0 { [0.0, 0.0] } else { [draw.within(-0.5, 0.5), draw.within(-0.3, 0.3)] };
    let f = move |t: f64, [x, v]: [f64; 2]| {
        let [speed, mean, force, damping, stiffness, cubic] = values;
        let pulse = (0.5 - 0.5 * (speed * t - phase).cos()).powi(n as i32);
        mean + force * pulse - damping * v - stiffness * x - cubic * x * x * x
    };
    compare_with(draw, shape, &NAMES, &values, f, start)
}
