//! The stored form of the orbit of a shooting.

use crate::error::{ParameterError, check};
use crate::model::state::State;
use crate::numeric::not_finite::{AnyNumber, numbers, plain};
use crate::ode::budget::Budget;
use crate::periodic::flow::flow_method::FlowMethod;
use crate::periodic::multipliers::Multipliers;
use crate::periodic::shooting::shooting_orbit::ShootingOrbit;
use nalgebra::DMatrix;
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
            error: AnyNumber(self.error()),
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

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "ShootingOrbit")]
struct StoredShootingOrbit {
    states: Vec<State>,
    /// Time at the end of the orbit.
    end: f64,
    multiple: usize,
    least: usize,
    scale: Vec<f64>,
    range: Vec<f64>,
    drift: [Vec<f64>; 2],
    /// Column by column.
    monodromy: Vec<AnyNumber>,
    multipliers: Multipliers,
    first: AnyNumber,
    corrections: Vec<AnyNumber>,
    crossings: u64,
    flow: f64,
    method: FlowMethod,
}

impl Serialize for ShootingOrbit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let stored = StoredShootingOrbit {
            states: self.states.clone(),
            end: self.end,
            multiple: self.multiple,
            least: self.least,
            scale: self.scale.clone(),
            range: self.range.clone(),
            drift: self.drift.clone(),
            monodromy: numbers(self.monodromy.as_slice()),
            multipliers: self.multipliers.clone(),
            first: AnyNumber(self.first),
            corrections: numbers(&self.corrections),
            crossings: self.crossings,
            flow: self.flow,
            method: self.method,
        };
        stored.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for ShootingOrbit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        StoredShootingOrbit::deserialize(deserializer)?.read().map_err(D::Error::custom)
    }
}

impl StoredShootingOrbit {
    /// The orbit, if all parts fit together.
    fn read(self) -> Result<ShootingOrbit, ParameterError> {
        let Some(first) = self.states.first() else {
            return Err(ParameterError::Empty { name: "states of the orbit".into(), min: 1 });
        };
        let dof = first.q.len();
        let mut before = f64::NEG_INFINITY;
        for (i, state) in self.states.iter().enumerate() {
            state.check(dof)?;
            if state.t <= before {
                let (name, value) = (format!("time of state {i}"), state.t);
                return Err(ParameterError::OutOfRange { name, value, allowed: "above the time before it" });
            }
            before = state.t;
        }
        check::finite("end of the orbit", self.end)?;
        check::positive("end of the orbit less the time of its last state", self.end - before)?;
        check::tolerance("flow_tolerance", self.flow)?;
        for (name, value) in [("multiple", self.multiple), ("least multiple", self.least)] {
            if value == 0 {
                return Err(ParameterError::TooFew { name: name.into(), value, min: 1 });
            }
        }
        check::length("scales", self.scale.len(), 2 * dof)?;
        check::length("ranges", self.range.len(), 2 * dof)?;
        check::length("drift of the coordinates", self.drift[0].len(), dof)?;
        check::length("drift of the velocities", self.drift[1].len(), dof)?;
        check::length("monodromy matrix", self.monodromy.len(), 4 * dof * dof)?;
        for scale in &self.scale {
            check::positive("scale", *scale)?;
        }
        Ok(ShootingOrbit {
            states: self.states,
            end: self.end,
            multiple: self.multiple,
            least: self.least,
            scale: self.scale,
            range: self.range,
            drift: self.drift,
            monodromy: DMatrix::from_vec(2 * dof, 2 * dof, plain(self.monodromy)),
            multipliers: self.multipliers,
            first: self.first.0,
            corrections: plain(self.corrections),
            crossings: self.crossings,
            flow: self.flow,
            method: self.method,
            budget: Budget::new(),
        })
    }
}
