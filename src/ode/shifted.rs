//! The linear equations of the stages of a Rosenbrock method.

use crate::contact::Piece;
use crate::excitation::Side;
use crate::model::Model;
use crate::model::structure::slopes::{Slopes, accelerate};

/// Step of the difference for ∂a/∂t, as a share of the step `[1]`.
const IN_TIME: f64 = 1e-3;

/// Relative accuracy for which the steps of differences for the Jacobian are chosen `[1]`.
const SLOPES: f64 = 1e-12;

/// (1/γ - h J) k = r for k = (k_q, k_v), with J = [[0, 1], [A_q, A_v]]:
///
/// (1/γ - h A_v - γ h² A_q) k_v = r_v + γ h A_q r_q,   k_q = γ (r_q + h k_v).
pub(crate) struct Shifted<'m, M: ?Sized> {
    gamma: f64,
    h: f64,
    slopes: Slopes<'m, M>,
    /// h ∂a/∂t along the drives.
    pub(crate) by_time: Vec<f64>,
    /// The factors of the matrix row by row: U, and L below its diagonal of ones.
    factors: Vec<f64>,
    /// The row that was exchanged with row i.
    pivots: Vec<usize>,
    /// Scratch: drives, accelerations.
    u: Vec<f64>,
    a: Vec<f64>,
}

impl<'m, M: Model + ?Sized> Shifted<'m, M> {
    pub(crate) fn new(model: &'m M, gamma: f64) -> Self {
        let n = model.dof();
        Shifted {
            gamma,
            h: 0.0,
            slopes: Slopes::new(model, vec![0.0; 2 * n], SLOPES),
            by_time: vec![0.0; n],
            factors: vec![0.0; n * n],
            pivots: vec![0; n],
            u: vec![0.0; model.drives()],
            a: vec![0.0; n],
        }
    }

    /// Takes the Jacobian and ∂a/∂t at the start of a step [t, h]. `sizes`: of coordinates and velocities.
    /// Returns the number of evaluations.
    pub(crate) fn take(
        &mut self,
        pieces: Option<&[Piece]>,
        [t, h]: [f64; 2],
        [y, k]: [&[f64]; 2],
        sizes: impl Fn(usize) -> f64,
    ) -> u64 {
        let n = self.a.len();
        let (q, v) = y.split_at(n);
        self.h = h;
        self.slopes.scale.iter_mut().enumerate().for_each(|(j, scale)| *scale = sizes(j));
        let model = self.slopes.model();
        model.drive(t, Side::After, &mut self.u);
        self.slopes.at(pieces, &self.u, q, v);
        // ∂a/∂t = (4 a(t + δ) - 3 a(t) - a(t + 2δ))/(2δ)
        let (delta, moves) = (IN_TIME * h, model.drives() > 0);
        for (weight, b) in self.by_time.iter_mut().zip(&k[n..]) {
            *weight = if moves { -3.0 * b } else { 0.0 };
        }
        if moves {
            for (weight, times) in [(4.0, 1.0), (-1.0, 2.0)] {
                model.drive(t + times * delta, Side::After, &mut self.u);
                accelerate(model, pieces, &self.u, q, v, &mut self.a);
                self.by_time.iter_mut().zip(&self.a).for_each(|(sum, a)| *sum += weight * a);
            }
            self.by_time.iter_mut().for_each(|sum| *sum *= 0.5 / IN_TIME);
        }
        self.factorise();
        let differences = if self.slopes.differenced { 4 * n as u64 } else { 0 };
        differences + 2 * u64::from(moves)
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
