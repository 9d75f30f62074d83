//! Functions of series.

use crate::numeric::sine::turned;
use crate::scalar::{Scalar, is_product};
use crate::series::PowerSeries;
use crate::steepness::{Hidden, logarithm, steepness, steepness_of_sine};

impl<C: Scalar> PowerSeries<C> {
    /// The constant f(c_0), or the series whose coefficient n >= 1 is `next(n, this, result)`.
    #[inline]
    fn function(self, f: C, next: impl Fn(usize, &[C], &[C]) -> C) -> Self {
        let len = if self.len == 1 { 1 } else { self.full };
        let mut out = self.like(len);
        out.c[0] = f;
        for n in 1..len {
            out.c[n] = next(n, &self.c, &out.c);
        }
        let [rate, of] = [out.c[1], self.c[1]].map(|rate| rate.plain().unwrap_or(0.0));
        out.hidden.noise *= if of == 0.0 { 1.0 } else { (rate / of).abs() };
        out.whole()
    }

    /// f(c_0) for a constant. Any other series is refused for this reason.
    fn constant_or(self, reason: &'static str, f: impl Fn(C) -> C) -> Self {
        if self.len > 1 { Self::refused(reason) } else { self.function(f(self.c[0]), |_, _, _| C::from(0.0)) }
    }
    /// This result of a function, with the steepness of the function: that of `factor` times its argument,
    /// or of `factor` times the logarithm of it. Plain numbers alone have one.
    pub(super) fn steep_in(mut self, argument: &Self, factor: f64, of_logarithm: bool) -> Self {
        if argument.len > 1
            && let Some(jets) = argument.jets()
        {
            let exponent = if of_logarithm { logarithm(jets) } else { jets };
            let of_function = steepness(exponent.map(|w| factor * w));
            self.hidden.steepness = self.hidden.steepness.max(of_function);
        }
        self
    }
    /// The same series as a wave like `by`, whatever products it was computed with.
    fn as_wave_like(mut self, by: &Self) -> Self {
        self.hidden = Hidden { rate: self.hidden.rate, noise: self.hidden.noise, ..by.hidden };
        self.whole()
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
    fn turned(of: (Self, Self), by: (Self, Self)) -> (Self, Self) {
        let (s, c) = turned(of, by);
        (s.as_wave_like(&by.0), c.as_wave_like(&by.1))
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
        if let Some(jets) = self.jets()
            && len > 1
        {
            [s, c] = [s, c].map(|mut wave| {
                (wave.hidden.waves, wave.hidden.rate) = (1, wave.hidden.rate + steepness_of_sine(jets));
                wave.whole()
            });
        }
        (s, c)
    }
}
