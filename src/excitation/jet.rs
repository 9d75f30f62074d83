//! Values with their first two derivatives.

use crate::scalar::Scalar;
use std::ops::Add;
use std::ops::Div;
use std::ops::Mul;
use std::ops::Neg;
use std::ops::Sub;

/// A value f(x) with f'(x) and f''(x), as numbers `f64` or of another [`Scalar`]. Arithmetic on jets follows
/// the product rule and the chain rule.
///
/// ```
/// use gear_dynamics::excitation::Jet;
/// let f = (Jet::variable(0.0) * 2.0).sin() * 3.0; // 3 sin 2x
/// assert_eq!((f.value, f.rate, f.second), (0.0, 6.0, 0.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet<S = f64> {
    /// f.
    pub value: S,
    /// f'.
    pub rate: S,
    /// f''.
    pub second: S,
}

impl<S: Scalar> Jet<S> {
    /// A jet of the given value, first and second derivative.
    #[inline]
    pub fn new(value: S, rate: S, second: S) -> Self {
        Jet { value, rate, second }
    }
    /// The variable x itself: f' = 1, f'' = 0.
    #[inline]
    pub fn variable(x: S) -> Self {
        Jet::new(x, S::from(1.0), S::from(0.0))
    }
    /// A constant: f' = f'' = 0.
    #[inline]
    pub fn constant(value: S) -> Self {
        Jet::new(value, S::from(0.0), S::from(0.0))
    }

    /// g(f) from g, g' and g'' at f: (g(f))'' = g'' f'² + g' f''.
    #[inline]
    fn chain(self, g: S, dg: S, ddg: S) -> Self {
        Jet::new(g, dg * self.rate, ddg * self.rate * self.rate + dg * self.second)
    }
    /// Sine and cosine together.
    #[inline]
    pub fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (self.chain(s, c, -s), self.chain(c, -s, -c))
    }
    /// Sine.
    #[inline]
    pub fn sin(self) -> Self {
        self.sin_cos().0
    }
    /// Cosine.
    #[inline]
    pub fn cos(self) -> Self {
        self.sin_cos().1
    }
    /// Exponential.
    #[inline]
    pub fn exp(self) -> Self {
        let e = self.value.exp();
        self.chain(e, e, e)
    }
    /// Square root.
    #[inline]
    pub fn sqrt(self) -> Self {
        let r = self.value.sqrt();
        self.chain(r, S::from(0.5) / r, S::from(-0.25) / (r * self.value))
    }
}

impl<S: Scalar> Add for Jet<S> {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Jet::new(self.value + o.value, self.rate + o.rate, self.second + o.second)
    }
}

impl<S: Scalar> Sub for Jet<S> {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        Jet::new(self.value - o.value, self.rate - o.rate, self.second - o.second)
    }
}

impl<S: Scalar> Neg for Jet<S> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Jet::new(-self.value, -self.rate, -self.second)
    }
}

impl<S: Scalar> Mul for Jet<S> {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        Jet::new(
            self.value * o.value,
            self.rate * o.value + self.value * o.rate,
            self.second * o.value + self.rate * 2.0 * o.rate + self.value * o.second,
        )
    }
}

impl<S: Scalar> Div for Jet<S> {
    type Output = Self;
    #[inline]
    fn div(self, o: Self) -> Self {
        let r = S::from(1.0) / o.value;
        self * o.chain(r, -r * r, r * 2.0 * r * r)
    }
}

impl<S: Scalar> Add<f64> for Jet<S> {
    type Output = Self;
    #[inline]
    fn add(self, o: f64) -> Self {
        Jet { value: self.value + S::from(o), ..self }
    }
}

impl<S: Scalar> Mul<f64> for Jet<S> {
    type Output = Self;
    #[inline]
    fn mul(self, o: f64) -> Self {
        Jet::new(self.value * o, self.rate * o, self.second * o)
    }
}
