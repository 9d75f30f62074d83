//! Products of series, four side by side.

use crate::ode::taylor::coefficients::ORDERS;

/// Products per batch.
pub(super) const BATCH: usize = 4;

type Four = [f64; BATCH];

/// Four products that do not depend on one another, with the coefficients of their factors so far.
#[derive(Debug)]
pub(super) struct Products {
    /// Columns of the factors.
    pub(super) factors: [[u32; 2]; BATCH],
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
        Products { factors, out, a: [[0.0; BATCH]; ORDERS], b: [[0.0; BATCH]; ORDERS] }
    }

    /// Writes c_n = Σ a_j b_(n-j) of order n into its row of numbers.
    #[inline(always)]
    pub(super) fn order(&mut self, n: usize, x: &mut [f64]) {
        for (l, &[a, b]) in self.factors.iter().enumerate() {
            self.a[n][l] = x[a as usize];
            self.b[n][l] = x[b as usize];
        }
        let mut sums = [[0.0; BATCH]; 2];
        let terms = self.a[..=n].iter().zip(self.b[..=n].iter().rev());
        for (j, (a, b)) in terms.enumerate() {
            let sum = &mut sums[j % 2];
            for l in 0..BATCH {
                sum[l] += a[l] * b[l];
            }
        }
        for (l, out) in x[self.out..][..BATCH].iter_mut().enumerate() {
            *out = sums[0][l] + sums[1][l];
        }
    }
}
