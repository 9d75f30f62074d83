//! What follows from the parts alone, checked.

use crate::contact::Nonlinearity;
use crate::trains::parts::collection::Parts;
use crate::trains::plan::phases::phases;
use crate::trains::plan::places::{Centres, Planets, centres, planets};
use crate::trains::plan::ranges;
use crate::trains::plan::topology::Topology;
use crate::trains::plan::turning::kinematics::Kinematics;
use crate::trains::plan::turning::orders::Orders;
use crate::trains::plan::turning::rotation::{Rotations, rotations};
use crate::trains::train_error::TrainError;

/// What follows from the parts of a train.
pub(crate) struct Plan<'p, N> {
    pub(crate) topology: Topology<'p, N>,
    pub(crate) kinematics: Kinematics,
    pub(crate) planets: Planets,
    pub(crate) centres: Centres,
    pub(crate) orders: Orders,
    pub(crate) rotations: Rotations,
    /// Phases of the meshes in [0, 1), in mesh cycles ahead of their waves.
    pub(crate) phases: Vec<f64>,
    /// Whether the coordinates are relative.
    pub(crate) relative: bool,
}

impl<'p, N: Nonlinearity> Plan<'p, N> {
    /// The plan of a train whose body `reference` has a given speed.
    pub(crate) fn of(parts: &'p Parts<N>, reference: &str) -> Result<Self, TrainError> {
        parts.fault.clone().map_or(Ok(()), Err)?;
        ranges::check(parts)?;
        let topology = Topology::of(parts, reference)?;
        topology.check()?;
        let kinematics = Kinematics::of(&topology)?;
        let planets = planets(&topology, &kinematics)?;
        let relative = topology.is_relative(&kinematics, &planets)?;
        let orders = Orders::of(&topology, &kinematics);
        let rotations = rotations(&topology, &kinematics, &orders)?;
        if rotations.iter().any(Option::is_some) {
            topology.warns_of_drift()?;
        }
        let centres = centres(&topology, &planets);
        topology.states_phases()?;
        let phases = phases(&topology.meshes, &kinematics, &planets, &centres)?;
        Ok(Plan { topology, kinematics, planets, centres, orders, rotations, phases, relative })
    }

    /// Refuses a part that follows the turn of a body which turns unevenly.
    pub(crate) fn turns_evenly(&self, part: &str, body: usize) -> Result<(), TrainError> {
        match &self.rotations[body] {
            None => Ok(()),
            Some(_) => Err(TrainError::Uneven { part: part.into(), body: self.topology.name(body) }),
        }
    }
}
