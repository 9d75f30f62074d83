//! Truncated Taylor series: the numbers with which drives are expanded over time.

use crate::scalar::{Scalar, is_product};
use std::fmt;
use std::ops::Add;
use std::ops::Div;
use std::ops::Mul;
use std::ops::Neg;
use std::ops::Sub;

/// A truncated Taylor series c_0 + c_1 t + c_2 t² + ... over the time t after an instant.
///
/// [`Taylor`](crate::Taylor) computes the waves of a [`Shape`](crate::Shape) with it. Sums, products,
/// quotients, roots, powers, exponentials, logarithms, sines and cosines of series are exact up to their last
/// coefficient. |x|, min, max and step have no series at a kink: of a series that varies they give a
/// [refused](Series::refusal) one.
///
/// ```
/// use gear_dynamics::model::{Scalar, Series};
/// let t = Series::variable(0.5, 2.0, 4); // 0.5 + 2 t, four coefficients
/// assert_eq!((t * t).coefficients(), [0.25, 2.0, 4.0]);
/// let wave = t.sin();
/// assert!((wave.at(0.25) - 1f64.sin()).abs() < 2e-3);
/// assert_eq!(t.abs().refusal(), Some("the absolute value of something that varies"));
/// ```
#[derive(Clone, Copy)]
pub struct Series {
    c: [f64; Series::CAPACITY],
    /// Number of coefficients; all further ones are 0.
    len: usize,
    /// Number of coefficients that a function of this series gets; 1 for a constant.
    full: usize,
    /// The time after the instant up to which the series represents its function.
    until: f64,
    refusal: Option<&'static str>,
}

impl Series {
    /// Maximum number of coefficients.
    pub const CAPACITY: usize = 32;

    /// c_0 + c_1 t, from its value and its rate. Functions of it have `coefficients` coefficients, at most
    /// [`CAPACITY`](Series::CAPACITY) and at least 2.
    pub fn variable(value: f64, rate: f64, coefficients: usize) -> Self {
        let mut series = Series { len: 2, full: coefficients.clamp(2, Self::CAPACITY), ..value.into() };
        series.c[1] = rate;
        series
    }

    /// A series that stands for a function without one; `reason` says which function.
    pub fn refused(reason: &'static str) -> Self {
        Series { refusal: Some(reason), ..f64::NAN.into() }
    }
    /// The reason why there is no series; `None` if there is one.
    pub fn refusal(&self) -> Option<&'static str> {
        self.refusal
    }

    /// The coefficients c_0, c_1, ...; all further ones are 0.
    #[inline]
    pub fn coefficients(&self) -> &[f64] {
        &self.c[..self.len]
    }
    /// All coefficients up to the maximum number.
    #[inline(always)]
    pub(crate) fn padded(&self) -> &[f64; Self::CAPACITY] {
        &self.c
    }
    /// The value at the instant.
    #[inline(always)]
    pub(crate) fn first(&self) -> f64 {
        self.c[0]
    }
    /// The value at the time `t` after the instant.
    pub fn at(&self, t: f64) -> f64 {
        self.coefficients().iter().rev().fold(0.0, |sum, c| sum * t + c)
    }
    /// The same series, valid up to the time `until` after the instant.
    pub(crate) fn valid_until(self, until: f64) -> Self {
        Series { until: self.until.min(until), ..self }
    }
    /// The time after the instant up to which the series represents its function; infinite if there is no
    /// limit.
    pub fn until(&self) -> f64 {
        self.until
    }
    /// The same polynomial over the time after an instant that is later by `by`.
    pub(crate) fn later(mut self, by: f64) -> Self {
        for first in 0..self.len.saturating_sub(1) {
            for n in (first..self.len - 1).rev() {
                self.c[n] += by * self.c[n + 1];
            }
        }
        self
    }
    /// The same series with another value at the instant.
    pub(crate) fn moved_to(mut self, value: f64) -> Self {
        self.c[0] = value;
        self
    }
    /// Makes the series a constant. It writes only the coefficients that are not 0.
    pub(crate) fn set_constant(&mut self, value: f64) {
        self.c[1..self.len].fill(0.0);
        self.c[0] = value;
        (self.len, self.full, self.until, self.refusal) = (1, 1, f64::INFINITY, None);
    }
    /// Sets the first `len` coefficients; all further ones are 0.
    #[inline]
    pub(crate) fn set<const USED: usize>(&mut self, coefficients: &[[f64; EIGHT]; USED], len: usize) {
        for (k, block) in self.c.as_chunks_mut::<EIGHT>().0.iter_mut().enumerate() {
            *block = coefficients.get(k).copied().unwrap_or([0.0; EIGHT]);
        }
        for c in &mut self.c[len..(USED * EIGHT).max(len)] {
            *c = 0.0;
        }
        (self.len, self.full, self.until, self.refusal) = (len, len, f64::INFINITY, None);
    }
    /// The series with the coefficients that `next` returns one after the other.
    pub(crate) fn from_coefficients(of: &Series, mut next: impl FnMut(usize) -> f64) -> Self {
        let mut series = of.like(of.full);
        for n in 0..of.full {
            series.c[n] = next(n);
        }
        series
    }

    /// A series of zeros with `len` coefficients and the limits of this one.
    #[inline]
    fn like(&self, len: usize) -> Self {
        Series { c: [0.0; Self::CAPACITY], len, ..*self }
    }
    /// A series of zeros with `len` coefficients and the limits of both.
    #[inline]
    fn of_both(&self, o: &Series, len: usize) -> Self {
        Series {
            c: [0.0; Self::CAPACITY],
            len,
            full: self.full.max(o.full),
            until: self.until.min(o.until),
            refusal: self.refusal.or(o.refusal),
        }
    }

    /// The constant f(c_0), or the series whose coefficient n >= 1 is `next(n, this, result)`.
    #[inline]
    fn function(self, f: f64, next: impl Fn(usize, &[f64], &[f64]) -> f64) -> Self {
        let len = if self.len == 1 { 1 } else { self.full };
        let mut out = self.like(len);
        out.c[0] = f;
        for n in 1..len {
            out.c[n] = next(n, &self.c, &out.c);
        }
        out
    }

    /// f(c_0) for a constant. Any other series is refused for this reason.
    fn constant_or(self, reason: &'static str, f: impl Fn(f64) -> f64) -> Self {
        if self.len > 1 { Series::refused(reason) } else { self.function(f(self.c[0]), |_, _, _| 0.0) }
    }
}

/// Coefficients that are computed side by side, and the number of such blocks.
pub(crate) const EIGHT: usize = 8;
pub(crate) const BLOCKS: usize = Series::CAPACITY / EIGHT;

/// The weights n^k/k! of the Taylor coefficients k of a wave of order n over its angle, with the signs
/// + + - - in turn.
#[derive(Clone, PartialEq)]
pub(crate) struct WaveWeights([[f64; EIGHT]; BLOCKS]);

impl WaveWeights {
    pub(crate) fn new(n: f64) -> Self {
        let (mut weights, mut weight) = ([[0.0; EIGHT]; BLOCKS], 1.0);
        for (k, out) in weights.as_flattened_mut().iter_mut().enumerate() {
            *out = if k % 4 < 2 { weight } else { -weight };
            weight *= n / (k + 1) as f64;
        }
        WaveWeights(weights)
    }
    /// The weights of the coefficients k and k + 1, k even.
    #[inline(always)]
    pub(crate) fn pair(&self, k: usize) -> [f64; 2] {
        self.0.as_flattened().as_chunks().0[k / 2]
    }

    /// Adds the coefficients of the wave with this value and this slope over nφ.
    #[inline(always)]
    pub(crate) fn add<const USED: usize>(&self, [value, slope]: [f64; 2], sums: &mut [[f64; EIGHT]; USED]) {
        let turns = [value, slope, value, slope, value, slope, value, slope];
        for (sum, weights) in sums.iter_mut().zip(&self.0) {
            for l in 0..EIGHT {
                sum[l] += turns[l] * weights[l];
            }
        }
    }
}

impl fmt::Debug for WaveWeights {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("..")
    }
}

impl fmt::Debug for Series {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.refusal {
            Some(reason) => write!(f, "no series: {reason}"),
            None => f.debug_tuple("Series").field(&self.coefficients()).finish(),
        }
    }
}

impl From<f64> for Series {
    #[inline]
    fn from(value: f64) -> Self {
        let mut c = [0.0; Self::CAPACITY];
        c[0] = value;
        Series { c, len: 1, full: 1, until: f64::INFINITY, refusal: None }
    }
}

impl Add for Series {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        let mut sum = self.of_both(&o, self.len.max(o.len));
        sum.c.iter_mut().zip(self.c.iter().zip(&o.c)).for_each(|(sum, (a, b))| *sum = a + b);
        sum
    }
}

impl Sub for Series {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl Neg for Series {
    type Output = Self;
    #[inline]
    fn neg(mut self) -> Self {
        self.c[..self.len].iter_mut().for_each(|c| *c = -*c);
        self
    }
}

impl Mul<f64> for Series {
    type Output = Self;
    #[inline]
    fn mul(mut self, o: f64) -> Self {
        self.c[..self.len].iter_mut().for_each(|c| *c *= o);
        self
    }
}

impl Mul for Series {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        let full = self.full.max(o.full);
        let mut product = self.of_both(&o, full.min(self.len + o.len - 1));
        let (short, long) = if self.len < o.len { (&self, &o) } else { (&o, &self) };
        for (j, a) in short.coefficients().iter().enumerate() {
            let sums = &mut product.c[j..full];
            sums.iter_mut().zip(&long.c[..long.len]).for_each(|(sum, b)| *sum += a * b);
        }
        product
    }
}

impl Div for Series {
    type Output = Self;
    #[inline]
    fn div(self, o: Self) -> Self {
        if o.len == 1 {
            let mut quotient = self.of_both(&o, self.len);
            quotient.c.iter_mut().zip(&self.c).for_each(|(q, a)| *q = a / o.c[0]);
            return quotient;
        }
        let full = self.full.max(o.full);
        // What remains of the dividend after each coefficient becomes the next coefficient.
        let mut rest = self.of_both(&o, full);
        rest.c = self.c;
        for n in 0..full {
            let (done, open) = rest.c[n..full].split_at_mut(1);
            done[0] /= o.c[0];
            open.iter_mut().zip(&o.c[1..]).for_each(|(rest, b)| *rest -= done[0] * b);
        }
        rest
    }
}

impl Scalar for Series {
    fn sqrt(self) -> Self {
        self.function(self.c[0].sqrt(), |n, a, s| {
            let sum: f64 = (1..n).map(|j| s[j] * s[n - j]).sum();
            (a[n] - sum) / (2.0 * s[0])
        })
    }
    fn abs(self) -> Self {
        self.constant_or("the absolute value of something that varies", f64::abs)
    }
    fn min(self, o: Self) -> Self {
        if self.len.max(o.len) > 1 {
            return Series::refused("the smaller of two numbers that vary");
        }
        if self.c[0] < o.c[0] { self } else { o }
    }
    fn max(self, o: Self) -> Self {
        if self.len.max(o.len) > 1 {
            return Series::refused("the larger of two numbers that vary");
        }
        if self.c[0] > o.c[0] { self } else { o }
    }
    fn step(self) -> Self {
        self.constant_or("the step of something that varies", Scalar::step)
    }
    fn powf(self, p: f64) -> Self {
        if is_product(p) {
            let power = (0..p.abs() as usize).fold(Series::from(1.0), |power, _| power * self);
            return if p < 0.0 { Series::from(1.0) / power } else { power };
        }
        self.function(libm::pow(self.c[0], p), |n, a, c| {
            let sum: f64 = (1..=n).map(|j| (j as f64 * (p + 1.0) - n as f64) * a[j] * c[n - j]).sum();
            sum / (n as f64 * a[0])
        })
    }
    fn abs_powf(self, p: f64) -> Self {
        if self.len > 1 && p % 2.0 == 1.0 {
            return Series::refused("an odd power of an absolute value that varies");
        }
        if self.c[0] < 0.0 { (-self).powf(p) } else { self.powf(p) }
    }
    fn exp(self) -> Self {
        self.function(libm::exp(self.c[0]), |n, a, e| {
            (1..=n).map(|j| j as f64 * a[j] * e[n - j]).sum::<f64>() / n as f64
        })
    }
    fn ln(self) -> Self {
        self.function(libm::log(self.c[0]), |n, a, l| {
            let sum: f64 = (1..n).map(|j| j as f64 * l[j] * a[n - j]).sum();
            (a[n] - sum / n as f64) / a[0]
        })
    }
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    fn cos(self) -> Self {
        self.sin_cos().1
    }
    fn sin_cos(self) -> (Self, Self) {
        let len = if self.len == 1 { 1 } else { self.full };
        let (mut s, mut c) = (self.like(len), self.like(len));
        (s.c[0], c.c[0]) = libm::sincos(self.c[0]);
        for n in 1..len {
            let (mut ds, mut dc) = (0.0, 0.0);
            for j in 1..=n.min(self.len - 1) {
                let a = j as f64 * self.c[j];
                ds += a * c.c[n - j];
                dc -= a * s.c[n - j];
            }
            (s.c[n], c.c[n]) = (ds / n as f64, dc / n as f64);
        }
        (s, c)
    }
}
