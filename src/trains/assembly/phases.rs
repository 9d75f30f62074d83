//! Phases of the meshes: stated, from the places of planets, or from the teeth of a gear that two meshes share.

use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::trains::assembly::kinematics::Kinematics;
use crate::trains::assembly::names::Names;
use crate::trains::assembly::places::{Planets, SAME, centre, snapped};
use crate::trains::assembly::train_error::TrainError;
use crate::trains::parts::collection::Parts;
use crate::trains::parts::mesh_part::{Kind, MeshPart, Phase};
use std::f64::consts::{PI, TAU};

/// A tooth of a gear at the pitch point of a mesh.
struct Meeting<'n> {
    mesh: usize,
    name: &'n str,
    /// The gear: its body, number of teeth, and whether they are internal.
    gear: (usize, u32, bool),
    carrier: Option<usize>,
    /// Cycles of this mesh from φ = 0 to the meeting, less its phase.
    cycles: f64,
    /// Polar angle of the tooth's middle against the rotation of the gear, in pitches.
    pitches: f64,
}

/// The phases of all meshes in [0, 1), in mesh cycles ahead of their waves.
pub(crate) fn phases<N: Nonlinearity>(
    parts: &Parts<N>,
    names: &Names,
    kinematics: &Kinematics,
    planets: &Planets,
) -> Result<Vec<f64>, TrainError> {
    let mut phases = vec![None; parts.meshes.len()];
    let mut meetings = Vec::new();
    let computed = parts.meshes.iter().any(|(_, _, mesh)| mesh.phase == Phase::FromTeeth);
    for (i, (name, ends, mesh)) in parts.meshes.iter().enumerate() {
        let bodies = names.pair(name, ends)?;
        let place = bodies.iter().find_map(|&body| planets[body].as_ref()).map_or(0.0, |planet| planet.ahead);
        if let Phase::Ahead(cycles) = mesh.phase {
            phases[i] = Some(snapped(place + cycles));
        }
        if computed {
            let carrier = names.carrier_of(parts, name, bodies)?;
            let meet = |gear| meeting(parts, kinematics, planets, (i, name, mesh), (bodies, carrier), gear);
            meetings.extend([0, 1].into_iter().filter_map(meet));
        }
    }
    // From mesh to mesh over the gears that they share.
    loop {
        let mut found = false;
        for one in &meetings {
            let Some(known) = phases[one.mesh] else { continue };
            for other in meetings.iter().filter(|other| one.shares_its_gear_with(other)) {
                let phase = one.phase_of(known, other);
                match phases[other.mesh] {
                    None => {
                        phases[other.mesh] = Some(snapped(phase));
                        found = true;
                    }
                    Some(stated) => {
                        let gap = snapped(stated - phase);
                        let from_teeth = |mesh: usize| parts.meshes[mesh].2.phase == Phase::FromTeeth;
                        let misses = gap.min(1.0 - gap) > SAME * f64::from(one.gear.1);
                        if misses && (from_teeth(one.mesh) || from_teeth(other.mesh)) {
                            let mesh = other.name.into();
                            return Err(TrainError::TeethMiss { mesh, gap: gap.min(1.0 - gap) });
                        }
                    }
                }
            }
        }
        if !found {
            break;
        }
    }
    let checked = parts.meshes.iter().zip(phases).map(|((name, _, mesh), phase)| {
        let computed = phase.ok_or_else(|| TrainError::PhaseUndetermined { mesh: name.clone() })?;
        let gap = snapped(mesh.stated_phase.unwrap_or(computed) - computed);
        if gap.min(1.0 - gap) > SAME {
            let stated = mesh.stated_phase.unwrap_or(computed);
            return Err(TrainError::PhaseContradicts { mesh: name.clone(), stated, computed });
        }
        Ok(computed)
    });
    checked.collect()
}

/// When and where a tooth of one gear of a mesh is at the pitch point; `None` without places or rotation.
fn meeting<'n, N: Nonlinearity>(
    parts: &Parts<N>,
    kinematics: &Kinematics,
    planets: &Planets,
    (i, name, mesh): (usize, &'n str, &MeshPart<N>),
    (bodies, carrier): ([usize; 2], Option<usize>),
    gear: usize,
) -> Option<Meeting<'n>> {
    let [own, mate] = [bodies[gear], bodies[1 - gear]];
    let [[x, y], [u, v]] = [own, mate].map(|body| centre(parts, planets, body));
    let turning = kinematics.relative(own, carrier)?;
    if (x, y) == (u, v) || turning.is_zero() {
        return None;
    }
    let sense = if turning.value() < 0.0 { -1.0 } else { 1.0 };
    let internal = [Kind::FirstInternal, Kind::SecondInternal].map(|kind| mesh.kind == kind);
    // The pitch point lies towards the mate, for the gear inside an internal one away from it.
    let towards = libm::atan2(v - y, u - x) + if internal[1 - gear] { PI } else { 0.0 };
    let teeth = mesh.teeth[gear];
    let pitch = TAU / f64::from(teeth);
    // The first gear pushes with the leading flank of its tooth, the second one is pushed at the trailing flank.
    let half = mesh.half_thickness[gear].unwrap_or(0.25 * pitch);
    let middle = sense * towards + if gear == 0 { -half } else { half };
    Some(Meeting {
        mesh: i,
        name,
        gear: (own, teeth, internal[gear]),
        carrier,
        cycles: mesh.pitch_point / TAU,
        pitches: middle / pitch,
    })
}

impl Meeting<'_> {
    fn shares_its_gear_with(&self, other: &Meeting) -> bool {
        self.mesh != other.mesh && self.gear == other.gear && self.carrier == other.carrier
    }
    /// The phase of another mesh of the gear. Teeth reach its pitch point later by the pitches between both.
    fn phase_of(&self, own: f64, other: &Meeting) -> f64 {
        own - self.cycles + other.cycles - (other.pitches - self.pitches)
    }
}
