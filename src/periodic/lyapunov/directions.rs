//! Directions of perturbation growth: drawn, measured and kept orthonormal.

use crate::model::State;
use crate::numeric::norms::dot;
use crate::numeric::split_mix::{GOLDEN_GAMMA, mix};

/// The directions of one run, in units of `scale`.
pub(crate) struct Directions<'s> {
    columns: Vec<f64>,
    /// The directions at the end of the last part, and of the last period.
    earlier: [Vec<f64>; 2],
    lengths: Vec<f64>,
    /// Σ ln r_kk of each direction: the logarithm of its growth.
    pub(crate) growth: Vec<f64>,
    scale: &'s [f64],
}

impl<'s> Directions<'s> {
    pub(crate) fn new(count: usize, scale: &'s [f64]) -> Self {
        Directions {
            columns: vec![0.0; count * scale.len()],
            earlier: [(); 2].map(|()| vec![0.0; count * scale.len()]),
            lengths: vec![0.0; count],
            growth: vec![0.0; count],
            scale,
        }
    }

    /// Draws random orthonormal directions: components uniform in [-1, 1) times their size, then
    /// Gram-Schmidt. The seed is computed from the start: equal starts give equal directions. Source:
    /// splitmix64 of Steele, Lea & Flood, OOPSLA 2014.
    pub(crate) fn draw(&mut self, start: &State, all: &mut State) {
        let numbers = start.q.iter().chain(&start.v).chain([&start.t]);
        let mut seed =
            numbers.fold(0_u64, |seed, x| mix(seed.wrapping_add(x.to_bits()).wrapping_add(GOLDEN_GAMMA)));
        let n = self.scale.len() / 2;
        let (of_q, of_v) = self.scale.split_at(n);
        for (half, scale) in [(&mut all.q, of_q), (&mut all.v, of_v)] {
            for (x, size) in half[n..].iter_mut().zip(scale.iter().cycle()) {
                seed = mix(seed.wrapping_add(GOLDEN_GAMMA));
                *x = size * ((seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0);
            }
        }
        self.measure(all);
        self.accept(all);
        self.growth.fill(0.0);
    }

    /// Gram-Schmidt in units of `scale`: w_k = y_k - Σ_{j<k} e_j (e_jᵀ y_k), r_kk = |w_k|, e_k = w_k/r_kk.
    /// The growth of direction k is r_kk.
    ///
    /// Returns the index and the length of the shortest direction; a length that is not finite counts as 0.
    pub(crate) fn measure(&mut self, all: &State) -> (usize, f64) {
        let (m, count) = (self.scale.len(), self.growth.len());
        let n = m / 2;
        let (of_q, of_v) = self.scale.split_at(n);
        let mut least = (0, f64::INFINITY);
        for k in 0..count {
            let (before, rest) = self.columns.split_at_mut(k * m);
            let column = &mut rest[..m];
            let (q, v) = (&all.q[n * (1 + k)..][..n], &all.v[n * (1 + k)..][..n]);
            for (x, (y, s)) in column.iter_mut().zip(q.iter().zip(of_q).chain(v.iter().zip(of_v))) {
                *x = y / s;
            }
            before.chunks_exact(m).for_each(|other| crate::numeric::norms::remove(other, column));
            let length = dot(column, column).sqrt();
            self.lengths[k] = length;
            let length = if length.is_finite() { length } else { 0.0 };
            if length < least.1 {
                least = (k, length);
            }
            column.iter_mut().for_each(|x| *x /= length);
        }
        least
    }

    /// The angle between direction k and the same one at the last [`mark`](Directions::mark) `[rad]`: that of
    /// a part, 0, or of a period, 1.
    pub(crate) fn turned(&self, k: usize, since: usize) -> f64 {
        let m = self.scale.len();
        let (now, then) = (&self.columns[k * m..][..m], &self.earlier[since][k * m..][..m]);
        let way = dot(now, then).signum();
        let apart: f64 = now.iter().zip(then).map(|(a, b)| (a - way * b).powi(2)).sum();
        2.0 * (0.5 * apart.sqrt()).min(1.0).asin()
    }
    /// Keeps the directions as those to which [`turned`](Directions::turned) refers.
    pub(crate) fn mark(&mut self, since: usize) {
        self.earlier[since].copy_from_slice(&self.columns);
    }

    /// Continues with the measured e_k as new directions and adds ln r_kk to the growth.
    pub(crate) fn accept(&mut self, all: &mut State) {
        let m = self.scale.len();
        let n = m / 2;
        let (of_q, of_v) = self.scale.split_at(n);
        for (k, column) in self.columns.chunks_exact(m).enumerate() {
            self.growth[k] += self.lengths[k].ln();
            let (q, v) = (&mut all.q[n * (1 + k)..][..n], &mut all.v[n * (1 + k)..][..n]);
            for (x, (y, s)) in column.iter().zip(q.iter_mut().zip(of_q).chain(v.iter_mut().zip(of_v))) {
                *y = x * s;
            }
        }
    }
}
