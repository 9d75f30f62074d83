//! Which bodies each part joins: the parts of a train with places of bodies in the place of their names.

use crate::trains::parts::body::Body;
use crate::trains::parts::collection::{JoinedShaft, Parts};
use crate::trains::parts::coordinates::Coordinates;
use crate::trains::parts::mesh_part::{MeshGears, MeshPart};
use crate::trains::parts::torque_part::TorquePart;
use crate::trains::train_error::{TrainError, Warning};
use std::collections::{BTreeMap, HashSet};

/// The parts of a train. A number in the place of a body's name is its place among the bodies.
pub(crate) struct Topology<'p, N> {
    pub(crate) bodies: &'p [(String, Body)],
    /// The carrier of each planet.
    pub(crate) carriers: Vec<Option<usize>>,
    pub(crate) meshes: Vec<Gearing<'p, N>>,
    pub(crate) shafts: Vec<(&'p JoinedShaft<N>, [usize; 2])>,
    pub(crate) torques: Vec<(&'p TorquePart, usize)>,
    /// The body whose speed is given.
    pub(crate) reference: usize,
    /// The body on which a torque balances all others.
    pub(crate) load: Option<usize>,
    /// The carrier with which the displacements rotate.
    pub(crate) rotating: Option<usize>,
    /// Whether the rotating frame has the centrifugal forces and preloads of the planets.
    pub(crate) preloaded: bool,
    pub(crate) coordinates: Option<Coordinates>,
    accepted: &'p [Warning],
    pub(crate) without_units: bool,
}

/// A mesh between two bodies.
pub(crate) struct Gearing<'p, N> {
    pub(crate) name: &'p str,
    pub(crate) ends: [usize; 2],
    /// The carrier of its planet or planets.
    pub(crate) carrier: Option<usize>,
    pub(crate) part: &'p MeshGears,
    pub(crate) law: &'p N,
}

impl<'p, N> Topology<'p, N> {
    /// Finds all bodies by their names.
    ///
    /// # Errors
    /// Two parts with the same name; a name that does not exist; a part that joins a body with itself; a
    /// planet on a planet; a mesh between planets of different carriers; two loads.
    pub(crate) fn of(parts: &'p Parts<N>, reference: &str) -> Result<Self, TrainError> {
        check_names(parts)?;
        let places: BTreeMap<&str, usize> =
            parts.bodies.iter().enumerate().map(|(i, body)| (&body.0[..], i)).collect();
        let place = |part: &str, body: &str| {
            places.get(body).copied().ok_or_else(|| {
                let known = places.keys().copied().collect::<Vec<_>>().join(", ");
                TrainError::NoSuchBody { part: part.into(), body: body.into(), known }
            })
        };
        let pair = |part: &str, ends: &[String; 2]| {
            let [a, b] = [place(part, &ends[0])?, place(part, &ends[1])?];
            if a == b {
                return Err(TrainError::JoinsItself { part: part.into(), body: ends[0].clone() });
            }
            Ok([a, b])
        };
        if let [one, other, ..] = &parts.loads[..] {
            return Err(TrainError::TwoLoads { bodies: [one.clone(), other.clone()] });
        }
        let named = |part: &str, body: Option<&String>| body.map(|body| place(part, body)).transpose();
        let reference = place("the reference", reference)?;
        let carrier =
            |(name, body): &(String, Body)| named(name, body.place.as_ref().map(|place| &place.carrier));
        let carriers = parts.bodies.iter().map(carrier).collect::<Result<Vec<_>, _>>()?;
        for (carrier, (planet, _)) in carriers.iter().zip(&parts.bodies) {
            let Some((carrier, body)) = carrier.map(|carrier| &parts.bodies[carrier]) else { continue };
            if body.place.is_some() {
                return Err(TrainError::NestedCarrier { carrier: carrier.clone(), planet: planet.clone() });
            }
        }
        let gearing = |(name, ends, part): &'p (String, [String; 2], MeshPart<N>)| {
            let ends = pair(name, ends)?;
            let carrier = match ends.map(|body| carriers[body]) {
                [Some(one), Some(other)] if one != other => {
                    return Err(TrainError::TwoCarriers { mesh: name.clone() });
                }
                [first, second] => first.or(second),
            };
            Ok(Gearing { name, ends, carrier, part: &part.gears, law: &part.law })
        };
        let meshes = parts.meshes.iter().map(gearing).collect::<Result<_, _>>()?;
        let shaft = |shaft: &'p JoinedShaft<N>| Ok((shaft, pair(&shaft.name, &shaft.ends)?));
        let torque = |torque: &'p TorquePart| Ok((torque, place(&torque.name, &torque.body)?));
        Ok(Topology {
            bodies: &parts.bodies,
            meshes,
            shafts: parts.shafts.iter().map(shaft).collect::<Result<_, TrainError>>()?,
            torques: parts.torques.iter().map(torque).collect::<Result<_, TrainError>>()?,
            reference,
            load: named("the load", parts.loads.first())?,
            rotating: named("the rotating frame", parts.rotating.as_ref().map(|frame| &frame.carrier))?,
            preloaded: parts.rotating.as_ref().is_some_and(|frame| frame.preloaded),
            coordinates: parts.coordinates,
            accepted: &parts.accepted,
            without_units: parts.without_units,
            carriers,
        })
    }

    /// The name of a body, for an error.
    pub(crate) fn name(&self, body: usize) -> String {
        self.bodies[body].0.clone()
    }
    pub(crate) fn body(&self, body: usize) -> &'p Body {
        &self.bodies[body].1
    }
    pub(crate) fn accepts(&self, warning: Warning) -> bool {
        self.without_units && warning == Warning::UnusualValue || self.accepted.contains(&warning)
    }
    /// A warning, unless it is accepted.
    pub(crate) fn warn(&self, warning: Warning, message: String) -> Result<(), TrainError> {
        if self.accepts(warning) { Ok(()) } else { Err(TrainError::Warning { warning, message }) }
    }
}

/// Checks that no two parts have the same name.
fn check_names<N>(parts: &Parts<N>) -> Result<(), TrainError> {
    let bodies = parts.bodies.iter().map(|body| &body.0);
    let shafts = parts.shafts.iter().map(|shaft| &shaft.name);
    let meshes = parts.meshes.iter().map(|mesh| &mesh.0);
    let torques = parts.torques.iter().map(|torque| &torque.name);
    let mut seen = HashSet::new();
    let mut names = bodies.chain(shafts).chain(meshes).chain(torques);
    match names.find(|name| *name == "speed" || !seen.insert(*name)) {
        Some(name) => Err(TrainError::DuplicateName { name: name.clone() }),
        None => Ok(()),
    }
}
