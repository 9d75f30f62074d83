//! The stored forms of states and of figures: each is checked when it is read.

use crate::analysis::ContactStatistics;
use crate::certify::Disc;
use crate::error::{ParameterError, check};
use crate::model::State;
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
