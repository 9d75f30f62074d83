//! Confidence intervals of shares and quantiles.

use crate::error::{ParameterError, check};
use crate::numeric::search::bracket::Bracket;

/// A share of trials in which something happened, for example of members that rattled.
///
/// ```
/// use gear_dynamics::sweep::Proportion;
/// let rattled = Proportion::new(3, 100)?;
/// let [low, high] = rattled.confidence(0.95)?;
/// assert_eq!(rattled.share(), 0.03);
/// assert!((low - 0.0062).abs() < 1e-4 && (high - 0.0852).abs() < 1e-4); // Clopper and Pearson
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Proportion {
    hits: u64,
    trials: u64,
}

impl Proportion {
    /// `hits` of `trials`.
    ///
    /// # Errors
    /// No trials or more than 2³²; more hits than trials.
    pub fn new(hits: u64, trials: u64) -> Result<Self, ParameterError> {
        let count = |x: u64| usize::try_from(x).unwrap_or(usize::MAX);
        check::at_least("trials", count(trials), 1)?;
        check::count("trials", &[count(trials)], TRIALS)?;
        check::count("hits", &[count(hits)], count(trials))?;
        Ok(Proportion { hits, trials })
    }
    /// Number of hits.
    pub fn hits(&self) -> u64 {
        self.hits
    }
    /// Number of trials.
    pub fn trials(&self) -> u64 {
        self.trials
    }
    /// Hits over trials `[1]`.
    pub fn share(&self) -> f64 {
        self.hits as f64 / self.trials as f64
    }
    /// The interval that contains the true probability in at least the share `level` of all experiments. No
    /// hit gives a lower end of 0, hits alone an upper end of 1.
    ///
    /// The lower end p has P(at least k hits) = (1 - level)/2, the upper end P(at most k hits) the same.
    /// Source: Clopper and Pearson, Biometrika 26 (1934) 404.
    ///
    /// # Errors
    /// A level outside 0 .. 1, the ends excluded.
    pub fn confidence(&self, level: f64) -> Result<[f64; 2], ParameterError> {
        let tail = 0.5 * (1.0 - check::share("confidence level", level)?);
        let (k, n) = (self.hits as f64, self.trials as f64);
        let root = |above: &dyn Fn(f64) -> bool| Bracket { lo: 0.0, hi: 1.0 }.bisect(0.0, above).middle();
        let low = if k == 0.0 { 0.0 } else { root(&|p| at_least(k, n, p) < tail) };
        let high = if k == n { 1.0 } else { root(&|p| 1.0 - at_least(k + 1.0, n, p) > tail) };
        // Rounding aside, the share lies between them.
        Ok([low.min(self.share()), high.max(self.share())])
    }
}

/// Maximum number of trials. Beyond it, rounding of ln Γ changes the incomplete beta function visibly.
const TRIALS: usize = 1 << 32;

/// The z with P(|normal deviate| < z) = level.
pub(crate) fn deviations_of(level: f64) -> Result<f64, ParameterError> {
    let outside = 1.0 - check::share("confidence level", level)?;
    let above = |z: f64| libm::erfc(z * std::f64::consts::FRAC_1_SQRT_2) > outside;
    Ok(Bracket { lo: 0.0, hi: 40.0 }.bisect(0.0, above).middle())
}

/// Ranks r and s, counted from 1, such that the r-th and s-th of n sorted values enclose the quantile p with
/// at least the probability `level`. 0 and n + 1: no value does.
///
/// P(fewer than r values lie below) ≤ (1 - level)/2, P(at least s values do) the same.   Source: David and
/// Nagaraja, Order Statistics, 3rd ed., Sect. 7.1.
pub(crate) fn quantile_ranks(n: u64, p: f64, level: f64) -> Result<[u64; 2], ParameterError> {
    check::count("values", &[usize::try_from(n).unwrap_or(usize::MAX)], TRIALS)?;
    let tail = 0.5 * (1.0 - check::share("confidence level", level)?);
    let least = |mut lo: u64, mut hi: u64, holds: &dyn Fn(u64) -> bool| {
        while lo < hi {
            let middle = lo + (hi - lo) / 2;
            *(if holds(middle) { &mut hi } else { &mut lo }) =
                if holds(middle) { middle } else { middle + 1 };
        }
        lo
    };
    let above = |k: u64| at_least(k as f64, n as f64, p);
    let low = least(0, n, &|r| 1.0 - above(r + 1) > tail);
    Ok([low, least(1, n + 1, &|s| above(s) <= tail)])
}

/// P(at least k hits in n trials of probability p) = I_p(k, n - k + 1).
fn at_least(k: f64, n: f64, p: f64) -> f64 {
    if k <= 0.0 {
        1.0
    } else if k > n {
        0.0
    } else {
        incomplete_beta(p, k, n - k + 1.0)
    }
}

/// The regularised incomplete beta function I_x(a, b), by its continued fraction.   Source: Press et al.,
/// Numerical Recipes, 3rd ed., Sect. 6.4.
fn incomplete_beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return if x <= 0.0 { 0.0 } else { 1.0 };
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(1.0 - x, b, a);
    }
    const MOST: usize = 100_000;
    let safe = |x: f64| if x.abs() < f64::MIN_POSITIVE { f64::MIN_POSITIVE } else { x };
    let front =
        libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b) + a * libm::log(x) + b * libm::log1p(-x);
    let (mut c, mut d) = (1.0, 1.0 / safe(1.0 - (a + b) * x / (a + 1.0)));
    let mut fraction = d;
    for m in (1..MOST).map(|m| m as f64) {
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let before = fraction;
        for term in [even, odd] {
            d = 1.0 / safe(1.0 + term * d);
            c = safe(1.0 + term / c);
            fraction *= c * d;
        }
        if (fraction - before).abs() <= f64::EPSILON * fraction.abs() {
            break;
        }
    }
    libm::exp(front) * fraction / a
}

#[cfg(test)]
mod tests {
    use super::{deviations_of, incomplete_beta, quantile_ranks};

    /// I_x(1, b) = 1 - (1 - x)^b, I_x(a, 1) = x^a, I_½(a, a) = ½.
    #[test]
    fn closed_forms_of_the_beta_function() {
        for x in [1e-3, 0.2, 0.5, 0.9] {
            for b in [1.0, 3.5, 40.0] {
                assert!((incomplete_beta(x, 1.0, b) - (1.0 - (1.0 - x).powf(b))).abs() < 1e-14);
                assert!((incomplete_beta(x, b, 1.0) - x.powf(b)).abs() < 1e-14);
            }
        }
        for a in [2.0, 1e3, 1e6] {
            assert!((incomplete_beta(0.5, a, a) - 0.5).abs() < 1e-9);
        }
    }

    #[test]
    fn levels_and_ranks() {
        assert!((deviations_of(0.95).unwrap() - 1.959_963_984_540_054).abs() < 1e-13);
        // Of 10 values, the 2nd and the 9th enclose the median with 1 - 2 · 11/1024 = 97.9 %.
        assert_eq!(quantile_ranks(10, 0.5, 0.95).unwrap(), [2, 9]);
        // Of 5 values, the least lies above the median once in 32 times.
        assert_eq!(quantile_ranks(5, 0.5, 0.95).unwrap(), [0, 6]);
        assert_eq!(quantile_ranks(5, 0.5, 0.9).unwrap(), [1, 5]);
    }
}
