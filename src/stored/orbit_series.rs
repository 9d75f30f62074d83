//! The stored form of the orbit of a balance.

use crate::error::check;
use crate::periodic::balance::fourier_orbit::FourierOrbit;
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::note::BalanceNote;
use crate::periodic::balance::series::harmonics::Harmonics;
use crate::stored::not_finite::AnyNumber;
use serde::de::{Deserialize, Deserializer, Error};
use serde::ser::{Serialize, Serializer};

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "Harmonics")]
struct StoredHarmonics {
    orders: Vec<usize>,
    /// Number of periods of the model in one base period.
    periods: usize,
}

impl Serialize for Harmonics {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        StoredHarmonics { orders: self.orders().to_vec(), periods: self.periods() }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Harmonics {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let StoredHarmonics { orders, periods } = StoredHarmonics::deserialize(deserializer)?;
        Harmonics::list(&orders).and_then(|h| h.over_periods(periods)).map_err(D::Error::custom)
    }
}

/// A note whose numbers need not be finite.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "BalanceNote")]
enum StoredNote {
    Unresolved { highest: usize, needed: AnyNumber },
    Aliased { samples: usize, error: AnyNumber },
    Coarse { integrals: Integrals, share: AnyNumber },
    MeanAcceleration { share: AnyNumber },
    Differences,
}

impl From<&BalanceNote> for StoredNote {
    fn from(note: &BalanceNote) -> Self {
        match *note {
            BalanceNote::Unresolved { highest, needed } => {
                StoredNote::Unresolved { highest, needed: AnyNumber(needed) }
            }
            BalanceNote::Aliased { samples, error } => {
                StoredNote::Aliased { samples, error: AnyNumber(error) }
            }
            BalanceNote::Coarse { integrals, share } => {
                StoredNote::Coarse { integrals, share: AnyNumber(share) }
            }
            BalanceNote::MeanAcceleration { share } => {
                StoredNote::MeanAcceleration { share: AnyNumber(share) }
            }
            BalanceNote::Differences => StoredNote::Differences,
        }
    }
}

impl From<StoredNote> for BalanceNote {
    fn from(note: StoredNote) -> Self {
        match note {
            StoredNote::Unresolved { highest, needed } => {
                BalanceNote::Unresolved { highest, needed: needed.0 }
            }
            StoredNote::Aliased { samples, error } => BalanceNote::Aliased { samples, error: error.0 },
            StoredNote::Coarse { integrals, share } => BalanceNote::Coarse { integrals, share: share.0 },
            StoredNote::MeanAcceleration { share } => BalanceNote::MeanAcceleration { share: share.0 },
            StoredNote::Differences => BalanceNote::Differences,
        }
    }
}

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "FourierOrbit")]
struct StoredFourierOrbit {
    harmonics: Harmonics,
    span: f64,
    /// One list for each coordinate.
    coefficients: Vec<Vec<f64>>,
    mean_acceleration: Vec<f64>,
    notes: Vec<StoredNote>,
    iterations: usize,
    evaluations: usize,
    residual: AnyNumber,
}

impl Serialize for FourierOrbit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let stored = StoredFourierOrbit {
            harmonics: self.harmonics().clone(),
            span: self.span(),
            coefficients: (0..self.dof()).map(|j| self.coefficients(j).to_vec()).collect(),
            mean_acceleration: self.mean_acceleration.clone(),
            notes: self.notes.iter().map(StoredNote::from).collect(),
            iterations: self.iterations,
            evaluations: self.evaluations,
            residual: AnyNumber(self.residual),
        };
        stored.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for FourierOrbit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let stored = StoredFourierOrbit::deserialize(deserializer)?;
        let orbit = FourierOrbit::new(&stored.harmonics, stored.span, &stored.coefficients);
        let orbit = orbit.map_err(D::Error::custom)?;
        let mean_acceleration = stored.mean_acceleration;
        check::length("mean accelerations", mean_acceleration.len(), orbit.dof())
            .map_err(D::Error::custom)?;
        check::quantities("mean acceleration", &mean_acceleration).map_err(D::Error::custom)?;
        Ok(FourierOrbit {
            mean_acceleration,
            notes: stored.notes.into_iter().map(BalanceNote::from).collect(),
            iterations: stored.iterations,
            evaluations: stored.evaluations,
            residual: stored.residual.0,
            ..orbit
        })
    }
}
