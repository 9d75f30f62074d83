//! Numbers that carry the sum of the terms that they are made of.

use crate::scalar::Scalar;
use std::ops::Add;
use std::ops::Div;
use std::ops::Mul;
use std::ops::Neg;
use std::ops::Sub;

/// A value x and the sum Σ|terms| >= |x| of the terms that it is made of, so that ε Σ|terms| estimates its
/// rounding error, ε = 2.2e-16.
///
/// Terms add up although their values cancel: 1e5 - 1e5 is 0 and has terms of 2e5. Functions pass them on to
/// first order: the terms of g(x) are |g'(x)| Σ|terms of x|, and at least |g(x)|.   Source: Higham, Accuracy
/// and Stability of Numerical Algorithms (2002), Sect. 3.3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rounded {
    pub(crate) value: f64,
    pub(crate) terms: f64,
}

impl Rounded {
    /// g(x) from g and |g'|. A slope that is not finite counts as 0.
    #[inline(always)]
    fn chain(self, g: f64, slope: f64) -> Self {
        let brought = slope.abs() * self.terms;
        Rounded { value: g, terms: if brought > g.abs() && brought.is_finite() { brought } else { g.abs() } }
    }
}

impl From<f64> for Rounded {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Rounded { value, terms: value.abs() }
    }
}

impl Add for Rounded {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Rounded { value: self.value + o.value, terms: self.terms + o.terms }
    }
}

impl Sub for Rounded {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Rounded { value: self.value - o.value, terms: self.terms + o.terms }
    }
}

impl Mul for Rounded {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        let value = self.value * o.value;
        // |a| T_b + |b| T_a - |a b|: the terms of a product of two numbers without cancellation are |a b|.
        let terms = self.value.abs() * o.terms + o.value.abs() * (self.terms - self.value.abs());
        Rounded { value, terms }
    }
}

impl Mul<f64> for Rounded {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: f64) -> Self {
        Rounded { value: self.value * o, terms: self.terms * o.abs() }
    }
}

impl Div for Rounded {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        let value = self.value / o.value;
        let terms = (self.terms + value.abs() * (o.terms - o.value.abs())) / o.value.abs();
        Rounded { value, terms }
    }
}

impl Neg for Rounded {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Rounded { value: -self.value, ..self }
    }
}

impl Scalar for Rounded {
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Rounded { value: self.value.abs(), ..self }
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        if self.value < o.value { self } else { o }
    }
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        if self.value > o.value { self } else { o }
    }
    #[inline(always)]
    fn step(self) -> Self {
        Scalar::step(self.value).into()
    }
    #[inline(always)]
    fn powf(self, p: f64) -> Self {
        self.chain(libm::pow(self.value, p), p * libm::pow(self.value, p - 1.0))
    }
    #[inline(always)]
    fn exp(self) -> Self {
        let e = libm::exp(self.value);
        self.chain(e, e)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        self.chain(libm::log(self.value), 1.0 / self.value)
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
        (self.chain(sin, cos), self.chain(cos, sin))
    }
}

#[cfg(test)]
mod tests {
    use crate::rounded::Rounded;
    use crate::scalar::Scalar;

    #[test]
    fn terms_remain_where_values_cancel() {
        let [a, b] = [Rounded::from(1e5), Rounded::from(3.0)];
        assert_eq!(a - a, Rounded { value: 0.0, terms: 2e5 });
        assert_eq!((a * b).terms, 3e5);
        assert_eq!(((a - a) * b).terms, 6e5);
        assert_eq!(((a - a) / b).terms, 2e5 / 3.0);
        assert_eq!((a / (b - b + b)).value, 1e5 / 3.0);
        assert_eq!((b - b + b).terms, 9.0);
        assert!(((a / (b - b + b)).terms - 3.0 * 1e5 / 3.0).abs() < 1e-9);
        assert_eq!((a - a).sqrt().terms, 0.0); // the slope is not finite
        assert_eq!((a - a).sin().terms, 2e5);
        assert_eq!((b - b).exp(), Rounded { value: 1.0, terms: 6.0 });
    }
}
