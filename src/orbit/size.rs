//! How far each coordinate and velocity moves: the unit in which corrections, columns and errors are measured.

use crate::ode::{Observer, Step};
use crate::root::dot;
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Watches runs and keeps the extremes of every coordinate and velocity, rigid motion left out.
pub(crate) struct Sizes {
    rigid: Vec<Vec<f64>>,
    y: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    pub(crate) steps: usize,
    first: f64,
    last: f64,
}

/// Motion below this share of the value itself is rounding.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

impl Sizes {
    /// `rigid`: orthonormal directions of the coordinates that do not count.
    pub(crate) fn new(dof: usize, rigid: &[Vec<f64>]) -> Self {
        let m = 2 * dof;
        Sizes {
            rigid: rigid.to_vec(),
            y: vec![0.0; m],
            low: vec![f64::INFINITY; m],
            high: vec![f64::NEG_INFINITY; m],
            steps: 0,
            first: f64::INFINITY,
            last: f64::NEG_INFINITY,
        }
    }

    pub(crate) fn see(&mut self, t: f64, q: &[f64], v: &[f64]) {
        (self.first, self.last) = (self.first.min(t), self.last.max(t));
        let (y_q, y_v) = self.y.split_at_mut(q.len());
        y_q.copy_from_slice(q);
        y_v.copy_from_slice(v);
        for r in &self.rigid {
            remove(r, y_q);
            remove(r, y_v);
        }
        for ((y, low), high) in self.y.iter().zip(&mut self.low).zip(&mut self.high) {
            *low = low.min(*y);
            *high = high.max(*y);
        }
    }

    /// The range of each component; of one at rest, that of its fellows, or its value, or 1.
    pub(crate) fn ranges(&self) -> Vec<f64> {
        let n = self.low.len() / 2;
        let value = |i: usize| self.low[i].abs().max(self.high[i].abs());
        let range = |i: usize| {
            let range = self.high[i] - self.low[i];
            if range > ROUNDING * value(i) { range } else { 0.0 }
        };
        let positive = |x: f64| (x > 0.0 && x.is_finite()).then_some(x);
        let fellows = |part: std::ops::Range<usize>| part.map(range).fold(0.0, f64::max);
        let q: Vec<f64> = (0..n).map(|i| positive(range(i)).or(positive(fellows(0..n))).or(positive(value(i))).unwrap_or(1.0)).collect();
        let span = self.last - self.first;
        let rate = |i: usize| if span > 0.0 { TAU * q[i] / span } else { q[i] };
        let v = (0..n).map(|i| positive(range(n + i)).or(positive(fellows(n..2 * n))).or(positive(value(n + i))).unwrap_or(rate(i)));
        let v: Vec<f64> = v.collect();
        [q, v].concat()
    }
}

/// x - r (rᵀ x), r of length 1.
pub(crate) fn remove(r: &[f64], x: &mut [f64]) {
    let along = dot(r, x);
    x.iter_mut().zip(r).for_each(|(x, r)| *x -= along * r);
}

impl Observer for Sizes {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        self.steps += 1;
        self.see(step.t1(), step.q1(), step.v1());
        ControlFlow::Continue(())
    }
}
