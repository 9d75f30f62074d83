//! The stored form of the orbit of a shooting.

use crate::error::{ParameterError, check};
use crate::numeric::equations::balancing::balancing;
use crate::numeric::not_finite::AnyNumber;
use crate::ode::Budget;
use crate::periodic::shooting::multiple::MAX_COUNT;
use crate::periodic::shooting::shooting_orbit::OrbitParts;
use crate::periodic::{Multipliers, ShootingOrbit};
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
            error: AnyNumber(self.value_error()),
        }
        .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Multipliers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let StoredMultipliers { values, error } = StoredMultipliers::deserialize(deserializer)?;
        let values: Vec<Complex64> = values.into_iter().map(|[re, im]| Complex64::new(re.0, im.0)).collect();
        check_values(&values, error.0).map_err(D::Error::custom)?;
        Ok(Multipliers::new(values, error.0))
    }
}

/// Whether these can be the multipliers of an orbit of real numbers.
pub(crate) fn check_values(values: &[Complex64], error: f64) -> Result<(), ParameterError> {
    let name = || "error of the multipliers".to_owned();
    if error.is_nan() {
        return Err(ParameterError::NotFinite { name: name(), value: error });
    }
    if error < 0.0 {
        return Err(ParameterError::Negative { name: name(), value: error });
    }
    // Multipliers that were not computed have an infinite error.
    if values.is_empty() && error < f64::INFINITY {
        return Err(ParameterError::Empty { name: "multipliers".into(), min: 1 });
    }
    for (i, value) in values.iter().enumerate() {
        check::finite(format!("real part of multiplier {i}"), value.re)?;
        check::finite(format!("imaginary part of multiplier {i}"), value.im)?;
    }
    // Each multiplier is the conjugate of one of its own: a double one has a double conjugate.
    let mut left = values.to_vec();
    for (i, value) in values.iter().enumerate() {
        let off = |other: &Complex64| (other - value.conj()).norm();
        let nearest = (0..left.len()).min_by(|&a, &b| off(&left[a]).total_cmp(&off(&left[b])));
        match nearest.filter(|&nearest| off(&left[nearest]) <= SLACK * value.norm()) {
            Some(nearest) => drop(left.swap_remove(nearest)),
            None => {
                let must = "belong to a pair of conjugates".into();
                let name = format!("imaginary part of multiplier {i}");
                return Err(ParameterError::Wrong { name, value: value.im, must });
            }
        }
    }
    Ok(())
}

/// Rounding of what is derived, as a share of the largest number in it `[1]`.
const SLACK: f64 = 1e-6;

/// Largest rounding error of an eigenvalue, as a share of the norm of its balanced matrix `[1]`. Eigenvalues
/// whose eigenvectors nearly coincide have such errors.
const DEFECTIVE: f64 = 1e-4;

/// The norm of a balanced matrix. The eigenvalues are those of the matrix, but a large entry that acts little
/// on them does not count.
fn balanced_norm(matrix: &DMatrix<f64>) -> f64 {
    let units = balancing(matrix);
    DMatrix::from_fn(units.len(), units.len(), |i, j| matrix[(i, j)] * (units[j] / units[i])).norm()
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
        check::scale("period of the orbit", self.end - self.states[0].t)?;
        for (name, value) in [("period_multiple", self.multiple), ("least_period_multiple", self.least)] {
            check::at_least(name, value, 1)?;
            check::count(name, &[value], MAX_COUNT)?;
        }
        if !self.multiple.is_multiple_of(self.least) {
            let (name, value) = ("least_period_multiple".into(), self.least as f64);
            let must = format!("divide {}, the period multiple", self.multiple);
            return Err(ParameterError::Wrong { name, value, must });
        }
        check::length("scales", self.scale.len(), 2 * dof)?;
        check::length("ranges", self.range.len(), 2 * dof)?;
        check::length("drift of the coordinates", self.drift[0].len(), dof)?;
        check::length("drift of the velocities", self.drift[1].len(), dof)?;
        check::length("rows of the monodromy matrix", self.monodromy.nrows(), 2 * dof)?;
        self.scale.iter().try_for_each(|scale| check::positive("scale", *scale).map(drop))?;
        self.range.iter().try_for_each(|range| check::not_negative("range", *range).map(drop))?;
        self.drift.iter().try_for_each(|drift| check::all_finite("drift", drift))?;
        let corrections = self.corrections.iter().chain([&self.first]);
        if let Some(value) = corrections.copied().find(|correction| *correction < 0.0) {
            return Err(ParameterError::Negative { name: "correction".into(), value });
        }
        self.check_multipliers()
    }

    /// Whether the multipliers are the eigenvalues of the monodromy matrix without a pair 1, 1 for each rigid
    /// mode: their number, their sum, which is the trace less that of these pairs, and each of them.
    fn check_multipliers(&self) -> Result<(), ParameterError> {
        let (values, all) = (self.multipliers.values(), self.monodromy.nrows());
        let rigid = all.checked_sub(values.len()).filter(|rigid| rigid.is_multiple_of(2));
        let Some(rigid) = rigid else {
            let name = "multipliers of the orbit".into();
            return Err(ParameterError::Length { name, expected: all, found: values.len() });
        };
        let diagonal = self.monodromy.diagonal();
        let size = rigid as f64 + diagonal.abs().sum() + values.iter().map(|x| x.norm()).sum::<f64>();
        let found = values.iter().map(|x| x.re).sum::<f64>() + rigid as f64;
        if size.is_finite() && (found - diagonal.sum()).abs() > SLACK * size {
            let name = "sum of the multipliers and of the pairs 1, 1 of the rigid modes".into();
            return Err(ParameterError::Inconsistent { name, found, expected: diagonal.sum() });
        }
        // Of a matrix without finite eigenvalues none were computed.
        let Ok(eigenvalues) = Multipliers::of_monodromy(&self.monodromy, 0.0) else { return Ok(()) };
        let most = DEFECTIVE * balanced_norm(&self.monodromy);
        let value = self.multipliers.distance(&eigenvalues);
        if value > most {
            let name = "distance of a multiplier from an eigenvalue of the monodromy matrix".into();
            return Err(ParameterError::Wrong { name, value, must: format!("be at most {most:?}") });
        }
        Ok(())
    }
}
