//! Truncated Taylor series: the numbers with which drives are expanded over time.

use crate::scalar::{Scalar, is_product};
use crate::steepness::{HIGH_DEGREE, JETS, logarithm, steepness, steepness_of_product};
use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

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
pub type Series = PowerSeries<f64>;

/// A truncated power series over any number type: [`Series`] over `f64`, enclosures over intervals.
///
/// ```
/// use gear_dynamics::{certify::Interval, model::{PowerSeries, Scalar}};
/// let t = PowerSeries::variable(Interval::from(0.0), Interval::from(1.0), 4);
/// assert!(t.exp().coefficients()[2].contains(0.5)); // 1 + t + t²/2 + ...
/// ```
#[derive(Clone, Copy)]
pub struct PowerSeries<C> {
    c: [C; CAPACITY],
    /// Number of coefficients; all further ones are 0.
    len: usize,
    /// Number of coefficients that a function of this series gets; 1 for a constant.
    full: usize,
    /// The time after the instant up to which the series represents its function.
    until: f64,
    /// The largest [`steepness`] of the functions in it `[1/s]`.
    steepness: f64,
    /// Upper bound of the number of varying factors that are multiplied in it.
    degree: usize,
    refusal: Option<&'static str>,
}

/// Maximum number of coefficients.
const CAPACITY: usize = 32;

impl<C: Scalar> PowerSeries<C> {
    /// Maximum number of coefficients.
    pub const CAPACITY: usize = CAPACITY;

    /// c_0 + c_1 t, from its value and its rate. Functions of it have `coefficients` coefficients, at most
    /// [`CAPACITY`](PowerSeries::CAPACITY) and at least 2.
    pub fn variable(value: C, rate: C, coefficients: usize) -> Self {
        let full = coefficients.clamp(2, CAPACITY);
        let mut series = PowerSeries { len: 2, full, degree: 1, ..PowerSeries::constant(value) };
        series.c[1] = rate;
        series
    }
    /// A series of one coefficient.
    #[inline]
    pub(crate) fn constant(value: C) -> Self {
        let mut c = [C::from(0.0); CAPACITY];
        c[0] = value;
        PowerSeries { c, len: 1, full: 1, until: f64::INFINITY, steepness: 0.0, degree: 0, refusal: None }
    }

    /// A series that stands for a function without one; `reason` says which function.
    pub fn refused(reason: &'static str) -> Self {
        PowerSeries { refusal: Some(reason), ..PowerSeries::constant(f64::NAN.into()) }
    }
    /// The reason why there is no series; `None` if there is one.
    pub fn refusal(&self) -> Option<&'static str> {
        self.refusal
    }

    /// The coefficients c_0, c_1, ...; all further ones are 0.
    #[inline]
    pub fn coefficients(&self) -> &[C] {
        &self.c[..self.len]
    }
    /// The value at the time `t` after the instant.
    pub fn at(&self, t: C) -> C {
        self.coefficients().iter().rev().fold(C::from(0.0), |sum, c| sum * t + *c)
    }
    /// The series with the coefficients that `next` returns one after the other.
    pub(crate) fn from_coefficients(of: &Self, mut next: impl FnMut(usize) -> C) -> Self {
        let mut series = of.like(of.full);
        for n in 0..of.full {
            series.c[n] = next(n);
        }
        series
    }

    /// A series of zeros with `len` coefficients and the limits of this one.
    #[inline]
    fn like(&self, len: usize) -> Self {
        PowerSeries { c: [C::from(0.0); CAPACITY], len, ..*self }
    }
    /// A series of zeros with `len` coefficients and the limits of both.
    #[inline]
    fn of_both(&self, o: &Self, len: usize) -> Self {
        PowerSeries {
            c: [C::from(0.0); CAPACITY],
            len,
            full: self.full.max(o.full),
            until: self.until.min(o.until),
            steepness: self.steepness.max(o.steepness),
            degree: self.degree.max(o.degree),
            refusal: self.refusal.or(o.refusal),
        }
    }

    /// The constant f(c_0), or the series whose coefficient n >= 1 is `next(n, this, result)`.
    #[inline]
    fn function(self, f: C, next: impl Fn(usize, &[C], &[C]) -> C) -> Self {
        let len = if self.len == 1 { 1 } else { self.full };
        let mut out = self.like(len);
        out.c[0] = f;
        for n in 1..len {
            out.c[n] = next(n, &self.c, &out.c);
        }
        out
    }

    /// f(c_0) for a constant. Any other series is refused for this reason.
    fn constant_or(self, reason: &'static str, f: impl Fn(C) -> C) -> Self {
        if self.len > 1 { Self::refused(reason) } else { self.function(f(self.c[0]), |_, _, _| C::from(0.0)) }
    }
    /// This result of a function, with the steepness of the function: that of `factor` times its argument,
    /// or of `factor` times the logarithm of it. Plain numbers alone have one.
    fn steep_in(mut self, argument: &Self, factor: f64, of_logarithm: bool) -> Self {
        if argument.len > 1
            && let Some(jets) = argument.jets()
        {
            let exponent = if of_logarithm { logarithm(jets) } else { jets };
            self.steepness = self.steepness.max(steepness(exponent.map(|w| factor * w)));
        }
        self
    }
    fn jets(&self) -> Option<[f64; JETS]> {
        let mut jets = [0.0; JETS];
        for (jet, c) in jets.iter_mut().zip(&self.c) {
            *jet = c.plain()?;
        }
        Some(jets)
    }
    /// The series of a power whose value is `first`: n a_0 c_n = Σ_j (j (p + 1) - n) a_j c_(n-j).
    fn power(self, first: C, p: f64) -> Self {
        self.function(first, |n, a, c| {
            // In numbers C, so that an interval contains the rounding of the weights.
            let weight = |j: usize| (C::from(p) + C::from(1.0)) * j as f64 - C::from(n as f64);
            let terms = (1..=n).map(|j| a[j] * weight(j) * c[n - j]);
            sum(terms) / (a[0] * n as f64)
        })
        .steep_in(&self, p, true)
    }
}

/// The sum of terms, one after the other.
#[inline]
fn sum<C: Scalar>(terms: impl Iterator<Item = C>) -> C {
    terms.fold(C::from(-0.0), |sum, term| sum + term)
}

impl Series {
    /// All coefficients up to the maximum number.
    #[inline(always)]
    pub(crate) fn padded(&self) -> &[f64; CAPACITY] {
        &self.c
    }
    /// The value at the instant.
    #[inline(always)]
    pub(crate) fn first(&self) -> f64 {
        self.c[0]
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
    /// The largest steepness of its functions. See [`steepness`].
    pub(crate) fn steepness(&self) -> f64 {
        self.steepness
    }
    /// Sets the largest steepness of its functions `[1/s]`.
    pub(crate) fn set_steepness(&mut self, steepness: f64) {
        self.steepness = steepness;
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
        (self.len, self.full, self.degree) = (1, 1, 0);
        (self.until, self.steepness, self.refusal) = (f64::INFINITY, 0.0, None);
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
        (self.len, self.full, self.degree) = (len, len, 1);
        (self.until, self.steepness, self.refusal) = (f64::INFINITY, 0.0, None);
    }
}

/// Coefficients that are computed side by side, and the number of such blocks.
pub(crate) const EIGHT: usize = 8;
pub(crate) const BLOCKS: usize = Series::CAPACITY / EIGHT;

impl<C: Scalar> fmt::Debug for PowerSeries<C> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.refusal {
            Some(reason) => write!(f, "no series: {reason}"),
            None => f.debug_tuple("Series").field(&self.coefficients()).finish(),
        }
    }
}

impl<C: Scalar> From<f64> for PowerSeries<C> {
    #[inline]
    fn from(value: f64) -> Self {
        PowerSeries::constant(value.into())
    }
}

impl<C: Scalar> Add for PowerSeries<C> {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        let mut sum = self.of_both(&o, self.len.max(o.len));
        sum.c.iter_mut().zip(self.c.iter().zip(&o.c)).for_each(|(sum, (a, b))| *sum = *a + *b);
        sum
    }
}

impl<C: Scalar> Sub for PowerSeries<C> {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl<C: Scalar> Neg for PowerSeries<C> {
    type Output = Self;
    #[inline]
    fn neg(mut self) -> Self {
        self.c[..self.len].iter_mut().for_each(|c| *c = -*c);
        self
    }
}

impl<C: Scalar> Mul<f64> for PowerSeries<C> {
    type Output = Self;
    #[inline]
    fn mul(mut self, o: f64) -> Self {
        self.c[..self.len].iter_mut().for_each(|c| *c = *c * o);
        self
    }
}

impl<C: Scalar> Mul for PowerSeries<C> {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        let full = self.full.max(o.full);
        let mut product = self.of_both(&o, full.min(self.len + o.len - 1));
        let (short, long) = if self.len < o.len { (&self, &o) } else { (&o, &self) };
        for (j, a) in short.coefficients().iter().enumerate() {
            let sums = &mut product.c[j..full];
            sums.iter_mut().zip(&long.c[..long.len]).for_each(|(sum, b)| *sum = *sum + *a * *b);
        }
        product.degree = self.degree.saturating_add(o.degree);
        if product.degree > HIGH_DEGREE
            && let Some(jets) = product.jets()
        {
            product.steepness = product.steepness.max(steepness_of_product(jets));
        }
        product
    }
}

impl<C: Scalar> Div for PowerSeries<C> {
    type Output = Self;
    #[inline]
    fn div(self, o: Self) -> Self {
        if o.len == 1 {
            let mut quotient = self.of_both(&o, self.len);
            quotient.c.iter_mut().zip(&self.c).for_each(|(q, a)| *q = *a / o.c[0]);
            return quotient;
        }
        let full = self.full.max(o.full);
        // What remains of the dividend after each coefficient becomes the next coefficient.
        let mut rest = self.of_both(&o, full);
        rest.c = self.c;
        for n in 0..full {
            let (done, open) = rest.c[n..full].split_at_mut(1);
            done[0] = done[0] / o.c[0];
            open.iter_mut().zip(&o.c[1..]).for_each(|(rest, b)| *rest = *rest - done[0] * *b);
        }
        rest.steep_in(&o, 1.0, true)
    }
}

impl<C: Scalar> Scalar for PowerSeries<C> {
    fn sqrt(self) -> Self {
        self.function(self.c[0].sqrt(), |n, a, s| {
            (a[n] - sum((1..n).map(|j| s[j] * s[n - j]))) / (s[0] * 2.0)
        })
        .steep_in(&self, 0.5, true)
    }
    fn abs(self) -> Self {
        self.constant_or("the absolute value of something that varies", C::abs)
    }
    fn min(self, o: Self) -> Self {
        (self + o).constant_or("the smaller of two numbers that vary", |_| self.c[0].min(o.c[0]))
    }
    fn max(self, o: Self) -> Self {
        (self + o).constant_or("the larger of two numbers that vary", |_| self.c[0].max(o.c[0]))
    }
    fn step(self) -> Self {
        self.constant_or("the step of something that varies", C::step)
    }
    fn powf(self, p: f64) -> Self {
        if is_product(p) {
            let power = (0..p.abs() as usize).fold(Self::from(1.0), |power, _| power * self);
            return if p < 0.0 { Self::from(1.0) / power } else { power };
        }
        self.power(self.c[0].powf(p), p)
    }
    fn abs_powf(self, p: f64) -> Self {
        match self.len {
            1 => self.abs().powf(p),
            _ if p % 2.0 == 1.0 => Self::refused("an odd power of an absolute value that varies"),
            _ if is_product(p) => self.powf(p),
            _ => self.power(self.c[0].abs().powf(p), p),
        }
    }
    fn exp(self) -> Self {
        self.function(self.c[0].exp(), |n, a, e| {
            sum((1..=n).map(|j| a[j] * j as f64 * e[n - j])) / C::from(n as f64)
        })
        .steep_in(&self, 1.0, false)
    }
    fn ln(self) -> Self {
        self.function(self.c[0].ln(), |n, a, l| {
            let sum = sum((1..n).map(|j| l[j] * j as f64 * a[n - j]));
            (a[n] - sum / C::from(n as f64)) / a[0]
        })
        .steep_in(&self, 1.0, true)
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
        (s.c[0], c.c[0]) = self.c[0].sin_cos();
        for n in 1..len {
            let [mut ds, mut dc] = [C::from(0.0); 2];
            for j in 1..=n.min(self.len - 1) {
                let a = self.c[j] * j as f64;
                ds = ds + a * c.c[n - j];
                dc = dc - a * s.c[n - j];
            }
            (s.c[n], c.c[n]) = (ds / C::from(n as f64), dc / C::from(n as f64));
        }
        (s, c)
    }
}
