//! How far each coordinate and velocity moves: the unit in which corrections, columns and errors are measured.

use crate::excitation::side::Side;
use crate::model::equations::Model;
use crate::model::slopes::{Slopes, accelerate};
use crate::ode::step::{Observer, Step};
use crate::roots::norms::remove;
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Watches runs and keeps the extremes of every coordinate and velocity, rigid motion left out.
pub(crate) struct Sizes {
    rigid: Vec<Vec<f64>>,
    y: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    /// The largest coordinate and the largest velocity, rigid motion among them.
    largest: [f64; 2],
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
            largest: [0.0; 2],
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
        if !self.rigid.is_empty() {
            self.largest = [(self.largest[0], q), (self.largest[1], v)]
                .map(|(m, y)| y.iter().fold(m, |m, y| m.max(y.abs())));
        }
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
            // Taking rigid motion out brings in the rounding of all coordinates, or of all velocities.
            if range > ROUNDING * value(i).max(self.largest[i / n]) { range } else { 0.0 }
        };
        let positive = |x: f64| (x > 0.0 && x.is_finite()).then_some(x);
        let fellows = |part: std::ops::Range<usize>| part.map(range).fold(0.0, f64::max);
        let q: Vec<f64> = (0..n)
            .map(|i| positive(range(i)).or(positive(fellows(0..n))).or(positive(value(i))).unwrap_or(1.0))
            .collect();
        let span = self.last - self.first;
        let rate = |i: usize| if span > 0.0 { TAU * q[i] / span } else { q[i] };
        let v = (0..n).map(|i| {
            positive(range(n + i))
                .or(positive(fellows(n..2 * n)))
                .or(positive(value(n + i)))
                .unwrap_or(rate(i))
        });
        let v: Vec<f64> = v.collect();
        [q, v].concat()
    }
}

/// What is left of each component by rounding: of its value, of the terms of its acceleration over a step, and of what its neighbours bring in.
///
/// With h the step and T_i = |a_i| + Σ_j |∂a_i/∂q_j q_j| + |∂a_i/∂v_j v_j| the terms that make up an acceleration, q_i is known to
/// ε (|q_i| + h |v_i| + h² T_i) and v_i to ε (|v_i| + h T_i). No tolerance below that can be held.
pub(crate) struct Rounding<'m, M: ?Sized> {
    slopes: Slopes<'m, M>,
    u: Vec<f64>,
    a: Vec<f64>,
    /// T_i.
    terms: Vec<f64>,
    /// The largest sum of coordinates, then of velocities, so far; without ε.
    largest: Vec<f64>,
}

/// The error estimate sums a dozen evaluations: it does not fall below this many roundings.
const ROUNDINGS: f64 = 16.0;

/// A coarse run, held to 1e-9, shows no motion below this share of the same sums.
const SEEN: f64 = 1e-9;

impl<'m, M: Model + ?Sized> Rounding<'m, M> {
    pub(crate) fn new(model: &'m M) -> Self {
        let n = model.dof();
        Rounding {
            slopes: Slopes::new(model, vec![0.0; 2 * n], 0.0),
            u: vec![0.0; model.drives()],
            a: vec![0.0; n],
            terms: vec![0.0; n],
            largest: vec![0.0; 2 * n],
        }
    }

    /// Units in which a flow can be held to `tolerance`: the ranges of motion, and where rounding forbids so fine a share, larger ones.
    pub(crate) fn units(&self, ranges: &[f64], tolerance: f64) -> Vec<f64> {
        let share = ROUNDINGS * f64::EPSILON / tolerance.max(f64::EPSILON);
        ranges.iter().zip(&self.largest).map(|(range, sum)| range.max(share * sum)).collect()
    }

    /// Ranges of motion that a coarse run can tell from rest.
    pub(crate) fn seen(&self, ranges: Vec<f64>) -> Vec<f64> {
        ranges.iter().zip(&self.largest).map(|(range, sum)| range.max(SEEN * sum)).collect()
    }
}

impl<M: Model + ?Sized> Observer for Rounding<'_, M> {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        if !step.crossings().is_empty() {
            return ControlFlow::Continue(()); // differences would straddle the edge
        }
        let (h, q, v) = (step.t1() - step.t0(), step.q1(), step.v1());
        let n = q.len();
        // Differences over a share of each value: what counts is slope times value.
        for (scale, y) in self.slopes.scale.iter_mut().zip(step.y1()) {
            *scale = scale.max(y.abs());
        }
        let model = self.slopes.model();
        model.drive(step.t1(), Side::Before, &mut self.u);
        accelerate(model, step.pieces(), &self.u, q, v, &mut self.a);
        self.slopes.at(step.pieces(), &self.u, q, v);
        let (by_q, by_v) = (&self.slopes.jacobian.q, &self.slopes.jacobian.v);
        let term =
            |slope: f64, y: f64| Some((slope * y).abs()).filter(|term| term.is_finite()).unwrap_or(0.0);
        for i in 0..n {
            let sum: f64 = (0..n).map(|j| term(by_q[(i, j)], q[j]) + term(by_v[(i, j)], v[j])).sum();
            self.terms[i] = sum + term(1.0, self.a[i]);
        }
        for i in 0..n {
            // Neighbours are off by the rounding of their own accelerations.
            let brought = |j: usize| {
                let speed = v[j].abs() + h * self.terms[j];
                h * term(by_q[(i, j)], speed) + h * term(by_v[(i, j)], self.terms[j])
            };
            let terms = self.terms[i] + (0..n).map(brought).sum::<f64>();
            let speed = v[i].abs() + h * terms;
            self.largest[i] = self.largest[i].max(q[i].abs() + h * speed);
            self.largest[n + i] = self.largest[n + i].max(speed);
        }
        ControlFlow::Continue(())
    }
}

impl Observer for Sizes {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        self.steps += 1;
        self.see(step.t1(), step.q1(), step.v1());
        ControlFlow::Continue(())
    }
}
