//! The linear equations of the stages of a Rosenbrock method.

use crate::contact::Piece;
use crate::model::Model;
use crate::model::structure::slopes::{Slopes, accelerate};
use crate::numeric::lagrange::lagrange;

/// Number of instants of a step from which ∂a/∂t is interpolated: the start and the nodes.
const INSTANTS: usize = 5;

/// Relative accuracy for which the steps of differences for the Jacobian are chosen `[1]`.
const SLOPES: f64 = 1e-12;

/// (1/γ - h J) k = r for k = (k_q, k_v), with J = [[0, 1], [A_q, A_v]]:
///
/// (1/γ - h A_v - γ h² A_q) k_v = r_v + γ h A_q r_q,   k_q = γ (r_q + h k_v).
pub(crate) struct Shifted<'m> {
    gamma: f64,
    h: f64,
    slopes: Slopes<'m>,
    /// h ∂a/∂t at the start of the step, at the state there.
    pub(crate) by_time: Vec<f64>,
    /// Weights of the accelerations at the instants in `by_time`.
    weights: [f64; INSTANTS],
    /// The factors of the matrix row by row: U, and L below its diagonal of ones.
    factors: Vec<f64>,
    /// The row that was exchanged with row i.
    pivots: Vec<usize>,
    /// Scratch: accelerations.
    a: Vec<f64>,
}

impl<'m> Shifted<'m> {
    /// `nodes`: four nodes of the method, as shares of the step.
    pub(crate) fn new(model: &'m dyn Model, gamma: f64, nodes: &[f64]) -> Self {
        let n = model.dof();
        let instants = std::array::from_fn(|i| if i == 0 { 0.0 } else { nodes[i - 1] });
        Shifted {
            gamma,
            h: 0.0,
            slopes: Slopes::new(model, vec![0.0; 2 * n], SLOPES),
            by_time: vec![0.0; n],
            weights: lagrange::<INSTANTS>(instants).map(|polynomial| polynomial[1]),
            factors: vec![0.0; n * n],
            pivots: vec![0; n],
            a: vec![0.0; n],
        }
    }

    /// Computes the Jacobian and ∂a/∂t at the state `y` at the start of a step `h`, and factorises the
    /// matrix. `drives`: those at the instants. `sizes`: of coordinates and velocities. Returns the number of
    /// evaluations.
    pub(crate) fn prepare(
        &mut self,
        pieces: Option<&[Piece]>,
        h: f64,
        y: &[f64],
        drives: [&[f64]; INSTANTS],
        sizes: impl Fn(usize) -> f64,
    ) -> u64 {
        let n = self.a.len();
        let (q, v) = y.split_at(n);
        self.h = h;
        self.slopes.scale.iter_mut().enumerate().for_each(|(j, scale)| *scale = sizes(j));
        self.slopes.at(pieces, drives[0], q, v);
        self.factorise();
        self.by_time.fill(0.0);
        let instants = if drives[0].is_empty() { 0 } else { INSTANTS };
        for (u, weight) in drives.into_iter().zip(self.weights).take(instants) {
            accelerate(self.slopes.model(), pieces, u, q, v, &mut self.a);
            self.by_time.iter_mut().zip(&self.a).for_each(|(sum, a)| *sum += weight * a);
        }
        let differences = if self.slopes.differenced { 4 * n } else { 0 };
        (differences + instants) as u64
    }

    /// Gaussian elimination with exchanges of rows, in place: that of a library allocates in every step.
    fn factorise(&mut self) {
        let (n, h) = (self.a.len(), self.h);
        let jacobian = &self.slopes.jacobian;
        for i in 0..n {
            for j in 0..n {
                let one = if i == j { 1.0 / self.gamma } else { 0.0 };
                self.factors[i * n + j] =
                    one - h * jacobian.v[(i, j)] - self.gamma * h * h * jacobian.q[(i, j)];
            }
        }
        for k in 0..n {
            let largest = |a: usize, b: usize| {
                let size = |i: usize| self.factors[i * n + k].abs();
                if size(b) > size(a) { b } else { a }
            };
            let pivot = (k + 1..n).fold(k, largest);
            self.pivots[k] = pivot;
            if pivot != k {
                (0..n).for_each(|j| self.factors.swap(k * n + j, pivot * n + j));
            }
            let (above, below) = self.factors.split_at_mut((k + 1) * n);
            let row = &above[k * n..];
            for other in below.chunks_exact_mut(n) {
                let factor = other[k] / row[k];
                other[k] = factor;
                other[k + 1..].iter_mut().zip(&row[k + 1..]).for_each(|(x, y)| *x -= factor * y);
            }
        }
    }

    /// Replaces r by k. A singular matrix gives a step that is not finite, and the step is repeated shorter.
    pub(crate) fn solve(&self, r: &mut [f64]) {
        let (n, gamma, h) = (self.a.len(), self.gamma, self.h);
        let (rq, k) = r.split_at_mut(n);
        for (i, k) in k.iter_mut().enumerate() {
            let stretched: f64 = rq.iter().enumerate().map(|(j, r)| self.slopes.jacobian.q[(i, j)] * r).sum();
            *k += gamma * h * stretched;
        }
        for i in 0..n {
            k.swap(i, self.pivots[i]);
        }
        for i in 0..n {
            let known: f64 = (0..i).map(|j| self.factors[i * n + j] * k[j]).sum();
            k[i] -= known;
        }
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|j| self.factors[i * n + j] * k[j]).sum();
            k[i] = (k[i] - known) / self.factors[i * n + i];
        }
        rq.iter_mut().zip(&*k).for_each(|(r, k)| *r = gamma * (*r + h * k));
    }
}
