//! Products of series, four side by side.

use crate::ode::taylor::coefficients::ORDERS;

/// Products per batch.
pub(super) const BATCH: usize = 4;

type Four = [f64; BATCH];

/// Four products that do not depend on one another, with the coefficients of their factors so far.
#[derive(Debug)]
pub(super) struct Products {
    /// Columns of the factors, and those on the present pieces.
    sources: [[u32; 2]; BATCH],
    factors: [[u32; 2]; BATCH],
    /// First of the four result columns.
    pub(super) out: usize,
    a: [Four; ORDERS],
    b: [Four; ORDERS],
}

impl Products {
    /// Up to four pairs of columns; `zero`: a column of zeros for the rest.
    pub(super) fn new(pairs: &[[u32; 2]], zero: u32, out: usize) -> Self {
        let mut factors = [[zero; 2]; BATCH];
        factors[..pairs.len()].copy_from_slice(pairs);
        Products { sources: factors, factors, out, a: [[0.0; BATCH]; ORDERS], b: [[0.0; BATCH]; ORDERS] }
    }

    /// Reads each factor from the column that `actual` gives for its own.
    pub(super) fn redirect(&mut self, actual: &[u32]) {
        self.factors = self.sources.map(|both| both.map(|column| actual[column as usize]));
    }

    /// Writes c_n = Σ a_j b_(n-j) of order n into its row of numbers.
    #[inline(always)]
    pub(super) fn order(&mut self, n: usize, x: &mut [f64]) {
        let newest = |side: usize| self.factors.map(|columns| x[columns[side] as usize]);
        let (newest_a, newest_b) = (newest(0), newest(1));
        // The newest coefficients are not read from memory, where they have just been written one by one.
        let (mut even, mut odd) = ([0.0; BATCH], [0.0; BATCH]);
        if n > 0 {
            for l in 0..BATCH {
                even[l] = newest_a[l] * self.b[0][l];
                odd[l] = self.a[0][l] * newest_b[l];
            }
            let (a, b) = (&self.a[1..n], &self.b[1..n]);
            let (pairs, reversed) = (a.chunks_exact(2), b.rchunks_exact(2));
            if let (Some(a), Some(b)) = (pairs.remainder().first(), reversed.remainder().first()) {
                for l in 0..BATCH {
                    even[l] += a[l] * b[l];
                }
            }
            for (a, b) in pairs.zip(reversed) {
                for l in 0..BATCH {
                    even[l] += a[0][l] * b[1][l];
                    odd[l] += a[1][l] * b[0][l];
                }
            }
        } else {
            for l in 0..BATCH {
                even[l] = newest_a[l] * newest_b[l];
            }
        }
        (self.a[n], self.b[n]) = (newest_a, newest_b);
        for (out, (even, odd)) in x[self.out..][..BATCH].iter_mut().zip(even.iter().zip(&odd)) {
            *out = even + odd;
        }
    }
}
