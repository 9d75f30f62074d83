//! The check of the figures of a stored row: whether they can be those of one run.

use crate::analysis::Summary;
use crate::error::{ParameterError, check};
use crate::stored::shooting::check_values;
use crate::sweep::rows::layout::Layout;
use num_complex::Complex64;

/// Rounding of contact times, as a share of the measured time `[1]`: sums over all steps of a run.
const SLACK: f64 = 1e-6;

type Checked = Result<(), ParameterError>;

/// Checks the groups and the strobed periods of a row.
///
/// # Errors
/// The figure that contradicts the others.
pub(crate) fn check_figures(layout: &Layout, row: &[f64]) -> Checked {
    let [multiple, change, settled, margin, scatter] = *Layout::group(row, Layout::HEAD);
    whole("period multiple", multiple)?;
    distance("change", change)?;
    whole("number of settling periods", settled)?;
    distance("margin to grazing", margin)?;
    distance("scatter", scatter)?;
    for channel in 0..layout.channels {
        let [mean, rms, min, max, deviation] = *Layout::group(row, layout.channel(channel));
        Summary { mean, rms, min, max, deviation }.check(&format!("channel {channel}"))?;
    }
    for contact in 0..layout.contacts {
        let [times @ .., on_lower, on_upper] = *Layout::group(row, layout.contact(contact));
        check_times(contact, times)?;
        whole(format!("number of impacts on the lower flank of contact {contact}"), on_lower)?;
        whole(format!("number of impacts on the upper flank of contact {contact}"), on_upper)?;
    }
    for period in 0..layout.strobes {
        let (extremes, state) =
            row[layout.strobe(period)..layout.strobe(period + 1)].split_at(2 * layout.channels);
        check::all_finite("strobed state", state)?;
        for (channel, &[min, max]) in extremes.as_chunks().0.iter().enumerate() {
            check::all_finite("extremes of a strobed period", &[min, max])?;
            if min > max {
                let name = format!("minimum of channel {channel} in strobed period {period}");
                let must = format!("be at most {max:?}, the maximum");
                return Err(ParameterError::Wrong { name, value: min, must });
            }
        }
    }
    Ok(())
}

/// Checks exponent and multipliers. `failed`: whether the row has an error of its exponent or its
/// multipliers.
///
/// # Errors
/// The figure that contradicts the others.
pub(crate) fn check_exponents(layout: &Layout, row: &[f64], failed: bool) -> Checked {
    if let &[exponent, error] = &row[layout.exponent()..][..layout.exponents] {
        if exponent.is_nan() && !failed {
            return Err(ParameterError::NotFinite { name: "Lyapunov exponent".into(), value: exponent });
        }
        if error < 0.0 {
            let name = "standard error of the Lyapunov exponent".into();
            return Err(ParameterError::Negative { name, value: error });
        }
    }
    if let Some((error, parts)) = row[layout.multiplier()..][..layout.multipliers].split_last() {
        let parts = parts.as_chunks().0.iter().filter(|[re, im]| !(re.is_nan() && im.is_nan()));
        let values: Vec<Complex64> = parts.map(|&[re, im]| Complex64::new(re, im)).collect();
        if !values.is_empty() {
            check_values(&values, *error)?;
        }
    }
    Ok(())
}

/// The shares of time on the lower flank, in the gap and on the upper flank.
fn check_times(contact: usize, times: [f64; 3]) -> Checked {
    for (place, time) in ["on the lower flank", "in the gap", "on the upper flank"].iter().zip(times) {
        let name = || format!("share of time {place} of contact {contact}");
        check::finite(name(), time)?;
        if !(-SLACK..=1.0 + SLACK).contains(&time) {
            return Err(ParameterError::OutOfRange { name: name(), value: time, allowed: "[0, 1]" });
        }
    }
    let sum: f64 = times.iter().sum();
    if (sum - 1.0).abs() > SLACK {
        let name = format!("sum of the shares of time of contact {contact}");
        return Err(ParameterError::Inconsistent { name, found: sum, expected: 1.0 });
    }
    Ok(())
}

/// A count: a whole number that is not negative.
fn whole(name: impl Into<String>, value: f64) -> Checked {
    let name = name.into();
    if value < 0.0 {
        return Err(ParameterError::Negative { name, value });
    }
    if check::finite(name.as_str(), value)?.fract() != 0.0 {
        return Err(ParameterError::Wrong { name, value, must: "be a whole number".into() });
    }
    Ok(())
}

/// A distance, which is infinite where it is not known.
fn distance(name: &str, value: f64) -> Checked {
    if value.is_nan() {
        return Err(ParameterError::NotFinite { name: name.into(), value });
    }
    if value < 0.0 {
        return Err(ParameterError::Negative { name: name.into(), value });
    }
    Ok(())
}
