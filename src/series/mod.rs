//! Truncated Taylor series: the numbers with which drives are expanded over time.

mod arithmetic;
mod functions;

use crate::scalar::Scalar;
use crate::steepness::{Hidden, JETS};
use std::fmt;

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
    hidden: Hidden,
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
        let mut series = PowerSeries { len: 2, full, ..PowerSeries::constant(value) };
        (series.hidden.degree, series.hidden.noise) = (1, f64::EPSILON * series.value().abs());
        series.c[1] = rate;
        series
    }
    /// A series of one coefficient.
    #[inline]
    pub(crate) fn constant(value: C) -> Self {
        let mut c = [C::from(0.0); CAPACITY];
        c[0] = value;
        PowerSeries { c, len: 1, full: 1, until: f64::INFINITY, hidden: Hidden::default(), refusal: None }
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
        series.whole()
    }

    /// A series of zeros with `len` coefficients and the limits of this one.
    #[inline]
    fn like(&self, len: usize) -> Self {
        PowerSeries { c: [C::from(0.0); CAPACITY], len, ..*self }
    }
    /// A series of zeros with `len` coefficients and the limits of both.
    #[inline]
    fn of_both(&self, o: &Self, len: usize, hidden: Hidden) -> Self {
        PowerSeries {
            c: [C::from(0.0); CAPACITY],
            len,
            full: self.full.max(o.full),
            until: self.until.min(o.until),
            hidden,
            refusal: self.refusal.or(o.refusal),
        }
    }

    /// The value at the instant, if it is a plain number; otherwise 0.
    #[inline]
    fn value(&self) -> f64 {
        self.c[0].plain().unwrap_or(0.0)
    }
    /// The last two coefficients that a function of this series gets, as far as they are plain numbers.
    #[inline]
    fn last(&self) -> [f64; 2] {
        let at = |back: usize| self.full.checked_sub(back).and_then(|n| self.c[n].plain()).unwrap_or(0.0);
        [at(1), at(2)]
    }
    /// This series as one term.
    #[inline]
    fn whole(mut self) -> Self {
        (self.hidden.waves, self.hidden.last) = (self.hidden.waves.min(1), self.last().map(f64::abs));
        self
    }

    fn jets(&self) -> Option<[f64; JETS]> {
        let mut jets = [0.0; JETS];
        for (jet, c) in jets.iter_mut().zip(&self.c) {
            *jet = c.plain()?;
        }
        Some(jets)
    }
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
        self.hidden.steepness
    }
    /// What rounding changes of its value, about.
    pub(crate) fn noise(&self) -> f64 {
        self.hidden.noise
    }
    /// Sets the largest steepness of its functions `[1/s]`, and what rounding changes of its value.
    pub(crate) fn set_hidden(&mut self, steepness: f64, noise: f64) {
        (self.hidden.steepness, self.hidden.noise) = (steepness, noise);
    }
    /// The same series as the sum of a number of waves with a fastest rate and with sizes of its last two
    /// coefficients, and with the noise of their value.
    pub(crate) fn as_waves(mut self, waves: usize, rate: f64, last: Option<[f64; 2]>, noise: f64) -> Self {
        let last = last.unwrap_or(self.hidden.last);
        self.hidden = Hidden { waves, rate, last, noise, ..self.hidden }.with_last(self.last(), self.full);
        self
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
        (self.len, self.full) = (1, 1);
        (self.until, self.hidden, self.refusal) = (f64::INFINITY, Hidden::default(), None);
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
        (self.len, self.full) = (len, len);
        let hidden = Hidden { degree: 1, ..Hidden::default() };
        (self.until, self.hidden, self.refusal) = (f64::INFINITY, hidden, None);
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
