//! Sums, products and quotients of series.

use crate::scalar::Scalar;
use crate::series::PowerSeries;
use crate::steepness::{HIGH_DEGREE, steepness_of_product};
use std::ops::{Add, Div, Mul, Neg, Sub};

impl<C: Scalar> Add for PowerSeries<C> {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        let mut sum = self.of_both(&o, self.len.max(o.len), self.hidden.of_sum(&o.hidden));
        sum.c.iter_mut().zip(self.c.iter().zip(&o.c)).for_each(|(sum, (a, b))| *sum = *a + *b);
        sum.hidden = sum.hidden.with_last(sum.last(), sum.full);
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
        self.hidden = self.hidden.times(o);
        self
    }
}

impl<C: Scalar> Mul for PowerSeries<C> {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        let full = self.full.max(o.full);
        let hidden = match (self.len, o.len) {
            (1, _) => o.hidden.times(self.value()),
            (_, 1) => self.hidden.times(o.value()),
            _ => self.hidden.of_product(&o.hidden, [self.value(), o.value()]),
        };
        let mut product = self.of_both(&o, full.min(self.len + o.len - 1), hidden);
        let (short, long) = if self.len < o.len { (&self, &o) } else { (&o, &self) };
        for (j, a) in short.coefficients().iter().enumerate() {
            let sums = &mut product.c[j..full];
            sums.iter_mut().zip(&long.c[..long.len]).for_each(|(sum, b)| *sum = *sum + *a * *b);
        }
        if self.len > 1 && o.len > 1 {
            product.hidden.last = product.last().map(f64::abs);
        }
        if product.hidden.degree > HIGH_DEGREE
            && let Some(jets) = product.jets()
        {
            product.hidden.steepness = product.hidden.steepness.max(steepness_of_product(jets));
        }
        product
    }
}

impl<C: Scalar> Div for PowerSeries<C> {
    type Output = Self;
    #[inline]
    fn div(self, o: Self) -> Self {
        if o.len == 1 {
            let hidden = self.hidden.times(o.c[0].plain().map_or(0.0, f64::recip));
            let mut quotient = self.of_both(&o, self.len, hidden);
            quotient.c.iter_mut().zip(&self.c).for_each(|(q, a)| *q = *a / o.c[0]);
            return quotient;
        }
        let full = self.full.max(o.full);
        // What remains of the dividend after each coefficient becomes the next coefficient.
        let mut hidden = self.hidden.of_sum(&o.hidden);
        let per = 1.0 / o.value().abs();
        hidden.noise = per * (self.hidden.noise + per * self.value().abs() * o.hidden.noise);
        let mut rest = self.of_both(&o, full, hidden);
        rest.c = self.c;
        for n in 0..full {
            let (done, open) = rest.c[n..full].split_at_mut(1);
            done[0] = done[0] / o.c[0];
            open.iter_mut().zip(&o.c[1..]).for_each(|(rest, b)| *rest = *rest - done[0] * *b);
        }
        rest.whole().steep_in(&o, 1.0, true)
    }
}
