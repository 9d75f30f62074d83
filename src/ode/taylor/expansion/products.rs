//! Products of series, four side by side.

use crate::ode::taylor::expansion::rows::EIGHT;
use crate::series::Series;

/// Products per batch.
pub(super) const BATCH: usize = 4;

type Four = [f64; BATCH];

/// Up to four products that do not depend on one another, with the coefficients of their factors so far.
#[derive(Debug)]
pub(crate) struct Products {
    /// Columns of the factors.
    sources: Vec<[u32; 2]>,
    /// Columns of the factors on the present pieces.
    factors: [[u32; 2]; BATCH],
    /// Whether each product depends on a root or a power.
    of_power: [bool; BATCH],
    /// First of the result columns.
    out: usize,
    /// Coefficients of the first factors, and those of the second ones in reversed order up to `LAST`. A
    /// batch of one product has one number in each place, not four. `a` is cleared at order 0: the sums run
    /// on beyond their last term, over zeros.
    a: [Four; ROOM],
    b: [Four; ROOM],
}

/// Place of order 0 of the second factors.
const LAST: usize = Series::CAPACITY - 1;

/// Places of the factors. The last four are always 0.
const ROOM: usize = Series::CAPACITY + 4;

/// sum += a b.
#[inline(always)]
fn add(sum: &mut Four, a: &Four, b: &Four) {
    for l in 0..BATCH {
        sum[l] += a[l] * b[l];
    }
}

impl Products {
    /// Up to four pairs of columns, each with the answer whether it depends on a root or a power.
    pub(super) fn new(pairs: &[([u32; 2], bool)], out: usize) -> Self {
        let zeros = [[0.0; BATCH]; ROOM];
        let mut products = Products {
            sources: pairs.iter().map(|(pair, _)| *pair).collect(),
            factors: [[0; 2]; BATCH],
            of_power: [false; BATCH],
            out,
            a: zeros,
            b: zeros,
        };
        for (l, &(pair, of_power)) in pairs.iter().enumerate() {
            (products.factors[l], products.of_power[l]) = (pair, of_power);
        }
        products
    }

    /// Reads each factor from the column that `actual` gives for its own.
    pub(super) fn redirect(&mut self, actual: &[u32]) {
        for (factors, source) in self.factors.iter_mut().zip(&self.sources) {
            *factors = source.map(|column| actual[column as usize]);
        }
    }

    /// Writes c_n = Σ a_j b_(n-j) of order n into its row of numbers. `FIRST`: whether n is 0.
    #[inline(always)]
    pub(crate) fn order<const FIRST: bool>(&mut self, n: usize, x: &mut [f64]) {
        if self.sources.len() == 1 {
            return self.alone::<FIRST>(n, x);
        }
        let newest_a: Four = std::array::from_fn(|l| x[self.factors[l][0] as usize]);
        let newest_b: Four = std::array::from_fn(|l| x[self.factors[l][1] as usize]);
        // The newest coefficients come last, so that the other terms need not wait for them. They are not
        // read from memory, where they have just been written one by one.
        let (mut sum, mut other) = ([0.0; BATCH], [0.0; BATCH]);
        if !FIRST {
            // The terms after order n - 1 are 0.
            let count = (n + 2) / 4;
            let of_a = self.a[1..][..4 * count].as_chunks::<4>().0;
            let of_b = self.b[LAST + 1 - n..][..4 * count].as_chunks::<4>().0;
            for (a, b) in of_a.iter().zip(of_b) {
                add(&mut sum, &a[0], &b[0]);
                add(&mut other, &a[1], &b[1]);
                add(&mut sum, &a[2], &b[2]);
                add(&mut other, &a[3], &b[3]);
            }
            add(&mut sum, &newest_a, &self.b[LAST]);
            add(&mut other, &self.a[0], &newest_b);
        } else {
            self.a.fill([0.0; BATCH]);
            add(&mut sum, &newest_a, &newest_b);
        }
        (self.a[n], self.b[LAST - n]) = (newest_a, newest_b);
        for (out, (sum, other)) in x[self.out..][..BATCH].iter_mut().zip(sum.iter().zip(&other)) {
            *out = sum + other;
        }
    }

    /// [`order`](Products::order) for a batch of one product.
    #[inline(always)]
    fn alone<const FIRST: bool>(&mut self, n: usize, x: &mut [f64]) {
        let [newest_a, newest_b] = self.factors[0].map(|column| x[column as usize]);
        let [a, b] = [&mut self.a, &mut self.b].map(|of| of.as_flattened_mut());
        if FIRST {
            a.fill(0.0);
            (a[0], b[LAST]) = (newest_a, newest_b);
            x[self.out] = newest_a * newest_b;
            return;
        }
        // The newest coefficients come last, so that the other terms need not wait for them. The terms after
        // order n - 1 are 0.
        let (mut sums, count) = ([0.0; EIGHT], (n + 6) / EIGHT);
        let of_a = a[1..][..EIGHT * count].as_chunks::<EIGHT>().0;
        let of_b = b[LAST + 1 - n..][..EIGHT * count].as_chunks::<EIGHT>().0;
        for (a, b) in of_a.iter().zip(of_b) {
            for l in 0..EIGHT {
                sums[l] += a[l] * b[l];
            }
        }
        let [c, d, e, f, g, h, i, j] = sums;
        let inner = ((c + g) + (e + i)) + ((d + h) + (f + j));
        x[self.out] = inner + (newest_a * b[LAST] + a[0] * newest_b);
        (a[n], b[LAST - n]) = (newest_a, newest_b);
    }

    /// Sets the results that depend on roots and powers to 0.
    pub(super) fn freeze(&self, x: &mut [f64]) {
        for (out, of_power) in x[self.out..].iter_mut().zip(self.of_power) {
            *out = if of_power { 0.0 } else { *out };
        }
    }
}
