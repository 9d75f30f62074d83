//! The cubic through values and rates at both ends of an interval.

use crate::numeric::search::bracket::{Bracket, rounding};
use crate::numeric::search::extremes::smaller;

/// A distance from an edge, positive on one side of it, and its rate per unit of the abscissa.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Distance {
    pub(crate) value: f64,
    pub(crate) rate: f64,
}

/// A dip is checked on the dense output if its minimum is below this share of its depth `[1]`.
const CHECKED_DIP: f64 = 0.25;

/// A dip cannot reach the edge if both ends are farther from it than this factor times the sum of |rates| at
/// the ends: a cubic dips by at most 4/27 of that sum.
const FAR: f64 = 0.2;

/// d(σ) = d0 + a σ + b σ² + c σ³, σ from 0 to 1 over the interval.
pub(crate) struct Hermite {
    /// d0.
    value: f64,
    /// a, b, c.
    powers: [f64; 3],
}

impl Hermite {
    /// The cubic with distances `d0` at σ = 0 and `d1` at σ = 1; rates per unit of σ.
    #[inline]
    pub(crate) fn new(d0: Distance, d1: Distance) -> Self {
        let rise = d1.value - d0.value;
        Hermite {
            value: d0.value,
            powers: [d0.rate, 3.0 * rise - 2.0 * d0.rate - d1.rate, d0.rate + d1.rate - 2.0 * rise],
        }
    }

    /// Whether the ends alone show that the cubic has no dip and stays above `floor`. The cubic lies between
    /// its Bézier points, which differ from the ends by at most a third of a rate.
    #[inline]
    pub(crate) fn is_clear(d0: Distance, d1: Distance, floor: f64) -> bool {
        let (ends, rates) = (smaller(d0.value, d1.value), d0.rate.abs() + d1.rate.abs());
        ends > FAR * rates && ends - rates / 3.0 > floor
    }

    /// The cubic over an interval of θ of length `width`; rates per unit of θ.
    pub(crate) fn over(width: f64, d0: Distance, d1: Distance) -> Self {
        let scaled = |d: Distance| Distance { rate: width * d.rate, ..d };
        Hermite::new(scaled(d0), scaled(d1))
    }

    /// d(σ).
    #[inline]
    pub(crate) fn at(&self, sigma: f64) -> f64 {
        let [a, b, c] = self.powers;
        self.value + sigma * (a + sigma * (b + sigma * c))
    }

    /// Slope dd/dσ = a + 2 b σ + 3 c σ².
    pub(crate) fn slope(&self, sigma: f64) -> f64 {
        let [a, b, c] = self.powers;
        a + sigma * (2.0 * b + sigma * 3.0 * c)
    }

    /// A root in [0, 1] of a cubic with values of different signs at its ends.
    pub(crate) fn root(&self) -> f64 {
        let unit = Bracket { lo: 0.0, hi: 1.0 };
        unit.solve(0.5, self.value <= 0.0, rounding, |sigma| (self.at(sigma), self.slope(sigma)))
    }

    /// The extrema with 0 < σ < 1, in ascending order.
    pub(crate) fn extrema(&self) -> [Option<f64>; 2] {
        let [a, b, c] = self.powers;
        let disc = b * b - 3.0 * a * c;
        if disc <= 0.0 {
            return [None; 2];
        }
        // a + 2 b σ + 3 c σ² = 0, in the form of the quadratic formula without cancellation.
        let s = -(b + disc.sqrt().copysign(b));
        let (r1, r2) = (s / (3.0 * c), a / s);
        let inside = |r: f64| (r > 0.0 && r < 1.0).then_some(r);
        let (first, second) = if r1 < r2 { (r1, r2) } else { (r2, r1) };
        [inside(first), inside(second)]
    }

    /// The lowest of the extrema with 0 < σ < 1.
    pub(crate) fn lowest(&self) -> Option<f64> {
        match self.extrema() {
            [Some(first), Some(second)] => {
                Some(if self.at(second).total_cmp(&self.at(first)).is_lt() { second } else { first })
            }
            [first, second] => first.or(second),
        }
    }

    /// Minimum over 0 ≤ σ ≤ 1.
    pub(crate) fn least(&self) -> f64 {
        let ends = self.value.min(self.at(1.0));
        self.lowest().map_or(ends, |sigma| ends.min(self.at(sigma)))
    }

    /// Whether the minimum is above `floor`. The cubic lies between its Bézier points; the extrema are
    /// computed only if these points do not decide.
    #[inline]
    pub(crate) fn stays_above(&self, floor: f64) -> bool {
        let [a, b, c] = self.powers;
        let (third, inner) = (self.value + a / 3.0, self.value + (2.0 * a + b) / 3.0);
        let points = self.value.min(third).min(inner.min(self.value + (a + b + c)));
        points > floor || self.least() > floor
    }

    /// Whether a distance that deviates from the cubic by at most `off` stays above its value at the start.
    ///
    /// The distance and the cubic have the same values and rates at both ends. The deviation is assumed to be
    /// 16 off σ² (1-σ)², the error of a cubic for a constant fourth derivative. The distance has then risen
    /// by at least σ (a + b σ + c σ² - 16 off σ (1-σ)²). The maximum of σ (1-σ)² is 4/27.
    #[inline]
    pub(crate) fn rises(&self, off: f64) -> bool {
        let [a, b, c] = self.powers;
        let inside = c > 0.0 && b < 0.0 && -b < 2.0 * c;
        let bottom = if inside { a - b * b / (4.0 * c) } else { a };
        bottom.min(a + b + c) > 64.0 / 27.0 * off
    }

    /// Whether the cubic has a minimum so close to zero, or below it, that the dense output must be checked.
    #[inline]
    pub(crate) fn may_dip(&self, d0: Distance, d1: Distance) -> bool {
        // A cubic that rises at its start and falls at its end has no minimum between them.
        let ends = d0.value.min(d1.value);
        if (d0.rate >= 0.0 && d1.rate <= 0.0) || ends > FAR * (d0.rate.abs() + d1.rate.abs()) {
            return false;
        }
        self.lowest().is_some_and(|sigma| {
            let bottom = self.at(sigma);
            bottom < CHECKED_DIP * (ends - bottom)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Distance, Hermite};
    use proptest::prelude::*;

    #[test]
    fn a_straight_rise() {
        let [d0, d1] = [0.0, 1.0].map(|value| Distance { value, rate: 1.0 });
        let rises = |off| Hermite::new(d0, d1).rises(off);
        // A deviation 16 off σ² (1-σ)² touches the line σ for off = 27/64.
        assert!(rises(0.421) && !rises(0.422));
    }

    /// The cubic (x - 0.3) (x + 1) (2 - x), and x³ - 0.9³, which starts flat.
    #[test]
    fn roots() {
        let cubic = |x: f64| (x - 0.3) * (x + 1.0) * (2.0 - x);
        let rate = |x: f64| (x + 1.0) * (2.0 - x) + (x - 0.3) * (2.0 - x) - (x - 0.3) * (x + 1.0);
        let [d0, d1] = [0.0, 1.0].map(|x| Distance { value: cubic(x), rate: rate(x) });
        let found = Hermite::new(d0, d1);
        assert!((found.at(0.7) - cubic(0.7)).abs() < 1e-14 && (found.slope(0.7) - rate(0.7)).abs() < 1e-14);
        assert!((found.root() - 0.3).abs() < 1e-15);
        let (d0, d1) = (Distance { value: -0.729, rate: 0.0 }, Distance { value: 0.271, rate: 3.0 });
        assert!((Hermite::new(d0, d1).root() - 0.9).abs() < 1e-15);
    }

    proptest! {
        /// The largest deviation that the documentation names leaves the distance above its start.
        #[test]
        fn a_rise_leaves_room_for_the_deviation(rates in [-1.0..3.0, -3.0..3.0f64], rise in 0.0..3.0f64) {
            let [d0, d1] = [Distance { value: 0.5, rate: rates[0] }, Distance { value: 0.5 + rise, rate: rates[1] }];
            let cubic = Hermite::new(d0, d1);
            let stays = |off: f64| (1..=1000).all(|i| {
                let s = f64::from(i) / 1000.0;
                cubic.at(s) - off * 16.0 * (s * (1.0 - s)).powi(2) >= 0.5 - 1e-12
            });
            for off in [0.0, 0.01, 0.1, 0.3] {
                prop_assert!(!cubic.rises(off) || stays(off), "{d0:?} {d1:?} {off}");
            }
        }
    }
}
