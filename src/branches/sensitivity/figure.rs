//! The figures of a channel over a period.

use crate::analysis::Summary;

/// A figure of a channel over a period.
///
/// ```
/// use gear_dynamics::{analysis::Summary, branches::Figure};
/// let summary = Summary::of_samples(&[1.0, 3.0])?;
/// assert_eq!(Figure::PeakToPeak.of(&summary), 2.0);
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Figure {
    /// Mean.
    Mean,
    /// Root mean square.
    Rms,
    /// Maximum less minimum.
    PeakToPeak,
    /// Maximum.
    Max,
    /// Minimum.
    Min,
}

impl Figure {
    /// The figure in a summary.
    pub fn of(self, summary: &Summary) -> f64 {
        match self {
            Figure::Mean => summary.mean,
            Figure::Rms => summary.rms,
            Figure::PeakToPeak => summary.peak_to_peak(),
            Figure::Max => summary.max,
            Figure::Min => summary.min,
        }
    }
}
