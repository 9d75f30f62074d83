//! Values and bounds of the polynomials of a motion.

use crate::ode::taylor::expansion::coefficients::{Coefficients, ORDERS};
use crate::ode::taylor::expansion::rows::{EIGHT, Eight};

/// n (n - 1).
pub(crate) const SECOND: [f64; ORDERS] = {
    let (mut second, mut n) = ([0.0; ORDERS], 0);
    while n < ORDERS {
        second[n] = (n * n - n) as f64;
        n += 1;
    }
    second
};

/// Σ_(n>=1) |d_n| hⁿ of all distances.
pub(super) struct Ranges<'v> {
    pub(super) c: &'v Coefficients,
    pub(super) h: f64,
    pub(super) ranges: &'v mut [Eight],
}

impl pulp::WithSimd for Ranges<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Ranges { c, h, ranges } = self;
        let (first, square) = (c.plan.distances, h * h);
        for (k, range) in ranges.iter_mut().enumerate() {
            // Even and odd orders apart: sums that do not wait for one another.
            let mut sums = [[0.0; EIGHT]; 2];
            for n in (1..=c.degree).rev() {
                add_order(&mut sums[n % 2], square, &c.x[n * c.plan.width + first + k].map(f64::abs));
            }
            let [even, odd] = sums;
            for l in 0..EIGHT {
                range[l] = h * (even[l] * h + odd[l]);
            }
        }
    }
}

/// A polynomial p at the end s of each eighth of a step, and Σ n (n - 1) |c_n| sⁿ there, which is the largest
/// |p''| s² in [0, s] at most.
pub(super) struct Samples {
    at_start: f64,
    pub(super) values: Eight,
    bends: Eight,
}

impl Samples {
    /// A time in [0, h] up to which the polynomial, times `sign`, is above `least` for certain.
    pub(super) fn above_until(&self, sign: f64, least: f64, h: f64) -> f64 {
        let mut before = sign * self.at_start;
        for l in 0..EIGHT {
            let (value, end) = (sign * self.values[l], (l + 1) as f64);
            // Between two samples at the distance w a function lies above the smaller one less w²/8 max |p''|.
            let is_above = before.min(value) - least > self.bends[l] / (8.0 * end * end);
            if !is_above {
                return h * (l as f64 / EIGHT as f64);
            }
            before = value;
        }
        h
    }
}

/// Samples of a distance d; with SHIFT 1 those of (d(s) - d(0))/s.
pub(super) struct Sampling<'v, const SHIFT: usize> {
    pub(super) c: &'v Coefficients,
    pub(super) column: usize,
    pub(super) h: f64,
}

impl<const SHIFT: usize> pulp::WithSimd for Sampling<'_, SHIFT> {
    type Output = Samples;
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Samples {
        let Sampling { c, column, h } = self;
        let (mut times, mut squares) = ([0.0; EIGHT], [0.0; EIGHT]);
        for l in 0..EIGHT {
            times[l] = h * ((l + 1) as f64 / EIGHT as f64);
            squares[l] = times[l] * times[l];
        }
        let stride = EIGHT * c.plan.width;
        let numbers = &c.x.as_flattened()[SHIFT * stride + EIGHT * c.plan.distances + column..];
        // Even and odd orders apart: sums that do not wait for one another.
        let (mut values, mut bends) = ([[0.0; EIGHT]; 2], [[0.0; EIGHT]; 2]);
        for n in (0..=c.degree - SHIFT).rev() {
            let (d, odd) = (numbers[n * stride], n % 2);
            let [value, bend] = [&mut values[odd], &mut bends[odd]];
            for l in 0..EIGHT {
                value[l] = value[l] * squares[l] + d;
                bend[l] = bend[l] * squares[l] + SECOND[n] * d.abs();
            }
        }
        let (mut value, mut bend) = ([0.0; EIGHT], [0.0; EIGHT]);
        for l in 0..EIGHT {
            value[l] = values[0][l] + times[l] * values[1][l];
            bend[l] = bends[0][l] + times[l] * bends[1][l];
        }
        Samples { at_start: numbers[0], values: value, bends: bend }
    }
}

/// Σ c_n sⁿ of coordinates and velocities.
pub(super) struct Values<'v> {
    pub(super) c: &'v Coefficients,
    pub(super) s: f64,
    pub(super) y: &'v mut [f64],
}

impl pulp::WithSimd for Values<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Values { c, s, y } = self;
        let (width, half, square) = (c.plan.width, c.plan.half, s * s);
        let (q, v) = y.split_at_mut(c.plan.dof);
        let outs = q.chunks_mut(EIGHT).zip(0..).chain(v.chunks_mut(EIGHT).zip(half..));
        for (out, k) in outs {
            // Even and odd orders apart: two sums that do not wait for one another.
            let (mut even, mut odd) = ([0.0; EIGHT], [0.0; EIGHT]);
            let mut n = c.degree + 1;
            if n % 2 == 1 {
                n -= 1;
                even = c.x[n * width + k];
            }
            while n > 0 {
                add_order(&mut odd, square, &c.x[(n - 1) * width + k]);
                add_order(&mut even, square, &c.x[(n - 2) * width + k]);
                n -= 2;
            }
            let values: Eight = std::array::from_fn(|l| even[l] + s * odd[l]);
            out.copy_from_slice(&values[..out.len()]);
        }
    }
}

/// sum <- sum factor + c.
#[inline(always)]
fn add_order(sum: &mut Eight, factor: f64, c: &Eight) {
    for l in 0..EIGHT {
        sum[l] = sum[l] * factor + c[l];
    }
}
