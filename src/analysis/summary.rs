//! Mean, RMS, extremes and deviation of a channel.

use crate::error::{ParameterError, check};
use crate::numeric::moments::Moments;

/// Mean, RMS, extremes and deviation of a channel over a time T, in the unit of the channel.
///
/// ```
/// let summary = gear_dynamics::analysis::Summary::of_samples(&[1.0, 3.0])?;
/// assert_eq!((summary.mean, summary.peak_to_peak()), (2.0, 2.0));
/// # Ok::<(), gear_dynamics::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct Summary {
    /// Mean (1/T) ∫ f dt.
    pub mean: f64,
    /// Root mean square √((1/T) ∫ f² dt).
    pub rms: f64,
    /// Minimum.
    pub min: f64,
    /// Maximum.
    pub max: f64,
    /// Standard deviation √((1/T) ∫ (f - mean)² dt). [`Statistics`](crate::Statistics) computes it from
    /// moments about the first value of the channel, which avoids cancellation if the mean is large.
    pub deviation: f64,
}

/// The stored form of a [`Summary`] before its figures are checked.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[serde(rename = "Summary", deny_unknown_fields)]
pub(crate) struct RawSummary {
    mean: f64,
    rms: f64,
    min: f64,
    max: f64,
    deviation: f64,
}

#[cfg(feature = "serde")]
impl From<RawSummary> for Summary {
    fn from(RawSummary { mean, rms, min, max, deviation }: RawSummary) -> Self {
        Summary { mean, rms, min, max, deviation }
    }
}

/// Reads summaries that are checked later, with the names of their channels.
#[cfg(feature = "serde")]
pub(crate) fn read_unchecked<'de, D: serde::Deserializer<'de>>(d: D) -> Result<Vec<Summary>, D::Error> {
    let raw = <Vec<RawSummary> as serde::Deserialize>::deserialize(d)?;
    Ok(raw.into_iter().map(Summary::from).collect())
}

impl Summary {
    /// The figures of equally spaced samples.
    ///
    /// # Errors
    /// [`ParameterError::Empty`] without samples; [`ParameterError::NotFinite`] for a sample that is NaN or
    /// infinite; [`ParameterError::Overflow`] if the sum or the mean square overflows.
    pub fn of_samples(samples: &[f64]) -> Result<Self, ParameterError> {
        if samples.is_empty() {
            return Err(ParameterError::Empty { name: "samples".into(), min: 1 });
        }
        check::all_finite("samples", samples)?;
        let summary = Summary::of_values(samples);
        check::representable("mean", summary.mean, samples)?;
        check::representable("mean square", summary.rms, samples)?;
        Ok(summary)
    }

    /// The figures of a channel with this mean, standard deviation, minimum and maximum, in the unit of the
    /// channel.
    ///
    /// # Errors
    /// A figure that is not finite or contradicts the others.
    ///
    /// ```
    /// let sine = gear_dynamics::analysis::Summary::of_figures(0.0, 0.5f64.sqrt(), [-1.0, 1.0])?;
    /// assert_eq!((sine.rms, sine.peak_to_peak()), (0.5f64.sqrt(), 2.0));
    /// # Ok::<(), gear_dynamics::ParameterError>(())
    /// ```
    pub fn of_figures(mean: f64, deviation: f64, [min, max]: [f64; 2]) -> Result<Self, ParameterError> {
        let summary = Summary { mean, rms: mean.hypot(deviation), min, max, deviation };
        summary.check("the channel")?;
        // Values between two extremes deviate most if they are the extremes.
        let most = ((max - mean).max(0.0) * (mean - min).max(0.0)).sqrt();
        if deviation > most + 1e-9 * min.abs().max(max.abs()) {
            let (name, must) =
                ("deviation of the channel".into(), format!("be at most {most:?}, by the extremes"));
            return Err(ParameterError::Wrong { name, value: deviation, must });
        }
        Ok(summary)
    }

    /// The figures of equally spaced samples, which may overflow.
    pub(crate) fn of_values(samples: &[f64]) -> Self {
        let n = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / n;
        Summary {
            mean,
            rms: (samples.iter().map(|x| x * x).sum::<f64>() / n).sqrt(),
            deviation: (samples.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n).sqrt(),
            min: samples.iter().copied().fold(f64::INFINITY, f64::min),
            max: samples.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }

    pub(crate) fn of_moments(moments: &Moments, [min, max]: [f64; 2]) -> Self {
        let (mean, deviation) = (moments.mean(), moments.deviation());
        Summary { mean, rms: moments.mean_square().sqrt(), min, max, deviation }
    }

    /// Checks that the figures can be those of one channel.
    ///
    /// # Errors
    /// The figure that contradicts the others.
    pub(crate) fn check(&self, of: &str) -> Result<(), ParameterError> {
        let Summary { mean, rms, min, max, deviation } = *self;
        check::all_finite(&format!("figures of {of}"), &[mean, rms, min, max, deviation])?;
        // Means are sums of rounded products.
        let slack = 1e-6 * min.abs().max(max.abs());
        let wrong = |name: &str, value: f64, must: String| {
            Err(ParameterError::Wrong { name: format!("{name} of {of}"), value, must })
        };
        if min > max {
            return wrong("min", min, format!("be at most {max:?}, the max"));
        }
        if !(min - slack..=max + slack).contains(&mean) {
            return wrong("mean", mean, format!("be within {min:?} and {max:?}, the extremes"));
        }
        for (name, value) in [("rms", rms), ("deviation", deviation)] {
            if value < 0.0 {
                return Err(ParameterError::Negative { name: format!("{name} of {of}"), value });
            }
        }
        let square = mean.hypot(deviation);
        // Squares below 1e-308 are 0.
        if (rms - square).abs() > slack.max(1e-150) {
            return wrong("rms", rms, format!("be {square:?}, by its mean and its deviation"));
        }
        Ok(())
    }

    /// Peak-to-peak value max - min, the ppv of Liu 2021.
    pub fn peak_to_peak(&self) -> f64 {
        self.max - self.min
    }
}
