//! The stored form of the orbit of a shooting.

use crate::error::{ParameterError, check};
use crate::numeric::not_finite::AnyNumber;
use crate::ode::Budget;
use crate::periodic::shooting::shooting_orbit::OrbitParts;
use crate::periodic::{Multipliers, ShootingOrbit};
use num_complex::Complex64;
use serde::de::{Deserialize, Deserializer, Error};
use serde::ser::{Serialize, Serializer};

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "Multipliers")]
struct StoredMultipliers {
    /// Real and imaginary parts.
    values: Vec<[AnyNumber; 2]>,
    error: AnyNumber,
}

impl Serialize for Multipliers {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let parts = |z: &Complex64| [AnyNumber(z.re), AnyNumber(z.im)];
        StoredMultipliers {
            values: self.values().iter().map(parts).collect(),
            error: AnyNumber(self.value_error()),
        }
        .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Multipliers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let StoredMultipliers { values, error } = StoredMultipliers::deserialize(deserializer)?;
        let values = values.into_iter().map(|[re, im]| Complex64::new(re.0, im.0)).collect();
        Ok(Multipliers::new(values, error.0))
    }
}

impl Serialize for ShootingOrbit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.parts.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for ShootingOrbit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let parts = OrbitParts::deserialize(deserializer)?;
        parts.check().map_err(D::Error::custom)?;
        Ok(ShootingOrbit { parts, budget: Budget::new() })
    }
}

impl OrbitParts {
    /// Whether all parts fit together.
    fn check(&self) -> Result<(), ParameterError> {
        let Some(first) = self.states.first() else {
            return Err(ParameterError::Empty { name: "states of the orbit".into(), min: 1 });
        };
        let dof = first.q.len();
        let mut before = f64::NEG_INFINITY;
        for (i, state) in self.states.iter().enumerate() {
            state.check(dof)?;
            if state.t <= before {
                let (name, value) = (format!("time of state {i}"), state.t);
                let must = format!("be above {before:?}, the time of the state before it");
                return Err(ParameterError::Wrong { name, value, must });
            }
            before = state.t;
        }
        check::finite("end of the orbit", self.end)?;
        check::positive("end of the orbit less the time of its last state", self.end - before)?;
        check::tolerance("flow_tolerance", self.flow)?;
        for (name, value) in [("period_multiple", self.multiple), ("least_period_multiple", self.least)] {
            check::at_least(name, value, 1)?;
        }
        check::length("scales", self.scale.len(), 2 * dof)?;
        check::length("ranges", self.range.len(), 2 * dof)?;
        check::length("drift of the coordinates", self.drift[0].len(), dof)?;
        check::length("drift of the velocities", self.drift[1].len(), dof)?;
        check::length("rows of the monodromy matrix", self.monodromy.nrows(), 2 * dof)?;
        self.scale.iter().try_for_each(|scale| check::positive("scale", *scale).map(drop))
    }
}
