//! Jumps of an acceleration where the model states no edge.

use crate::excitation::Side;
use crate::model::Model;
use crate::model::structure::slopes::accelerate;
use crate::numeric::search::jump::jump;
use crate::ode::Step;

/// Only steps shorter than this share of the longest one are examined: a jump keeps steps short `[1]`.
const SHORT: f64 = 0.1;

/// Least jump, as a share of the largest acceleration so far `[1]`. An acceleration that is 0 by the symmetry
/// of a model consists of the rounding of the others.
const LEAST: f64 = 1e-6;

/// Finds a step over which an acceleration jumps. The derivative of the flow would need the edge of the jump.
pub(crate) struct Jumps<'m> {
    model: &'m dyn Model,
    longest: f64,
    /// Largest acceleration so far.
    largest: f64,
    /// Whether the last step ended at an edge: on an edge rounding decides the side.
    at_edge: bool,
    u: Vec<f64>,
    /// A state between two others: coordinates, then velocities.
    y: Vec<f64>,
    /// Accelerations at the start of a step, at its end, and between.
    a: [Vec<f64>; 3],
}

impl<'m> Jumps<'m> {
    pub(crate) fn new(model: &'m dyn Model) -> Self {
        let n = model.dof();
        let zeros = || vec![0.0; n];
        Jumps {
            model,
            longest: 0.0,
            largest: 0.0,
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
        let change = |i: usize| (self.a[1][i] - self.a[0][i]).abs();
        let i = (0..self.a[0].len()).max_by(|&i, &j| change(i).total_cmp(&change(j)))?;
        if change(i) <= LEAST * self.largest {
            return None;
        }
        let ends = [self.a[0][i], self.a[1][i]];
        let at = |share: f64| {
            self.see(step, share, 2);
            self.a[2][i]
        };
        jump(ends, at).map(|_| i)
    }

    /// Computes the accelerations at a share of a step, on its pieces.
    fn see(&mut self, step: &Step<'_>, share: f64, into: usize) {
        let n = self.a[into].len();
        let ends = [(step.q0(), step.q1()), (step.v0(), step.v1())];
        for (y, (from, to)) in self.y.chunks_exact_mut(n).zip(ends) {
            for ((y, from), to) in y.iter_mut().zip(from).zip(to) {
                *y = from + share * (to - from);
            }
        }
        let (q, v) = self.y.split_at(n);
        accelerate(self.model, step.pieces(), &self.u, q, v, &mut self.a[into]);
        self.largest = self.a[into].iter().fold(self.largest, |most, a| most.max(a.abs()));
    }
}
