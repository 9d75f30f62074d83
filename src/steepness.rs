//! How soon a function of something that varies may change its nature, and what sums and products may hide.

/// Number of coefficients that are read.
pub(crate) const JETS: usize = 4;

/// The way of an exponent in which e^w changes little enough to be seen by two samples `[1]`.
const WAY: f64 = 2.0;

/// Beyond ±FAR e^w is negligible beside 1, or 1 beside it: half of the way back is left out.
const FAR: f64 = 30.0;

/// Largest number of varying factors in a product for which the last Taylor coefficients suffice to choose
/// the step. A product of more factors may be below rounding at the start of a step and large at its end.
/// Example: from rest each factor begins with t², and a product of n factors begins with t^(2n).
pub(crate) const HIGH_DEGREE: usize = 7;

/// The way of the argument of a sine in which it, and a product of high degree in which it is a factor,
/// change little enough to be seen by two samples `[rad]`.
const TURN: f64 = 1.0;

/// Below this share of the size of its terms a coefficient of a sum shows nothing of what is to come `[1]`.
pub(crate) const SHOWN: f64 = 1.0 / 16.0;

/// Whether the last coefficient and the one before it, each with the sum of the sizes of its terms, do not
/// show a sum. `time`: the time in which the last term becomes as large as the one before it. At some angles
/// every second coefficient is 0, up to rounding: the larger of the two counts.
#[inline]
pub(crate) fn are_hidden([last, below]: [[f64; 2]; 2], time: f64) -> bool {
    let [sum, size] = [0, 1].map(|i| last[i].abs() * time + below[i].abs());
    sum <= SHOWN * size && size > 0.0
}

/// What the last coefficients of a series may hide.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Hidden {
    /// The largest [`steepness`] of the functions in it `[1/s]`.
    pub(crate) steepness: f64,
    /// Upper bound of the number of varying factors that are multiplied in it.
    pub(crate) degree: usize,
    /// Upper bound of the number of waves that are added in it, and the fastest of their rates `[1/s]`.
    pub(crate) waves: usize,
    pub(crate) rate: f64,
    /// The sizes of the last two coefficients: the sums of those of all terms.
    pub(crate) last: [f64; 2],
    /// What rounding changes of its value, about: terms that cancel leave their rounding.
    pub(crate) noise: f64,
}

impl Hidden {
    /// That of a sum or difference.
    pub(crate) fn of_sum(&self, o: &Self) -> Self {
        Hidden {
            steepness: self.steepness.max(o.steepness),
            degree: self.degree.max(o.degree),
            waves: self.waves.saturating_add(o.waves),
            rate: self.rate.max(o.rate),
            last: [self.last[0] + o.last[0], self.last[1] + o.last[1]],
            noise: self.noise + o.noise,
        }
    }
    /// That of a product of two series that vary and have these values.
    pub(crate) fn of_product(&self, o: &Self, [a, b]: [f64; 2]) -> Self {
        Hidden {
            steepness: self.steepness.max(o.steepness),
            degree: self.degree.saturating_add(o.degree),
            waves: self.waves.max(1).saturating_mul(o.waves.max(1)),
            rate: self.rate + o.rate,
            last: [0.0; 2],
            noise: a.abs() * o.noise + b.abs() * self.noise,
        }
    }
    /// That of a multiple.
    pub(crate) fn times(mut self, factor: f64) -> Self {
        self.noise *= factor.abs();
        self.last = self.last.map(|size| size * factor.abs());
        self
    }
    /// That of the sum whose last two of `coefficients` coefficients these are: as steep as its waves where
    /// they do not show it. M waves and a mean are 0 with 2M coefficients at most; few coefficients never
    /// show them.
    #[inline]
    pub(crate) fn with_last(mut self, last: [f64; 2], coefficients: usize) -> Self {
        let sums = [[last[0], self.last[0]], [last[1], self.last[1]]];
        let time = coefficients as f64 / self.rate;
        if 2 * self.waves > HIGH_DEGREE && (coefficients <= JETS + 2 || are_hidden(sums, time)) {
            self.steepness = self.steepness.max(self.rate);
        }
        self
    }
}

/// 1/s of the time s in which the exponent w of e^w, with these Taylor coefficients, moves by [`WAY`] at
/// most, or by half of what separates it from [`FAR`].
///
/// With L the allowed way it is Σ (|w_n|/L)^(1/n): then Σ |w_n| sⁿ <= L.
pub(crate) fn steepness([w, first, second, third]: [f64; JETS]) -> f64 {
    reach([first, second, third], WAY + 0.5 * (w.abs() - FAR).max(0.0))
}

/// The rate at which a sine changes its value: 1/s of the time s in which its argument moves by [`TURN`] at
/// most. The argument is given by its Taylor coefficients.
pub(crate) fn steepness_of_sine([_, first, second, third]: [f64; JETS]) -> f64 {
    reach([first, second, third], TURN)
}

fn reach([first, second, third]: [f64; JETS - 1], way: f64) -> f64 {
    (first / way).abs() + (second / way).abs().sqrt() + libm::cbrt((third / way).abs())
}

/// The steepness of a product of high degree that is 0. Its coefficients do not show how soon it changes:
/// from rest all of them are 0.
const UNKNOWN: f64 = f64::MIN_POSITIVE;

/// The [`steepness`] of a product of high degree, from its own coefficients: it is e^w with the logarithm w
/// of its size. A product that is 0 has the steepness [`UNKNOWN`], and one that is too small for a double.
pub(crate) fn steepness_of_product(jets: [f64; JETS]) -> f64 {
    if jets[0] == 0.0 { UNKNOWN } else { steepness(logarithm(jets)) }
}

/// The Taylor coefficients of ln |b|: a power b^p is e^w with w = p ln |b|.
pub(crate) fn logarithm([b, first, second, third]: [f64; JETS]) -> [f64; JETS] {
    let [x, y, z] = [first / b, second / b, third / b];
    [libm::log(b.abs()), x, y - 0.5 * x * x, z - x * y + x * x * x / 3.0]
}
