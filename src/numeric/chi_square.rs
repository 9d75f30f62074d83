//! The χ² distribution.

use crate::numeric::search::bracket::Bracket;

/// The x with P(χ² < x) = p, for a χ² of `degrees` > 0 degrees of freedom and p in (0, 1).
pub(crate) fn quantile(p: f64, degrees: f64) -> f64 {
    // The mean is `degrees`, its standard deviation √(2 degrees).
    let hi = degrees + 60.0 * (2.0 * degrees).sqrt() + 1500.0;
    Bracket { lo: 0.0, hi }.bisect(0.0, |x| incomplete_gamma(0.5 * degrees, 0.5 * x) < p).middle()
}

/// The regularised lower incomplete gamma function P(a, x), by its series below a + 1 and by the continued
/// fraction of 1 - P above.   Source: Press et al., Numerical Recipes, 3rd ed., Sect. 6.2.
fn incomplete_gamma(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let front = libm::exp(a * libm::log(x) - x - libm::lgamma(a));
    // Near x = a both need some √a terms.
    const MOST: usize = 1_000_000;
    if x < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for n in (1..MOST).map(|n| n as f64) {
            term *= x / (a + n);
            sum += term;
            if term <= f64::EPSILON * sum {
                break;
            }
        }
        return front * sum;
    }
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (f64::MAX, 1.0 / b);
    let mut fraction = d;
    for n in (1..MOST).map(|n| n as f64) {
        let over = n * (a - n);
        b += 2.0;
        d = 1.0 / (b + over * d);
        c = b + over / c;
        fraction *= c * d;
        if (c * d - 1.0).abs() <= f64::EPSILON {
            break;
        }
    }
    1.0 - front * fraction
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two degrees of freedom: 1 - e^(-x/2). One: the square of a normal deviate. Many: a table's digits.
    #[test]
    fn closed_forms_of_the_chi_square_distribution() {
        for p in [1e-6, 0.025, 0.5, 0.975, 0.999_999] {
            assert!((quantile(p, 2.0) / (-2.0 * (1.0f64 - p).ln()) - 1.0).abs() < 1e-9, "{p}");
        }
        assert!((quantile(0.95, 1.0) - 1.959_963_984_540_054f64.powi(2)).abs() < 1e-11);
        assert!((quantile(0.975, 10.0) - 20.483_177).abs() < 1e-6);
        assert!((quantile(0.025, 100.0) - 74.221_927).abs() < 1e-6);
        let many = 1e6;
        assert!((quantile(0.5, many) - (many - 2.0 / 3.0)).abs() < 1e-3);
    }
}
