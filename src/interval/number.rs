//! Intervals of real numbers, rounded outwards.

use std::fmt;
use std::ops::Add;
use std::ops::Div;
use std::ops::Mul;
use std::ops::Neg;
use std::ops::Sub;

/// A closed interval of real numbers that contains the exact result of every operation on it.
///
/// The ends of a result are the nearest `f64` moved by one number outwards
/// ([`next_down`](f64::next_down), [`next_up`](f64::next_up)), which is an enclosure in every rounding of the
/// processor to nearest. An operation without a bound (a division by an interval that contains 0, a root of a
/// negative number, an overflow) gives the whole line. As a [`Scalar`](crate::model::Scalar) an interval runs
/// through the algebra of any [`Shape`](crate::Shape).   Source: Moore, Kearfott & Cloud, Introduction to
/// Interval Analysis, Chs. 2, 3.
///
/// ```
/// use gear_dynamics::certify::Interval;
/// use gear_dynamics::model::Scalar;
/// let tenth = Interval::from(1.0) / Interval::from(10.0); // 1/10 is no f64
/// assert!(tenth.low() < 0.1 && 0.1 < tenth.high() && tenth.width() < 1e-16);
/// assert!((Interval::new(2.0, 3.0)? * Interval::new(-1.0, 2.0)?).contains(-3.0));
/// assert!(Interval::PI.sin().contains(0.0) && Interval::PI.sin().magnitude() < 1e-15);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "[f64; 2]", into = "[f64; 2]"))]
pub struct Interval {
    low: f64,
    high: f64,
}

impl Interval {
    /// All real numbers: the result of an operation without a bound.
    pub const LINE: Interval = Interval { low: f64::NEG_INFINITY, high: f64::INFINITY };
    /// The number π.
    pub const PI: Interval = Interval { low: std::f64::consts::PI, high: 3.141_592_653_589_793_6 };
    pub(crate) const ZERO: Interval = Interval { low: 0.0, high: 0.0 };
    pub(crate) const ONE: Interval = Interval { low: 1.0, high: 1.0 };

    /// The interval from `low` to `high`.
    ///
    /// # Errors
    /// An end that is NaN; a lower end above the upper one.
    pub fn new(low: f64, high: f64) -> Result<Self, crate::ParameterError> {
        match low <= high {
            true => Ok(Interval { low, high }),
            false => Err(crate::ParameterError::Wrong {
                name: "lower end of an interval".into(),
                value: low,
                must: format!("be at most {high:?}, its upper end"),
            }),
        }
    }
    /// All numbers within `radius` of `middle`, for example a value with its tolerance.
    ///
    /// # Errors
    /// A number that is not finite; a negative radius.
    pub fn around(middle: f64, radius: f64) -> Result<Self, crate::ParameterError> {
        crate::error::check::finite("middle of an interval", middle)?;
        crate::error::check::not_negative("radius of an interval", radius)?;
        Ok(Interval::from(middle) + Interval { low: -radius, high: radius })
    }
    /// Lower end.
    #[inline(always)]
    pub fn low(self) -> f64 {
        self.low
    }
    /// Upper end.
    #[inline(always)]
    pub fn high(self) -> f64 {
        self.high
    }
    /// A number in the middle.
    #[inline]
    pub fn middle(self) -> f64 {
        let middle = 0.5 * self.low + 0.5 * self.high;
        // The halves of subnormal numbers are rounded.
        match self {
            _ if middle < self.low => self.low,
            _ if middle > self.high => self.high,
            _ => middle,
        }
    }
    /// Upper bound of the width.
    #[inline]
    pub fn width(self) -> f64 {
        (self.high - self.low).next_up()
    }
    /// The largest |x| of its numbers x.
    #[inline]
    pub fn magnitude(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }
    /// Whether a number lies in the interval.
    pub fn contains(self, x: f64) -> bool {
        self.low <= x && x <= self.high
    }
    /// Whether all numbers of the interval lie in `other`.
    pub fn lies_in(self, other: Interval) -> bool {
        other.low <= self.low && self.high <= other.high
    }
    /// Whether all numbers lie between the ends of `other` and none on them.
    pub fn is_inside(self, other: Interval) -> bool {
        other.low < self.low && self.high < other.high
    }
    /// Whether both ends are finite.
    pub fn is_bounded(self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }
    /// Whether the interval contains 0.
    #[inline]
    pub(crate) fn has_zero(self) -> bool {
        self.low <= 0.0 && self.high >= 0.0
    }
    #[inline(always)]
    pub(crate) fn is_zero(self) -> bool {
        self.low == 0.0 && self.high == 0.0
    }
    /// The smallest interval that contains both.
    pub fn hull(self, other: Interval) -> Self {
        Interval { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
    /// The numbers in both; `None` if there are none.
    pub fn common(self, other: Interval) -> Option<Self> {
        let (low, high) = (self.low.max(other.low), self.high.min(other.high));
        (low <= high).then_some(Interval { low, high })
    }
    /// [-r, r] for a radius r >= 0.
    pub(crate) fn symmetric(radius: f64) -> Self {
        Interval { low: -radius, high: radius }
    }
    /// An interval whose ends are known to be ordered.
    #[inline(always)]
    pub(crate) const fn of_ends(low: f64, high: f64) -> Self {
        Interval { low, high }
    }
    /// The interval of rounded ends, moved outwards by one number; the whole line if an end is NaN.
    #[inline(always)]
    pub(crate) fn outwards(low: f64, high: f64) -> Self {
        let interval = Interval { low: low.next_down(), high: high.next_up() };
        if interval.low <= interval.high { interval } else { Interval::LINE }
    }
    /// x² without the dependence of a product.
    #[inline]
    pub(crate) fn square(self) -> Self {
        let Interval { low, high } = self;
        let least = if self.has_zero() { 0.0 } else { low.abs().min(high.abs()) };
        let most = self.magnitude();
        Interval { low: (least * least).next_down().max(0.0), high: (most * most).next_up() }
    }
}

impl fmt::Debug for Interval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{:?}, {:?}]", self.low, self.high)
    }
}
impl fmt::Display for Interval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{}, {}]", self.low, self.high)
    }
}

impl From<Interval> for [f64; 2] {
    fn from(x: Interval) -> Self {
        [x.low, x.high]
    }
}
impl TryFrom<[f64; 2]> for Interval {
    type Error = crate::ParameterError;
    fn try_from([low, high]: [f64; 2]) -> Result<Self, Self::Error> {
        Interval::new(low, high)
    }
}

impl From<f64> for Interval {
    /// The interval of one number; the whole line for NaN.
    #[inline(always)]
    fn from(x: f64) -> Self {
        if x.is_nan() { Interval::LINE } else { Interval { low: x, high: x } }
    }
}

impl Add for Interval {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        if self.is_zero() {
            return o;
        }
        if o.is_zero() {
            return self;
        }
        Interval::outwards(self.low + o.low, self.high + o.high)
    }
}
impl Neg for Interval {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Interval { low: -self.high, high: -self.low }
    }
}
impl Sub for Interval {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}

impl Mul for Interval {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        if self.is_zero() && o.is_bounded() || o.is_zero() && self.is_bounded() {
            return Interval::ZERO;
        }
        if o.low == o.high {
            let (a, b) = (self.low * o.low, self.high * o.low);
            return if a <= b { Interval::outwards(a, b) } else { Interval::outwards(b, a) };
        }
        let [a, b, c, d] = [self.low * o.low, self.low * o.high, self.high * o.low, self.high * o.high];
        // 0 times infinity is NaN, which `min` and `max` would pass over.
        if (a + b + c + d).is_nan() {
            return Interval::LINE;
        }
        Interval::outwards(a.min(b).min(c.min(d)), a.max(b).max(c.max(d)))
    }
}
impl Mul<f64> for Interval {
    type Output = Self;
    #[inline]
    fn mul(self, o: f64) -> Self {
        if o == 1.0 {
            return self;
        }
        self * Interval::from(o)
    }
}

impl Div for Interval {
    type Output = Self;
    #[inline]
    fn div(self, o: Self) -> Self {
        if o.has_zero() || !o.is_bounded() || !self.is_bounded() {
            return Interval::LINE;
        }
        if self.is_zero() {
            return self;
        }
        let [a, b, c, d] = [self.low / o.low, self.low / o.high, self.high / o.low, self.high / o.high];
        Interval::outwards(a.min(b).min(c.min(d)), a.max(b).max(c.max(d)))
    }
}
