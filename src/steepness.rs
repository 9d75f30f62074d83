//! How soon a function of something that varies may change its nature.

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
