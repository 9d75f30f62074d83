//! Jumps of an acceleration where the model states no edge.

use crate::excitation::Side;
use crate::model::Model;
use crate::model::structure::slopes::accelerate;
use crate::ode::Step;

/// Only steps shorter than this share of the longest one are examined: a jump keeps steps short `[1]`.
const SHORT: f64 = 0.1;

/// Least jump, as a share of the largest value of its acceleration `[1]`.
const LEAST: f64 = 1e-6;

/// How often a step is halved. The change of a continuous acceleration falls with the length.
const HALVINGS: usize = 20;

/// Share of the change that a jump keeps over all halvings `[1]`.
const KEPT: f64 = 0.5;

/// Finds a step over which an acceleration jumps. The derivative of the flow would need the edge of the jump.
pub(crate) struct Jumps<'m> {
    model: &'m dyn Model,
    longest: f64,
    /// Largest absolute value of each acceleration so far.
    largest: Vec<f64>,
    /// Whether the last step ended at an edge: on an edge rounding decides the side.
    at_edge: bool,
    u: Vec<f64>,
    /// A state between two others: coordinates, then velocities.
    y: Vec<f64>,
    /// Accelerations at both ends of a part, and between them.
    a: [Vec<f64>; 3],
}

impl<'m> Jumps<'m> {
    pub(crate) fn new(model: &'m dyn Model) -> Self {
        let n = model.dof();
        let zeros = || vec![0.0; n];
        Jumps {
            model,
            longest: 0.0,
            largest: zeros(),
            at_edge: true,
            u: vec![0.0; model.drives()],
            y: vec![0.0; 2 * n],
            a: [zeros(), zeros(), zeros()],
        }
    }

    /// The acceleration that jumps over a step, away from the edges of the model. The drives are those at the
    /// end of the step: what they change is no jump over the states.
    pub(crate) fn over(&mut self, step: &Step<'_>) -> Option<usize> {
        let length = step.t1() - step.t0();
        let is_short = length < SHORT * self.longest;
        self.longest = self.longest.max(length);
        let starts_at_edge = std::mem::replace(&mut self.at_edge, !step.crossings().is_empty());
        if !is_short {
            self.model.drive(step.t1(), Side::Before, &mut self.u);
            self.see(step, 1.0, 1);
            return None;
        }
        if starts_at_edge || self.at_edge {
            return None;
        }
        self.model.drive(step.t1(), Side::Before, &mut self.u);
        self.see(step, 0.0, 0);
        self.see(step, 1.0, 1);
        let change = |a: &[Vec<f64>; 3], i: usize, [from, to]: [usize; 2]| (a[to][i] - a[from][i]).abs();
        let i = (0..self.largest.len()).max_by(|&i, &j| {
            let share = |i: usize| change(&self.a, i, [0, 1]) / self.largest[i].max(f64::MIN_POSITIVE);
            share(i).total_cmp(&share(j))
        })?;
        let whole = change(&self.a, i, [0, 1]);
        if whole <= LEAST * self.largest[i] {
            return None;
        }
        let (mut from, mut to) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (from + to);
            self.see(step, middle, 2);
            if change(&self.a, i, [0, 2]) > change(&self.a, i, [2, 1]) {
                self.a.swap(1, 2);
                to = middle;
            } else {
                self.a.swap(0, 2);
                from = middle;
            }
        }
        (change(&self.a, i, [0, 1]) > KEPT * whole).then_some(i)
    }

    /// Computes the accelerations at a share of a step, on its pieces.
    fn see(&mut self, step: &Step<'_>, share: f64, into: usize) {
        let n = self.largest.len();
        let ends = [(step.q0(), step.q1()), (step.v0(), step.v1())];
        for (y, (from, to)) in self.y.chunks_exact_mut(n).zip(ends) {
            for ((y, from), to) in y.iter_mut().zip(from).zip(to) {
                *y = from + share * (to - from);
            }
        }
        let (q, v) = self.y.split_at(n);
        accelerate(self.model, step.pieces(), &self.u, q, v, &mut self.a[into]);
        for (largest, a) in self.largest.iter_mut().zip(&self.a[into]) {
            *largest = largest.max(a.abs());
        }
    }
}
