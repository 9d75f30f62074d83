//! Names of bodies.

use crate::trains::parts::collection::Parts;
use crate::trains::train_error::TrainError;
use std::collections::{HashMap, HashSet};

/// The places of the bodies by name.
pub(crate) struct Names(HashMap<String, usize>);

impl Names {
    /// Checks that no two parts have the same name.
    pub(crate) fn of<N>(parts: &Parts<N>) -> Result<Self, TrainError> {
        let others = (parts.shafts.iter().map(|shaft| &shaft.name))
            .chain(parts.meshes.iter().map(|mesh| &mesh.0))
            .chain(parts.torques.iter().map(|torque| &torque.name));
        let mut seen = HashSet::new();
        for name in parts.bodies.iter().map(|body| &body.0).chain(others) {
            if !seen.insert(name) || name == "speed" {
                return Err(TrainError::DuplicateName { name: name.clone() });
            }
        }
        Ok(Names(parts.bodies.iter().enumerate().map(|(i, body)| (body.0.clone(), i)).collect()))
    }

    /// The place of a body that `part` refers to.
    pub(crate) fn place(&self, part: &str, body: &str) -> Result<usize, TrainError> {
        self.0.get(body).copied().ok_or_else(|| {
            let mut known: Vec<&str> = self.0.keys().map(String::as_str).collect();
            known.sort_unstable();
            TrainError::NoSuchBody { part: part.into(), body: body.into(), known: known.join(", ") }
        })
    }

    /// The places of two bodies that a part joins.
    pub(crate) fn pair(&self, part: &str, ends: &[String; 2]) -> Result<[usize; 2], TrainError> {
        let [a, b] = [self.place(part, &ends[0])?, self.place(part, &ends[1])?];
        if a == b {
            return Err(TrainError::JoinsItself { part: part.into(), body: ends[0].clone() });
        }
        Ok([a, b])
    }

    /// The carrier of a planet, if the body is one.
    pub(crate) fn carrier<N>(&self, parts: &Parts<N>, body: usize) -> Result<Option<usize>, TrainError> {
        let (name, body) = &parts.bodies[body];
        let Some(place) = &body.place else { return Ok(None) };
        let carrier = self.place(name, &place.carrier)?;
        if parts.bodies[carrier].1.place.is_some() {
            return Err(TrainError::NestedCarrier { carrier: place.carrier.clone(), planet: name.clone() });
        }
        Ok(Some(carrier))
    }

    /// The carrier of a mesh: that of its planet or planets.
    pub(crate) fn carrier_of<N>(
        &self,
        parts: &Parts<N>,
        mesh: &str,
        [a, b]: [usize; 2],
    ) -> Result<Option<usize>, TrainError> {
        let [first, second] = [self.carrier(parts, a)?, self.carrier(parts, b)?];
        match (first, second) {
            (Some(one), Some(other)) if one != other => Err(TrainError::TwoCarriers { mesh: mesh.into() }),
            _ => Ok(first.or(second)),
        }
    }
}
