//! Dual numbers: exact derivatives of the algebra of a model.

use crate::scalar::Scalar;
use std::ops::Add;
use std::ops::Div;
use std::ops::Mul;
use std::ops::Neg;
use std::ops::Sub;

/// x + Σ x'_i ε_i with ε_i ε_j = 0: a value and its slopes (derivatives) in N directions. Slopes are exact to
/// rounding.
///
/// The slope of √x is infinite at x = 0. There it is replaced by the slope at the smallest normal number,
/// 3.4e153. A term with slope 0 then keeps slope 0 under the root, and x √x has its exact slope 0. For powers
/// with an exponent below 1 and for logarithms, the slope at 0 is replaced by the slope at 1.5e-154.
///
/// ```
/// use gear_dynamics::model::{Dual, Scalar};
/// let x = Dual::variable(4.0);
/// assert_eq!(x.sqrt().value, 2.0);
/// assert_eq!(x.sqrt().slope, [0.25]);
/// let (x, y) = (Dual::<2>::along(3.0, 0), Dual::<2>::along(5.0, 1));
/// assert_eq!((x * y).slope, [5.0, 3.0]);
/// let zero = Dual::variable(0.0);
/// assert_eq!((zero.abs() * zero.abs().sqrt()).slope, [0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const N: usize = 1> {
    /// Value x.
    pub value: f64,
    /// Slopes x'_i.
    pub slope: [f64; N],
}

/// √2.2e-308, the root of the smallest normal number.
const MIN_ROOT: f64 = 1.491_668_146_240_041_3e-154;

impl Dual {
    /// A variable with this value: slope 1.
    pub fn variable(value: f64) -> Self {
        Dual { value, slope: [1.0] }
    }
}

impl<const N: usize> Dual<N> {
    /// The variable of one direction, counted from 0: slope 1 in this direction and 0 in all others.
    #[inline(always)]
    pub fn along(value: f64, direction: usize) -> Self {
        Dual { value, slope: std::array::from_fn(|i| if i == direction { 1.0 } else { 0.0 }) }
    }

    /// g(x) + Σ g'(x) x'_i ε_i, from g(x) and g'(x): the chain rule.
    #[inline(always)]
    fn chain(self, g: f64, dg: f64) -> Self {
        Dual { value: g, slope: self.slope.map(|x| dg * x) }
    }
}

impl<const N: usize> From<f64> for Dual<N> {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Dual { value, slope: [0.0; N] }
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Dual { value: self.value + o.value, slope: std::array::from_fn(|i| self.slope[i] + o.slope[i]) }
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Dual { value: self.value - o.value, slope: std::array::from_fn(|i| self.slope[i] - o.slope[i]) }
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline(always)]
    #[allow(clippy::suspicious_arithmetic_impl, reason = "the product and quotient rules")]
    fn mul(self, o: Self) -> Self {
        Dual {
            value: self.value * o.value,
            slope: std::array::from_fn(|i| self.slope[i] * o.value + self.value * o.slope[i]),
        }
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: f64) -> Self {
        Dual { value: self.value * o, slope: self.slope.map(|x| x * o) }
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    #[inline(always)]
    #[allow(clippy::suspicious_arithmetic_impl, reason = "the product and quotient rules")]
    fn div(self, o: Self) -> Self {
        let value = self.value / o.value;
        Dual { value, slope: std::array::from_fn(|i| (self.slope[i] - value * o.slope[i]) / o.value) }
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Dual { value: -self.value, slope: self.slope.map(|x| -x) }
    }
}

impl<const N: usize> Scalar for Dual<N> {
    #[inline(always)]
    fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        let below = if value == 0.0 { MIN_ROOT } else { value };
        Dual { value, slope: self.slope.map(|x| 0.5 * x / below) }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        if self.value < 0.0 { -self } else { self }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self.value < other.value { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self.value > other.value { self } else { other }
    }
    #[inline(always)]
    fn step(self) -> Self {
        Dual::from(Scalar::step(self.value))
    }
    #[inline(always)]
    fn powf(self, p: f64) -> Self {
        let below = if self.value == 0.0 && p < 1.0 { MIN_ROOT } else { self.value };
        self.chain(libm::pow(self.value, p), if p == 0.0 { 0.0 } else { p * libm::pow(below, p - 1.0) })
    }
    #[inline(always)]
    fn exp(self) -> Self {
        let e = libm::exp(self.value);
        self.chain(e, e)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        let below = if self.value == 0.0 { MIN_ROOT } else { self.value };
        self.chain(libm::log(self.value), 1.0 / below)
    }
    #[inline(always)]
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    #[inline(always)]
    fn cos(self) -> Self {
        self.sin_cos().1
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = libm::sincos(self.value);
        (self.chain(sin, cos), self.chain(cos, -sin))
    }
}
