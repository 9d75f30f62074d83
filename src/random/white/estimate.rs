//! Estimates with their errors.

use crate::error::{ParameterError, check};
use crate::sweep::ensembles::confidence::deviations_of;

/// A mean over batches, with its standard error.
///
/// The batches are spans of time, of several members or of one. They count as independent: each must be much
/// longer than the time over which the motion forgets its state, which is 1/(damping) or more. Batches of
/// different members are independent in any case.
///
/// ```
/// use gear_dynamics::random::Estimate;
/// let estimate = Estimate::of(&[1.0, 2.0, 3.0, 2.0, 1.0, 3.0, 2.0, 2.0])?;
/// assert_eq!(estimate.mean(), 2.0);
/// assert!((estimate.standard_error() - (4.0f64 / 7.0 / 8.0).sqrt()).abs() < 1e-15);
/// // 2 ± 2.365 standard errors: Student's t with 7 degrees of freedom.
/// let [low, high] = estimate.confidence(0.95)?;
/// assert!((high - low - 2.0 * 2.3646 * estimate.standard_error()).abs() < 1e-4);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    mean: f64,
    standard_error: f64,
    batches: usize,
}

impl Estimate {
    /// Minimum number of batches.
    pub(crate) const BATCHES: usize = 8;

    /// The mean of these values of independent batches of equal length.
    ///
    /// # Errors
    /// Fewer than 8 values.
    pub fn of(values: &[f64]) -> Result<Self, ParameterError> {
        check::at_least("batches of an estimate", values.len(), Estimate::BATCHES)?;
        Ok(Estimate::ratio(values.iter().map(|x| [*x, 1.0])))
    }

    /// Σx/Σy of pairs [x, y], one for each batch; NaN for Σy = 0. Its standard error is that of the mean of
    /// x - (Σx/Σy) y, over the mean of y.
    pub(crate) fn ratio(pairs: impl Iterator<Item = [f64; 2]> + Clone) -> Self {
        let (count, above, below) =
            pairs.clone().fold((0, 0.0, 0.0), |(n, a, b), [x, y]| (n + 1, a + x, b + y));
        let (mean, n) = (if below == 0.0 { f64::NAN } else { above / below + 0.0 }, count as f64);
        let square: f64 = pairs.map(|[x, y]| (x - mean * y) * (x - mean * y)).sum();
        let standard_error = (square * n / (n - 1.0)).sqrt() / below.abs();
        Estimate { mean, standard_error, batches: count }
    }

    /// The mean.
    pub fn mean(&self) -> f64 {
        self.mean
    }
    /// The standard error of the mean.
    pub fn standard_error(&self) -> f64 {
        self.standard_error
    }
    /// The standard error over |mean|; NaN or infinite for a mean of 0.
    pub fn relative_error(&self) -> f64 {
        self.standard_error / self.mean.abs()
    }
    /// Number of batches.
    pub fn batches(&self) -> usize {
        self.batches
    }

    /// The interval that contains the true mean with the probability `level`, for example 0.95: the mean ± t
    /// standard errors, with Student's t for one degree of freedom less than batches.
    ///
    /// # Errors
    /// A level outside (0, 1).
    pub fn confidence(&self, level: f64) -> Result<[f64; 2], ParameterError> {
        let t = student(deviations_of(level)?, (self.batches - 1) as f64);
        Ok([self.mean - t * self.standard_error, self.mean + t * self.standard_error])
    }
}

/// The t with P(|T| < t) = P(|Z| < z) for a normal Z and Student's T with n degrees of freedom; for n >= 7
/// accurate to 3e-4 up to a probability of 0.99.   Source: Abramowitz and Stegun 1964, 26.7.5.
fn student(z: f64, n: f64) -> f64 {
    let s = z * z;
    let terms = [
        z * (s + 1.0) / 4.0,
        z * ((5.0 * s + 16.0) * s + 3.0) / 96.0,
        z * (((3.0 * s + 19.0) * s + 17.0) * s - 15.0) / 384.0,
        z * ((((79.0 * s + 776.0) * s + 1482.0) * s - 1920.0) * s - 945.0) / 92160.0,
    ];
    z + terms.iter().rev().fold(0.0, |sum, term| (sum + term) / n)
}

#[cfg(test)]
mod tests {
    use super::student;
    use crate::sweep::ensembles::confidence::deviations_of;

    /// Tabulated values: Abramowitz and Stegun 1964, Table 26.10.
    #[test]
    fn quantiles_agree_with_tables() {
        for (level, n, t) in [(0.9, 7.0, 1.895), (0.95, 7.0, 2.365), (0.99, 7.0, 3.499), (0.95, 30.0, 2.042)]
        {
            let found = student(deviations_of(level).unwrap(), n);
            assert!((found - t).abs() < 1e-3, "{level} {n}: {found}");
        }
        assert!((student(deviations_of(0.95).unwrap(), 1e9) - 1.959_964).abs() < 1e-6);
    }
}
