//! Values with their first two derivatives.

use std::ops::Add;
use std::ops::Div;
use std::ops::Mul;
use std::ops::Neg;
use std::ops::Sub;

/// A value f(x) with f'(x) and f''(x). Arithmetic on jets follows the product rule and the chain rule.
///
/// ```
/// use gear_dynamics::excitation::Jet;
/// let f = (Jet::variable(0.0) * 2.0).sin() * 3.0; // 3 sin 2x
/// assert_eq!((f.value, f.rate, f.second), (0.0, 6.0, 0.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet {
    /// f.
    pub value: f64,
    /// f'.
    pub rate: f64,
    /// f''.
    pub second: f64,
}

impl Jet {
    /// A jet of the given value, first and second derivative.
    #[inline]
    pub fn new(value: f64, rate: f64, second: f64) -> Self {
        Jet { value, rate, second }
    }
    /// The variable x itself: f' = 1, f'' = 0.
    #[inline]
    pub fn variable(x: f64) -> Self {
        Jet::new(x, 1.0, 0.0)
    }
    /// A constant: f' = f'' = 0.
    #[inline]
    pub fn constant(value: f64) -> Self {
        Jet::new(value, 0.0, 0.0)
    }

    /// g(f) from g, g' and g'' at f: (g(f))'' = g'' f'² + g' f''.
    #[inline]
    fn chain(self, g: f64, dg: f64, ddg: f64) -> Self {
        Jet::new(g, dg * self.rate, ddg * self.rate * self.rate + dg * self.second)
    }
    /// Sine and cosine together.
    #[inline]
    pub fn sin_cos(self) -> (Self, Self) {
        let (s, c) = libm::sincos(self.value);
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
        let e = libm::exp(self.value);
        self.chain(e, e, e)
    }
    /// Square root.
    #[inline]
    pub fn sqrt(self) -> Self {
        let r = self.value.sqrt();
        self.chain(r, 0.5 / r, -0.25 / (r * self.value))
    }
}

impl Add for Jet {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Jet::new(self.value + o.value, self.rate + o.rate, self.second + o.second)
    }
}

impl Sub for Jet {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        Jet::new(self.value - o.value, self.rate - o.rate, self.second - o.second)
    }
}

impl Neg for Jet {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Jet::new(-self.value, -self.rate, -self.second)
    }
}

impl Mul for Jet {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        Jet::new(
            self.value * o.value,
            self.rate * o.value + self.value * o.rate,
            self.second * o.value + 2.0 * self.rate * o.rate + self.value * o.second,
        )
    }
}

impl Div for Jet {
    type Output = Self;
    #[inline]
    fn div(self, o: Self) -> Self {
        let r = 1.0 / o.value;
        self * o.chain(r, -r * r, 2.0 * r * r * r)
    }
}

impl Add<f64> for Jet {
    type Output = Self;
    #[inline]
    fn add(self, o: f64) -> Self {
        Jet { value: self.value + o, ..self }
    }
}

impl Mul<f64> for Jet {
    type Output = Self;
    #[inline]
    fn mul(self, o: f64) -> Self {
        Jet::new(self.value * o, self.rate * o, self.second * o)
    }
}
