//! Values and bounds of the polynomials of a motion.

use crate::ode::taylor::expansion::coefficients::{Coefficients, ORDERS};
use crate::ode::taylor::expansion::rows::{EIGHT, Eight};
use pulp::Arch;

/// n (n - 1).
pub(crate) const SECOND: [f64; ORDERS] = {
    let (mut second, mut n) = ([0.0; ORDERS], 0);
    while n < ORDERS {
        second[n] = (n * n - n) as f64;
        n += 1;
    }
    second
};

impl Coefficients {
    /// Writes coordinates and velocities at the time `s` after the start of the step to `y`.
    pub(crate) fn at(&self, s: f64, y: &mut [f64]) {
        self.arch.dispatch(Values { c: self, s, y });
    }

    /// Σ_(n>=1) |d_n| hⁿ of every distance: how far it moves at most.
    pub(crate) fn ranges(&self, h: f64, ranges: &mut [Eight]) {
        self.arch.dispatch(Ranges { c: self, h, ranges });
    }

    /// Samples of a distance d over a step; for `SHIFT` 1, of (d(s) - d(0))/s.
    pub(crate) fn samples<const SHIFT: usize>(&self, column: usize, h: f64) -> Samples {
        let stride = EIGHT * self.plan.width;
        let numbers = &self.x.as_flattened()[SHIFT * stride + EIGHT * self.plan.distances + column..];
        Sampling { arch: self.arch, count: self.degree + 1 - SHIFT, h }.of(|n| numbers[n * stride])
    }
}

/// Σ_(n>=1) |d_n| hⁿ of all distances.
struct Ranges<'v> {
    pub(super) c: &'v Coefficients,
    pub(super) h: f64,
    pub(super) ranges: &'v mut [Eight],
}

impl pulp::WithSimd for Ranges<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Ranges { c, h, ranges } = self;
        let (width, first) = (c.plan.width, c.plan.distances);
        for (k, range) in ranges.iter_mut().enumerate() {
            let sum = polynomial::<true>(&c.x[width + first + k..], width, c.degree, h);
            for l in 0..EIGHT {
                range[l] = h * sum[l];
            }
        }
    }
}

/// A polynomial p at the end s of each eighth of a step, and Σ n (n - 1) |c_n| sⁿ there, which is the largest
/// |p''| s² in [0, s] at most.
pub(crate) struct Samples {
    at_start: f64,
    values: Eight,
    bends: Eight,
}

impl Samples {
    /// A time in [0, h] up to which the polynomial, times `sign`, is above `least` for certain.
    pub(crate) fn above_until(&self, sign: f64, least: f64, h: f64) -> f64 {
        let mut before = sign * self.at_start;
        for l in 0..EIGHT {
            let (value, end) = (sign * self.values[l], (l + 1) as f64);
            // Between two samples at the distance w a function lies above the smaller one less w²/8 max
            // |p''|.
            let is_above = before.min(value) - least > self.bends[l] / (8.0 * end * end);
            if !is_above {
                return h * (l as f64 / EIGHT as f64);
            }
            before = value;
        }
        h
    }

    /// For the samples of (d(s) - d(0))/s: a time in [0, h] up to which d, times `sign`, is above its value
    /// `start` for certain. The time is less than h if d is not above `least` at the end.
    pub(crate) fn risen_until(&self, start: f64, sign: f64, least: f64, h: f64) -> f64 {
        let until = self.above_until(sign, 0.0, h);
        let end = start + sign * (h * self.values[EIGHT - 1]);
        if end > least { until } else { until.min(0.5 * h) }
    }
}

/// Samples of a polynomial with `count` coefficients in a step of length `h`.
pub(crate) struct Sampling {
    pub(crate) arch: Arch,
    pub(crate) count: usize,
    pub(crate) h: f64,
}

impl Sampling {
    /// The samples of the polynomial with these coefficients.
    pub(crate) fn of(self, coefficient: impl Fn(usize) -> f64) -> Samples {
        let Sampling { arch, count, h } = self;
        arch.dispatch(Sampled { count, h, coefficient })
    }
}

struct Sampled<F> {
    count: usize,
    h: f64,
    coefficient: F,
}

impl<F: Fn(usize) -> f64> pulp::WithSimd for Sampled<F> {
    type Output = Samples;
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Samples {
        let Sampled { count, h, coefficient } = self;
        let (mut times, mut fourths) = ([0.0; EIGHT], [0.0; EIGHT]);
        for l in 0..EIGHT {
            times[l] = h * ((l + 1) as f64 / EIGHT as f64);
            fourths[l] = (times[l] * times[l]) * (times[l] * times[l]);
        }
        // Every fourth order apart: sums that do not wait for one another.
        let (mut values, mut bends) = ([[0.0; EIGHT]; 4], [[0.0; EIGHT]; 4]);
        let mut n = count - count % 4;
        for r in 0..3 {
            if n + r < count {
                let d = coefficient(n + r);
                (values[r], bends[r]) = ([d; EIGHT], [SECOND[n + r] * d.abs(); EIGHT]);
            }
        }
        while n > 0 {
            n -= 4;
            for r in 0..4 {
                let d = coefficient(n + r);
                let bend = SECOND[n + r] * d.abs();
                for l in 0..EIGHT {
                    values[r][l] = values[r][l] * fourths[l] + d;
                    bends[r][l] = bends[r][l] * fourths[l] + bend;
                }
            }
        }
        let (mut value, mut bend) = ([0.0; EIGHT], [0.0; EIGHT]);
        for l in 0..EIGHT {
            let (time, square) = (times[l], times[l] * times[l]);
            value[l] = values[0][l] + (time * values[1][l] + square * (values[2][l] + time * values[3][l]));
            bend[l] = bends[0][l] + (time * bends[1][l] + square * (bends[2][l] + time * bends[3][l]));
        }
        Samples { at_start: coefficient(0), values: value, bends: bend }
    }
}

/// Σ c_n sⁿ of coordinates and velocities.
struct Values<'v> {
    pub(super) c: &'v Coefficients,
    pub(super) s: f64,
    pub(super) y: &'v mut [f64],
}

impl pulp::WithSimd for Values<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Values { c, s, y } = self;
        let (width, half) = (c.plan.width, c.plan.half);
        let (q, v) = y.split_at_mut(c.plan.dof);
        let outs = q.chunks_mut(EIGHT).zip(0..).chain(v.chunks_mut(EIGHT).zip(half..));
        for (out, k) in outs {
            // The value at the start is added last: one rounding error of its size.
            let later = polynomial::<false>(&c.x[width + k..], width, c.degree, s);
            let values: Eight = std::array::from_fn(|l| c.x[k][l] + s * later[l]);
            out.copy_from_slice(&values[..out.len()]);
        }
    }
}

/// Σ_(n < count) c_n sⁿ, where c_n stands at n `stride`; with ABS Σ |c_n| sⁿ.
#[inline(always)]
fn polynomial<const ABS: bool>(c: &[Eight], stride: usize, count: usize, s: f64) -> Eight {
    // Every fourth order apart: four sums that do not wait for one another.
    let (square, mut sums) = (s * s, [[0.0; EIGHT]; 4]);
    let mut n = count - count % 4;
    for r in 0..3 {
        if n + r < count {
            add_order::<ABS>(&mut sums[r], 0.0, &c[(n + r) * stride]);
        }
    }
    while n > 0 {
        n -= 4;
        for r in 0..4 {
            add_order::<ABS>(&mut sums[r], square * square, &c[(n + r) * stride]);
        }
    }
    let mut sum = [0.0; EIGHT];
    for l in 0..EIGHT {
        sum[l] = (sums[0][l] + s * sums[1][l]) + square * (sums[2][l] + s * sums[3][l]);
    }
    sum
}

/// sum <- sum factor + c; with ABS sum factor + |c|.
#[inline(always)]
fn add_order<const ABS: bool>(sum: &mut Eight, factor: f64, c: &Eight) {
    for l in 0..EIGHT {
        sum[l] = sum[l] * factor + if ABS { c[l].abs() } else { c[l] };
    }
}
