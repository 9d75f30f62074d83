//! Numbers of twice the digits: a value and its slope as sums of two doubles.

use crate::scalar::Scalar;
use std::ops::Add;
use std::ops::Div;
use std::ops::Mul;
use std::ops::Neg;
use std::ops::Sub;

/// high + low with |low| <= ε |high|/2: some 31 digits.
///
/// Source: Dekker, Numerische Mathematik 18 (1971), 224-242. There is no fused multiply-add.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Doubled {
    pub(crate) high: f64,
    pub(crate) low: f64,
}

/// 2²⁷ + 1: halves the digits of a number.
const SPLIT: f64 = 134_217_729.0;

impl Doubled {
    pub(crate) const ZERO: Self = Doubled { high: 0.0, low: 0.0 };

    /// The sum of two doubles, without error.
    #[inline]
    fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let of_b = high - a;
        let low = (a - (high - of_b)) + (b - of_b);
        Doubled { high, low: if high.is_finite() { low } else { 0.0 } }
    }
    /// The product of two doubles, without error unless it underflows.
    #[inline]
    fn product(a: f64, b: f64) -> Self {
        let halves = |x: f64| {
            let shifted = SPLIT * x;
            let upper = shifted - (shifted - x);
            (upper, x - upper)
        };
        let (high, (a1, a2), (b1, b2)) = (a * b, halves(a), halves(b));
        let low = ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2;
        Doubled { high, low: if low.is_finite() { low } else { 0.0 } }
    }
    pub(crate) fn size(self) -> f64 {
        self.high.abs()
    }
    pub(crate) fn root(self) -> Self {
        let root = self.high.sqrt();
        if root == 0.0 || !root.is_finite() {
            return Doubled::from(root);
        }
        let left = self - Doubled::product(root, root);
        Doubled::sum(root, 0.5 * left.high / root)
    }
}

impl From<f64> for Doubled {
    fn from(high: f64) -> Self {
        Doubled { high, low: 0.0 }
    }
}
impl Add for Doubled {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        let (sum, rest) = (Doubled::sum(self.high, o.high), Doubled::sum(self.low, o.low));
        let sum = Doubled::sum(sum.high, sum.low + rest.high);
        Doubled::sum(sum.high, sum.low + rest.low)
    }
}
impl Sub for Doubled {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}
impl Neg for Doubled {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Doubled { high: -self.high, low: -self.low }
    }
}
impl Mul for Doubled {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        let product = Doubled::product(self.high, o.high);
        Doubled::sum(product.high, product.low + (self.high * o.low + self.low * o.high))
    }
}
impl Div for Doubled {
    type Output = Self;
    #[inline]
    fn div(self, o: Self) -> Self {
        let first = self.high / o.high;
        if !first.is_finite() {
            return Doubled::from(first);
        }
        let left = self - o * Doubled::from(first);
        let second = left.high / o.high;
        let left = left - o * Doubled::from(second);
        Doubled::sum(first, second) + Doubled::from(left.high / o.high)
    }
}

/// A value and its slope in one direction, both of twice the digits. Powers, exponentials, logarithms, sines
/// and cosines have the digits of doubles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DoubledDual {
    pub(crate) value: Doubled,
    pub(crate) slope: Doubled,
}

impl DoubledDual {
    /// g(x) from g and g' at the leading double of x, and g'' for the slope.
    fn chain(self, g: f64, [first, second]: [f64; 2]) -> Self {
        let low = Doubled::from(self.value.low);
        let along = |slope: f64| if slope.is_finite() { Doubled::from(slope) } else { Doubled::ZERO };
        let slope = along(first) + along(second) * low;
        DoubledDual { value: Doubled::from(g) + along(first) * low, slope: slope * self.slope }
    }
}

impl From<f64> for DoubledDual {
    fn from(value: f64) -> Self {
        DoubledDual { value: value.into(), slope: Doubled::ZERO }
    }
}
impl Add for DoubledDual {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        DoubledDual { value: self.value + o.value, slope: self.slope + o.slope }
    }
}
impl Sub for DoubledDual {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        DoubledDual { value: self.value - o.value, slope: self.slope - o.slope }
    }
}
impl Neg for DoubledDual {
    type Output = Self;
    fn neg(self) -> Self {
        DoubledDual { value: -self.value, slope: -self.slope }
    }
}
impl Mul for DoubledDual {
    type Output = Self;
    #[allow(clippy::suspicious_arithmetic_impl, reason = "the product rule")]
    fn mul(self, o: Self) -> Self {
        let slope = self.slope * o.value + self.value * o.slope;
        DoubledDual { value: self.value * o.value, slope }
    }
}
impl Mul<f64> for DoubledDual {
    type Output = Self;
    fn mul(self, o: f64) -> Self {
        let o = Doubled::from(o);
        DoubledDual { value: self.value * o, slope: self.slope * o }
    }
}
impl Div for DoubledDual {
    type Output = Self;
    #[allow(clippy::suspicious_arithmetic_impl, reason = "the quotient rule")]
    fn div(self, o: Self) -> Self {
        let value = self.value / o.value;
        DoubledDual { value, slope: (self.slope - value * o.slope) / o.value }
    }
}

impl Scalar for DoubledDual {
    fn sqrt(self) -> Self {
        let root = self.value.root();
        if root.high == 0.0 {
            return self.chain(0.0, [f64::INFINITY; 2]);
        }
        DoubledDual { value: root, slope: self.slope / (root + root) }
    }
    fn abs(self) -> Self {
        if self.value.high < 0.0 { -self } else { self }
    }
    fn min(self, o: Self) -> Self {
        if (self.value - o.value).high < 0.0 { self } else { o }
    }
    fn max(self, o: Self) -> Self {
        if (self.value - o.value).high > 0.0 { self } else { o }
    }
    fn step(self) -> Self {
        Scalar::step(self.value.high).into()
    }
    fn powf(self, p: f64) -> Self {
        let x = self.value.high;
        let slope = |factor: f64, p: f64| if factor == 0.0 { 0.0 } else { factor * libm::pow(x, p) };
        self.chain(libm::pow(x, p), [slope(p, p - 1.0), slope(p * (p - 1.0), p - 2.0)])
    }
    fn exp(self) -> Self {
        let e = libm::exp(self.value.high);
        self.chain(e, [e, e])
    }
    fn ln(self) -> Self {
        let x = self.value.high;
        self.chain(libm::log(x), [1.0 / x, -1.0 / (x * x)])
    }
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    fn cos(self) -> Self {
        self.sin_cos().1
    }
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = libm::sincos(self.value.high);
        (self.chain(sin, [cos, -sin]), self.chain(cos, [-sin, -cos]))
    }
}

#[cfg(test)]
mod tests {
    use crate::doubled::{Doubled, DoubledDual};
    use crate::scalar::Scalar;

    #[test]
    fn sums_products_quotients_and_roots_have_twice_the_digits() {
        let [one, third] = [Doubled::from(1.0), Doubled::from(1.0) / Doubled::from(3.0)];
        assert!((third + third + third - one).size() < 1e-31);
        let small = Doubled::from(1e-20);
        assert_eq!((one + small - one).high, 1e-20);
        let root = Doubled::from(2.0).root();
        assert!((root * root - Doubled::from(2.0)).size() < 1e-30);
        let x = DoubledDual { value: Doubled::from(2.0), slope: one };
        // (1e12 (x - 1) + 1e-6 x)' = 1e12 + 1e-6.
        let y = (x - 1.0.into()) * 1e12 + x * 1e-6;
        assert_eq!((y.slope - Doubled::from(1e12)).high, 1e-6);
        assert!((x.powf(3.0).slope - Doubled::from(12.0)).size() < 1e-14);
        assert!((x.sqrt().slope * root * Doubled::from(2.0) - one).size() < 1e-30);
    }
}
