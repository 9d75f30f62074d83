//! Checks of a topology: values are usual, bodies are supported and connected.

use crate::contact::Nonlinearity;
use crate::excitation::Side;
use crate::trains::parts::mesh_part::Phase;
use crate::trains::plan::topology::{Gearing, Topology};
use crate::trains::plan::turning::orders::follows_teeth;
use crate::trains::train_error::{TrainError, Warning};
use std::f64::consts::TAU;

/// Stiffnesses of meshes of gears [N/m]; steel gears have some 1e8 to 1e10.
const MESH_STIFFNESS: [f64; 2] = [1e6, 1e12];
/// Modules of gears `[m]`.
const MODULE: [f64; 2] = [1e-5, 0.2];
/// Working pressure angles `[rad]`: up to 45°.
const PRESSURE_ANGLE: [f64; 2] = [0.0, TAU / 8.0];
/// Half of a backlash, and the largest absolute value of a transmission error `[m]`.
const HALF_BACKLASH: [f64; 2] = [0.0, 1e-2];

/// Number of mesh angles at which a transmission error is evaluated.
const ERRORS: u32 = 32;

impl<N: Nonlinearity> Topology<'_, N> {
    /// Warns of values that gears do not have, of bodies without support and of parts apart.
    ///
    /// # Errors
    /// A [`Warning`] that is not accepted; a torque on a body that is locked; a torque, a drag or a support
    /// of one whose rotation is prescribed.
    pub(crate) fn check(&self) -> Result<(), TrainError> {
        self.usual()?;
        let torques = self.torques.iter().map(|(torque, body)| (&torque.name[..], *body));
        let mut torques = torques.chain(self.load.map(|load| ("the load", load)));
        if let Some((part, body)) = torques.find(|(_, body)| self.body(*body).locked) {
            return Err(match self.body(body).grounded {
                true => TrainError::AtRest { part: part.into() },
                false => TrainError::Prescribed { part: part.into(), body: self.name(body) },
            });
        }
        for (name, body) in self.bodies.iter().filter(|(_, body)| body.is_prescribed()) {
            let held = [("drag", body.drag), ("support", body.support[0].max(body.support[1]))];
            if let Some((part, _)) = held.into_iter().find(|(_, size)| *size > 0.0) {
                return Err(TrainError::Prescribed { part: part.into(), body: name.clone() });
            }
        }
        self.supported()?;
        self.connected()
    }

    fn usual(&self) -> Result<(), TrainError> {
        let check = |what: String, value: f64, [low, high]: [f64; 2]| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            let message = format!("{what} is {value:e}: usual are {low:e} to {high:e}");
            self.warn(Warning::UnusualValue, message)
        };
        for mesh in &self.meshes {
            let (name, part) = (mesh.name, mesh.part);
            let edges = mesh.law.edges(0.0, Side::After);
            let half = if N::HALF_BACKLASH { part.half_backlash } else { edges.upper };
            let stiffness = part.stiffness.value(0.0, Side::After);
            check(format!("the stiffness of \"{name}\" at φ = 0 [N/m]"), stiffness, MESH_STIFFNESS)?;
            let module = 2.0 * part.radii[0] / (f64::from(part.teeth[0]) * libm::cos(part.pressure_angle));
            check(format!("the module of \"{name}\" [m]"), module, MODULE)?;
            let angle = part.pressure_angle;
            check(format!("the working pressure angle of \"{name}\" [rad]"), angle, PRESSURE_ANGLE)?;
            if half.is_finite() {
                check(format!("half the backlash of \"{name}\" [m]"), half.abs(), HALF_BACKLASH)?;
            }
            let angle = |i: u32| TAU * f64::from(i) / f64::from(ERRORS);
            let errors = (0..ERRORS).map(|i| part.error.value(angle(i), Side::After).abs());
            let largest = errors.fold(0.0, f64::max);
            check(format!("the transmission error of \"{name}\" [m]"), largest, HALF_BACKLASH)?;
            for (what, wave) in [("stiffness", &part.stiffness), ("transmission error", &part.error)] {
                if wave.order() > 1 && part.teeth.contains(&wave.order()) {
                    let times = wave.order();
                    let message = format!(
                        "the {what} of \"{name}\" repeats {times} times in a mesh cycle, as often as a gear has teeth: \
                         waves of a mesh are functions of the mesh angle; leave `per_turn` out"
                    );
                    self.warn(Warning::UnusualValue, message)?;
                }
            }
        }
        Ok(())
    }

    fn supported(&self) -> Result<(), TrainError> {
        for (body, (name, part)) in self.bodies.iter().enumerate() {
            let mut shafts = self.shafts.iter();
            let at_rest = part.grounded && !part.locked && part.support[0] == 0.0;
            if at_rest && shafts.all(|(_, ends)| !ends.contains(&body)) {
                let message = format!(
                    "nothing holds \"{name}\", which is at rest in the mean: give it a stiffness or lock it"
                );
                self.warn(Warning::Unsupported, message)?;
            }
            if let Some(bearing) = part.bearing
                && (bearing.stiffness[1] == 0.0 || !bearing.along_y && bearing.stiffness[0] == 0.0)
            {
                let message =
                    format!("the bearing of \"{name}\" has no stiffness: the body is not supported");
                self.warn(Warning::Unsupported, message)?;
            }
        }
        Ok(())
    }

    /// Warns of meshes whose gears share bodies, which vary over their teeth and of which more than one
    /// states no phase: one may, the others are behind it. The meshes of planets of one carrier with the
    /// same gear count as one, since their places give the phases between them.
    pub(crate) fn states_phases(&self) -> Result<(), TrainError> {
        let varying: Vec<_> = self.meshes.iter().filter(|mesh| follows_teeth(mesh)).collect();
        let groups = groups(self.bodies.len(), varying.iter().map(|mesh| mesh.ends));
        let unstated =
            |mesh: &&&Gearing<N>| mesh.part.phase == Phase::Unstated && mesh.part.stated_phase.is_none();
        let gear = |mesh: &Gearing<N>| {
            let centre = mesh.ends.into_iter().find(|&body| self.carriers[body].is_none());
            mesh.carrier.map(|carrier| (carrier, centre, mesh.part.teeth))
        };
        let mut first: Vec<Option<&Gearing<N>>> = vec![None; self.bodies.len()];
        for mesh in varying.iter().filter(unstated) {
            let first = &mut first[groups[mesh.ends[0]]];
            match *first {
                None => *first = Some(mesh),
                Some(other) if gear(mesh).is_some() && gear(mesh) == gear(other) => {}
                Some(other) => {
                    let message = format!(
                        "\"{}\" and \"{}\" vary over their teeth, their gears share bodies, and neither states \
                         its phase: MeshPart::phase_from_teeth computes it, MeshPart::phase states it",
                        other.name, mesh.name
                    );
                    self.warn(Warning::PhaseUnstated, message)?;
                }
            }
        }
        Ok(())
    }

    fn connected(&self) -> Result<(), TrainError> {
        let carried = self.carriers.iter().enumerate();
        let carried = carried.filter_map(|(body, carrier)| Some([body, (*carrier)?]));
        // A shaft without stiffness and damping carries nothing.
        let shafts =
            self.shafts.iter().filter(|(shaft, _)| shaft.part.stiffness.max(shaft.part.damping) > 0.0);
        let shafts = shafts.map(|(_, ends)| *ends);
        let meshes = self.meshes.iter().map(|mesh| mesh.ends);
        let groups = groups(self.bodies.len(), meshes.chain(shafts).chain(carried));
        let apart = groups.iter().position(|&first| first != 0);
        apart.map_or(Ok(()), |body| {
            let [one, other] = [0, body].map(|body| self.name(body));
            self.warn(Warning::Disconnected, format!("\"{other}\" is not connected with \"{one}\""))
        })
    }
}

/// For each body the first one of those that pairs join with it.
fn groups(bodies: usize, pairs: impl Iterator<Item = [usize; 2]>) -> Vec<usize> {
    let mut parents: Vec<usize> = (0..bodies).collect();
    let root = |parents: &mut [usize], mut body: usize| {
        while parents[body] != body {
            parents[body] = parents[parents[body]];
            body = parents[body];
        }
        body
    };
    for pair in pairs {
        let [a, b] = pair.map(|body| root(&mut parents, body));
        parents[a.max(b)] = a.min(b);
    }
    (0..bodies).map(|body| root(&mut parents, body)).collect()
}
