//! The stored forms of states and of figures: each is checked when it is read.

use crate::analysis::summary::RawSummary;
use crate::analysis::{ContactStatistics, Summary};
use crate::certify::{CertifiedContact, CertifiedFigures, Disc, Interval};
use crate::error::{ParameterError, check};
use crate::model::State;
use crate::numeric::not_finite::AnyNumber;
use crate::sweep::{Attractor, SobolIndex};
use serde::de::{Deserialize, Deserializer, Error};

/// Reads a stored form and checks it.
fn checked<'de, F: Deserialize<'de>, T, D: Deserializer<'de>>(
    deserializer: D,
    check: impl FnOnce(F) -> Result<T, ParameterError>,
) -> Result<T, D::Error> {
    check(F::deserialize(deserializer)?).map_err(D::Error::custom)
}

#[derive(serde::Deserialize)]
#[serde(rename = "State", deny_unknown_fields)]
struct StoredState {
    t: f64,
    q: Vec<f64>,
    v: Vec<f64>,
}

impl<'de> Deserialize<'de> for State {
    /// As many velocities as coordinates.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        checked(deserializer, |StoredState { t, q, v }: StoredState| {
            check::length("velocities of the state", v.len(), q.len())?;
            Ok(State { t, q, v })
        })
    }
}

#[derive(serde::Deserialize)]
#[serde(rename = "ContactStatistics", deny_unknown_fields)]
struct StoredContact {
    time: [f64; 3],
    impacts: [u64; 2],
}

impl<'de> Deserialize<'de> for ContactStatistics {
    /// No time is negative, and their sum is finite.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        checked(deserializer, |StoredContact { time, impacts }: StoredContact| {
            time.iter().try_for_each(|time| check::not_negative("time of a contact", *time).map(drop))?;
            Ok(ContactStatistics { time, impacts })
        })
    }
}

#[derive(serde::Deserialize)]
#[serde(rename = "Disc")]
struct StoredDisc {
    re: f64,
    im: f64,
    radius: f64,
}

impl<'de> Deserialize<'de> for Disc {
    /// The radius is not negative.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        checked(deserializer, |StoredDisc { re, im, radius }: StoredDisc| {
            check::all_finite("centre of a disc", &[re, im])?;
            check::not_negative("radius of a disc", radius)?;
            Ok(Disc { re, im, radius })
        })
    }
}

impl<'de> Deserialize<'de> for Summary {
    /// The figures can be those of one channel.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        checked(deserializer, |stored: RawSummary| {
            let summary = Summary::from(stored);
            summary.check("the channel")?;
            Ok(summary)
        })
    }
}

#[derive(serde::Deserialize)]
#[serde(rename = "SobolIndex")]
struct StoredIndex {
    name: String,
    first: f64,
    first_error: AnyNumber,
    total: f64,
    total_error: AnyNumber,
}

impl<'de> Deserialize<'de> for SobolIndex {
    /// The indices are finite, the total one is not negative; an error may be infinite.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        checked(deserializer, |stored: StoredIndex| {
            let StoredIndex { name, first, first_error, total, total_error } = stored;
            check::finite("first-order index", first)?;
            check::not_negative("total index", total)?;
            let errors = [("first-order", first_error.0), ("total", total_error.0)];
            for (of, value) in errors {
                let name = format!("standard error of the {of} index");
                if value.is_nan() {
                    return Err(ParameterError::NotFinite { name, value });
                }
                if value < 0.0 {
                    return Err(ParameterError::Negative { name, value });
                }
            }
            Ok(SobolIndex { name, first, first_error: first_error.0, total, total_error: total_error.0 })
        })
    }
}

#[derive(serde::Deserialize)]
#[serde(rename = "Attractor")]
struct StoredAttractor {
    period_multiple: Option<usize>,
    states: Vec<Vec<f64>>,
    rows: usize,
}

impl<'de> Deserialize<'de> for Attractor {
    /// A motion that repeats has one strobed state for each period, any other none.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        checked(deserializer, |StoredAttractor { period_multiple, states, rows }: StoredAttractor| {
            if let Some(multiple) = period_multiple {
                check::at_least("period_multiple", multiple, 1)?;
            }
            check::length("strobed states of the attractor", states.len(), period_multiple.unwrap_or(0))?;
            check::at_least("rows of the attractor", rows, 1)?;
            for state in &states {
                check::all_finite("strobed state", state)?;
                check::length("numbers of a strobed state", state.len(), states[0].len())?;
            }
            Ok(Attractor { period_multiple, states, rows })
        })
    }
}

#[derive(serde::Deserialize)]
#[serde(rename = "CertifiedContact")]
struct StoredCertifiedContact {
    mean_force: Interval,
    loss_fraction: Interval,
}

impl<'de> Deserialize<'de> for CertifiedContact {
    /// A share of the time is possible.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        checked(deserializer, |stored: StoredCertifiedContact| {
            let StoredCertifiedContact { mean_force, loss_fraction } = stored;
            let [low, high] = [loss_fraction.low(), loss_fraction.high()];
            if low > 1.0 || high < 0.0 {
                let (name, value) =
                    ("share of the time in the gap".into(), if low > 1.0 { low } else { high });
                return Err(ParameterError::OutOfRange { name, value, allowed: "[0, 1]" });
            }
            Ok(CertifiedContact { mean_force, loss_fraction })
        })
    }
}

#[derive(serde::Deserialize)]
#[serde(rename = "CertifiedFigures")]
struct StoredCertifiedFigures {
    peak_to_peak: Vec<Interval>,
    contacts: Vec<CertifiedContact>,
}

impl<'de> Deserialize<'de> for CertifiedFigures {
    /// Each velocity has its coordinate; no peak-to-peak value is negative.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        checked(deserializer, |stored: StoredCertifiedFigures| {
            let StoredCertifiedFigures { peak_to_peak, contacts } = stored;
            let coordinates = peak_to_peak.len() / 2;
            check::length("peak-to-peak values", peak_to_peak.len(), 2 * coordinates)?;
            if let Some(value) = peak_to_peak.iter().map(|x| x.high()).find(|high| *high < 0.0) {
                return Err(ParameterError::Negative { name: "peak-to-peak value".into(), value });
            }
            Ok(CertifiedFigures { peak_to_peak, contacts })
        })
    }
}
