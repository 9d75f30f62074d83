//! The stored form of the orbit of a balance.

use crate::error::{ParameterError, check};
use crate::periodic::{BalanceNote, FourierOrbit, Harmonics};
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
        StoredHarmonics { orders: self.orders().to_vec(), periods: self.period_multiple() }
            .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Harmonics {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let StoredHarmonics { orders, periods } = StoredHarmonics::deserialize(deserializer)?;
        Harmonics::of_orders(&orders).and_then(|h| h.with_period_multiple(periods)).map_err(D::Error::custom)
    }
}

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "FourierOrbit")]
struct StoredFourierOrbit {
    harmonics: Harmonics,
    period: f64,
    /// One list for each coordinate.
    coefficients: Vec<Vec<f64>>,
    mean_acceleration: Vec<f64>,
    /// Absent in files of versions without it.
    #[serde(default)]
    mean_velocity: Vec<f64>,
    notes: Vec<BalanceNote>,
    iterations: usize,
    evaluations: usize,
    #[serde(with = "crate::numeric::not_finite::number")]
    residual: f64,
}

impl Serialize for FourierOrbit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let stored = StoredFourierOrbit {
            harmonics: self.harmonics().clone(),
            period: self.period(),
            coefficients: (0..self.dof()).map(|j| self.coefficients(j).to_vec()).collect(),
            mean_acceleration: self.mean_acceleration.clone(),
            mean_velocity: self.mean_velocity.clone(),
            notes: self.notes.clone(),
            iterations: self.iterations,
            evaluations: self.evaluations,
            residual: self.residual,
        };
        stored.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for FourierOrbit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let stored = StoredFourierOrbit::deserialize(deserializer)?;
        let orbit = FourierOrbit::new(&stored.harmonics, stored.period, &stored.coefficients);
        let orbit = orbit.map_err(D::Error::custom)?;
        let (mean_acceleration, mut mean_velocity) = (stored.mean_acceleration, stored.mean_velocity);
        if mean_velocity.is_empty() {
            mean_velocity.resize(orbit.dof(), 0.0);
        }
        for (name, list) in [("mean acceleration", &mean_acceleration), ("mean velocity", &mean_velocity)] {
            check::length(format!("list of the {name}"), list.len(), orbit.dof())
                .map_err(D::Error::custom)?;
            check::quantities(name, list).map_err(D::Error::custom)?;
        }
        // The residual of a series that no balance solved is NaN.
        if stored.residual < 0.0 {
            let (name, value) = ("residual".into(), stored.residual);
            return Err(D::Error::custom(ParameterError::Negative { name, value }));
        }
        Ok(FourierOrbit {
            mean_acceleration,
            mean_velocity,
            notes: stored.notes,
            iterations: stored.iterations,
            evaluations: stored.evaluations,
            residual: stored.residual,
            ..orbit
        })
    }
}
