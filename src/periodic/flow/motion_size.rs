//! Ranges of motion and rounding errors of coordinates and velocities: the units of corrections, differences
//! and errors.

use crate::excitation::side::Side;
use crate::model::equations::Model;
use crate::model::slopes::{Slopes, accelerate};
use crate::numeric::norms::remove;
use crate::ode::step::{Observer, Step};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Observer that keeps the minimum and the maximum of every coordinate and velocity, without rigid motion.
pub(crate) struct Sizes {
    rigid: Vec<Vec<f64>>,
    y: Vec<f64>,
    /// A state inside a step.
    inside: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    /// Largest |q_i| and largest |v_i|, rigid motion included; 0 without rigid modes.
    largest: [f64; 2],
    pub(crate) steps: usize,
    /// First and last time.
    first: f64,
    last: f64,
}

/// A range below this share of the values is rounding and counts as 0 `[1]`.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

impl Sizes {
    /// `rigid`: orthonormal directions of rigid motion in the coordinates.
    pub(crate) fn new(dof: usize, rigid: &[Vec<f64>]) -> Self {
        let m = 2 * dof;
        Sizes {
            rigid: rigid.to_vec(),
            y: vec![0.0; m],
            inside: vec![0.0; m],
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

    /// Range (max - min) of each coordinate, then of each velocity.
    ///
    /// A coordinate at rest gets the largest range of all coordinates; if all are at rest, its largest
    /// absolute value; if that is 0, the value 1. The same holds for a velocity, except that the last value
    /// is 2π (range of its coordinate)/(observed time).
    pub(crate) fn ranges(&self) -> Vec<f64> {
        let n = self.low.len() / 2;
        let value = |i: usize| self.low[i].abs().max(self.high[i].abs());
        let range = |i: usize| {
            let range = self.high[i] - self.low[i];
            // The removal of rigid motion mixes the rounding errors of all coordinates, or of all velocities.
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

/// ε (|q_i| + h |v_i| + h² T_i) and ε (|v_i| + h T_i): rounding errors of q_i and v_i in a step of length h.
///
/// T_i = S_i + h Σ_j (|∂a_i/∂q_j| (|v_j| + h S_j) + |∂a_i/∂v_j| S_j) is the sum of the terms of an
/// acceleration, S_i = |a_i| + Σ_j (|∂a_i/∂q_j q_j| + |∂a_i/∂v_j v_j|), and of the rounding errors that the
/// other components contribute. No integration meets a tolerance below these errors. The observer keeps their
/// maximum.
pub(crate) struct Rounding<'m, M: ?Sized> {
    slopes: Slopes<'m, M>,
    u: Vec<f64>,
    a: Vec<f64>,
    /// S_i.
    terms: Vec<f64>,
    /// Largest sum of each coordinate, then of each velocity, so far, without the factor ε.
    largest: Vec<f64>,
}

/// Smallest error estimate of a step, in rounding errors: it is a sum over a dozen evaluations.
const ROUNDINGS: f64 = 16.0;

/// A coarse run, with tolerance 1e-9, does not resolve a motion below this share of the same sums.
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

    /// Units of coordinates and velocities for a flow with `tolerance`: the ranges of motion, or
    /// 16 ε/tolerance times the sum where that is larger, so that the tolerance is above the rounding error.
    pub(crate) fn units(&self, ranges: &[f64], tolerance: f64) -> Vec<f64> {
        let share = ROUNDINGS * f64::EPSILON / tolerance.max(f64::EPSILON);
        ranges.iter().zip(&self.largest).map(|(range, sum)| range.max(share * sum)).collect()
    }

    /// The ranges of motion, each raised to at least [`SEEN`] times the largest sum |q| + h |v| + h² T or
    /// |v| + h T of its component. The run that measures the ranges cannot distinguish a smaller motion from
    /// rest.
    pub(crate) fn seen(&self, ranges: Vec<f64>) -> Vec<f64> {
        ranges.iter().zip(&self.largest).map(|(range, sum)| range.max(SEEN * sum)).collect()
    }
}

impl<M: Model + ?Sized> Observer for Rounding<'_, M> {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        if !step.crossings().is_empty() {
            return ControlFlow::Continue(()); // at an edge the differences would mix two pieces
        }
        // A step of high order is as accurate as shorter steps, one for each of its parts.
        let ((from, to), q, v) = (step.part(0), step.q1(), step.v1());
        let h = to - from;
        let n = q.len();
        // The step of the differences follows the values, since the terms are slope times value.
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
            // The other components have the rounding errors of their own accelerations.
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
        // Inside a step of high order the parts show the range.
        let parts = step.parts();
        self.steps += parts;
        for part in 1..parts {
            let t = step.part(part).0;
            let mut y = std::mem::take(&mut self.inside);
            step.at(t, &mut y);
            let (q, v) = y.split_at(y.len() / 2);
            self.see(t, q, v);
            self.inside = y;
        }
        self.see(step.t1(), step.q1(), step.v1());
        ControlFlow::Continue(())
    }
}
