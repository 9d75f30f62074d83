//! Mean and deviation of values that come one by one, in groups, or over time.

/// From the first value above this magnitude, deviations are multiplied by [`LARGE_UNIT`] before they are
/// squared.
const LARGE: f64 = 1e140;

/// 2⁻⁶⁰⁰.
const LARGE_UNIT: f64 = f64::from_bits((1023 - 600) << 52);

/// Weight w, mean m and sum of the squared deviations S of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moments {
    /// Number of values, or a duration.
    weight: f64,
    mean: f64,
    /// Σ ((x - m) unit)².
    squares: f64,
    /// Factor of the deviations before they are squared: 1, or 2⁻⁶⁰⁰ from the first x beyond ±[`LARGE`] on,
    /// so that squares do not overflow.
    unit: f64,
}

impl Moments {
    /// Those of no values.
    pub(crate) const NONE: Moments = Moments { weight: 0.0, mean: 0.0, squares: 0.0, unit: 1.0 };

    /// From sums about the first value x_0, which cancel little if the mean is large: `off` Σ (x - x_0),
    /// `squares` Σ (x - x_0)².
    ///
    /// m = x_0 + off/w,   S = squares - off²/w
    pub(crate) fn about(first: f64, [off, squares]: [f64; 2], weight: f64) -> Self {
        let mean_off = off / weight;
        // A sum that is infinite or NaN shows as such.
        let squares = if squares < f64::INFINITY { (squares - mean_off * off).max(0.0) } else { squares };
        Moments { weight, mean: first + mean_off, squares, unit: 1.0 }
    }

    /// Adds a value. Welford's recurrence, with n the new count and m' the new mean:
    ///
    /// m' = m + (x - m)/n,   S' = S + (x - m)(x - m')
    pub(crate) fn add(&mut self, x: f64) {
        self.weight += 1.0;
        if x.abs() > LARGE && self.unit == 1.0 {
            (self.unit, self.squares) = (LARGE_UNIT, self.squares * LARGE_UNIT * LARGE_UNIT);
        }
        let off = x * self.unit - self.mean * self.unit;
        self.mean += off / self.weight / self.unit;
        self.squares += off * (x * self.unit - self.mean * self.unit);
    }

    /// Adds the values of another, of weight w', mean m' and squared deviations S':
    ///
    /// m ← m + (m' - m) w'/(w + w'),   S ← S + S' + (m' - m)² w w'/(w + w')
    ///
    /// Source: Chan, Golub & LeVeque, Am. Stat. 37 (1983) 242.
    pub(crate) fn merge(&mut self, other: &Moments) {
        let unit = self.unit.min(other.unit);
        let squares = |x: &Moments| x.squares * (unit / x.unit) * (unit / x.unit);
        let share = other.weight / (self.weight + other.weight);
        let apart = other.mean * unit - self.mean * unit;
        self.squares = squares(self) + (squares(other) + apart * apart * (self.weight * share));
        self.mean += apart * share / unit;
        self.weight += other.weight;
        self.unit = unit;
    }

    pub(crate) fn mean(&self) -> f64 {
        self.mean
    }
    /// m² + S/w, the mean of the squares.
    pub(crate) fn mean_square(&self) -> f64 {
        self.mean * self.mean + self.squares / self.weight / self.unit / self.unit
    }
    /// √(S/w), the standard deviation of the values.
    pub(crate) fn deviation(&self) -> f64 {
        (self.squares / self.weight).sqrt() / self.unit
    }
    /// S/(n - 1), the variance estimated from n values; 0 with fewer than two.
    pub(crate) fn variance(&self) -> f64 {
        self.scaled_variance() / self.unit / self.unit
    }
    /// √(variance/n), the standard error of the mean; infinite with fewer than two values.
    pub(crate) fn standard_error(&self) -> f64 {
        if self.weight > 1.0 {
            (self.scaled_variance() / self.weight).sqrt() / self.unit
        } else {
            f64::INFINITY
        }
    }
    fn scaled_variance(&self) -> f64 {
        if self.weight > 1.0 { self.squares / (self.weight - 1.0) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::Moments;

    /// The values 1 to 6: mean 3.5, S = 17.5.
    #[test]
    fn values_groups_and_sums_about_the_first_have_the_same_moments() {
        let of = |values: &[f64]| {
            let mut moments = Moments::NONE;
            values.iter().for_each(|x| moments.add(*x));
            moments
        };
        let mut groups = of(&[1.0, 2.0]);
        groups.merge(&of(&[3.0, 4.0, 5.0, 6.0]));
        for moments in [of(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), groups, Moments::about(1.0, [15.0, 55.0], 6.0)] {
            assert!((moments.mean() - 3.5).abs() < 1e-15);
            assert!((moments.mean_square() - 91.0 / 6.0).abs() < 1e-14);
            assert!((moments.deviation() - (17.5f64 / 6.0).sqrt()).abs() < 1e-15);
            assert!((moments.variance() - 3.5).abs() < 1e-14);
            assert!((moments.standard_error() - (3.5f64 / 6.0).sqrt()).abs() < 1e-15);
        }
    }

    #[test]
    fn squares_of_large_values_do_not_overflow() {
        let mut moments = Moments::NONE;
        [1.0, 1e200, -1e200].iter().for_each(|x| moments.add(*x));
        assert!((moments.deviation() / 1e200 - (2.0f64 / 3.0).sqrt()).abs() < 1e-15);
        let mut merged = Moments::about(0.0, [3.0, 3.0], 3.0);
        merged.merge(&moments);
        assert!((merged.deviation() / 1e200 - (1.0f64 / 3.0).sqrt()).abs() < 1e-15);
    }

    /// Sums that overflow do not cancel to a finite deviation.
    #[test]
    fn an_infinite_sum_shows() {
        assert_eq!(Moments::about(0.0, [1e155, f64::INFINITY], 10.0).deviation(), f64::INFINITY);
        assert!(Moments::about(0.0, [f64::NAN, f64::NAN], 10.0).deviation().is_nan());
    }
}
