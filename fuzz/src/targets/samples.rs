//! Evaluation of samples: summaries, spectra, distributions.

use crate::case::{Case, Run, all_finite, finite, holds};

use gear_dynamics::analysis::{Spectrum, Summary, Welch, Window};
use gear_dynamics::sweep::{Distribution, Proportion};

/// Mean, RMS, extremes and deviation of any samples.
pub fn summaries(case: &mut Case) -> Run {
    let (length, size) = (1 + case.below(50), case.number(1.0));
    let samples = case.list(length, size);
    case.note(|| format!("samples {samples:?}"));
    let summary = Summary::of_samples(&samples)?;
    case.note(|| format!("{summary:?}"));
    all_finite("summary", &[summary.mean, summary.rms, summary.min, summary.max])?;
    all_finite("range and deviation", &[summary.peak_to_peak(), summary.deviation])?;
    // Squares of values below 1e-150 underflow.
    let slack = 1e-9 * summary.min.abs().max(summary.max.abs()) + 1e-150;
    holds(summary.mean >= summary.min - slack && summary.mean <= summary.max + slack, || {
        format!("{summary:?}")
    })?;
    holds(summary.rms <= summary.min.abs().max(summary.max.abs()) + slack, || format!("{summary:?}"))?;
    holds(summary.deviation <= summary.peak_to_peak() + 1e-6 * slack + f64::MIN_POSITIVE, || {
        format!("deviation {} of {summary:?}", summary.deviation)
    })
}

/// Amplitudes and orders of any samples in any window.
pub fn spectra(case: &mut Case) -> Run {
    let window =
        case.pick(&[Window::Rectangular, Window::Hann, Window::Hamming, Window::Blackman, Window::FlatTop]);
    let n = case.effort(64);
    all_finite("window", &window.coefficients(n)?)?;
    let (length, size) = (1 + case.below(100), case.number(1.0));
    let (samples, spacing) = (case.list(length, size), case.number(0.1));
    case.note(|| format!("spacing {spacing:e}, {window:?}, samples {samples:?}"));
    let spectrum = Spectrum::new(&samples, spacing, window)?;
    all_finite("frequencies", spectrum.frequencies())?;
    all_finite("amplitudes", spectrum.amplitudes())?;
    all_finite("phases", spectrum.phases())?;
    let base = case.number(1.0);
    all_finite("orders", &spectrum.orders(base)?)?;
    holds(
        spectrum.decibels(base)?.iter().all(|level| level.is_finite() || *level == f64::NEG_INFINITY),
        || "a level is infinite or not a number".into(),
    )
}

/// Averaged densities of any samples, and their export.
pub fn densities(case: &mut Case) -> Run {
    let window =
        case.pick(&[Window::Rectangular, Window::Hann, Window::Hamming, Window::Blackman, Window::FlatTop]);
    let (length, size) = (1 + case.below(100), case.number(1.0));
    let (samples, spacing) = (case.list(length, size), case.number(0.1));
    let (segment, overlap) = (case.count(16), case.number(0.5));
    case.note(|| format!("{segment}, overlap {overlap:e}, spacing {spacing:e}, {window:?}, {samples:?}"));
    let welch = Welch::new(segment).overlap(overlap).window(window);
    let welch = if case.chance(0.5) { welch.centred() } else { welch };
    let density = welch.density(&samples, spacing)?;
    all_finite("frequencies", density.frequencies())?;
    all_finite("densities", density.values())?;
    all_finite("width of a line", &[density.noise_bandwidth()])?;
    holds(density.amplitudes().iter().all(|a| *a >= 0.0), || "an amplitude is not a number".into())?;
    holds(density.decibels(case.number(1.0))?.iter().all(|level| !level.is_nan()), || {
        "a level is not a number".into()
    })?;
    let table = density.table();
    let mut text = Vec::new();
    holds(table.write_csv(&mut text).is_ok() && table.len() == segment / 2 + 1, || "no table".into())
}

/// Moments and quantiles; values that are not finite are counted separately.
pub fn distributions(case: &mut Case) -> Run {
    let (length, size) = (1 + case.below(200), case.number(1.0));
    let values = case.list(length, size);
    case.note(|| format!("values {values:?}"));
    let mut all = Distribution::of_samples(values.iter().copied());
    all.add(case.number(size));
    let (p, spans) = (case.number(0.5), case.count(10).min(1 << 40));
    holds(all.count() + all.not_finite() == values.len() as u64 + 1, || {
        format!("{} + {}", all.count(), all.not_finite())
    })?;
    if all.count() == 0 {
        return Ok(());
    }
    all_finite("mean and extremes", &[all.mean(), all.min(), all.max(), all.resolution()])?;
    if all.count() > 1 {
        all_finite("variance, error", &[all.variance()?, all.standard_error()])?;
        all_finite("confidence", &all.confidence(0.95)?)?;
    }
    let (share, level) = (case.number(0.5), case.number(0.5));
    if let Some([low, high]) = case.accept(all.quantile_confidence(share, level)) {
        holds(low <= high, || format!("{low} .. {high} at {share}, {level}"))?;
    }
    let quantile = all.quantile(p)?;
    finite("quantile", quantile)?;
    holds((all.min()..=all.max()).contains(&quantile), || {
        format!("quantile {p} is {quantile}, of {} .. {}", all.min(), all.max())
    })?;
    let histogram = all.histogram(spans)?;
    let total: u64 = histogram.iter().map(|span| span.count).sum();
    histogram.iter().try_for_each(|span| finite("middle of a span", span.middle))?;
    holds(spans == 0 || total == all.count(), || {
        format!("histogram of {spans} spans counts {total} of {}", all.count())
    })
}

/// Shares of trials and their intervals.
pub fn proportions(case: &mut Case) -> Run {
    let trials = case.count(50) as u64;
    let hits = if case.hostile() { case.count(10) as u64 } else { (case.unit() * trials as f64) as u64 };
    let level = case.number(0.5);
    case.note(|| format!("{hits} of {trials} at {level:e}"));
    let seen = Proportion::new(hits, trials)?;
    let ([low, high], share) = (seen.confidence(level)?, seen.share());
    holds(0.0 <= low && low <= share && share <= high && high <= 1.0, || {
        format!("{low} .. {high} of {share}")
    })
}
