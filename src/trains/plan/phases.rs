//! Phases of the meshes: stated, from the places of planets, or from the teeth of a gear that two meshes
//! share.

use crate::contact::Nonlinearity;
use crate::trains::parts::mesh_part::{Kind, Phase};
use crate::trains::plan::places::{Centres, Planets, snapped};
use crate::trains::plan::topology::Gearing;
use crate::trains::plan::turning::SAME;
use crate::trains::plan::turning::kinematics::Kinematics;
use crate::trains::train_error::TrainError;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// A gear: its body, its number of teeth, whether they are internal, and the carrier of the mesh.
type Gear = (usize, u32, bool, Option<usize>);

/// A tooth of a gear at the pitch point of a mesh.
struct Meeting {
    mesh: usize,
    gear: Gear,
    /// Base radius of the gear `[m]`.
    radius: f64,
    /// Cycles of this mesh from φ = 0 to the meeting, less its phase.
    cycles: f64,
    /// Direction of the middle of the tooth, counted in the sense of rotation of the gear, in pitches.
    pitches: f64,
}

/// Largest allowed gap between the teeth of a loop of gears, in pitches. It allows for rounded places.
const MISS: f64 = 1e-3;

/// The phases of all meshes in [0, 1), in mesh cycles ahead of their waves.
pub(crate) fn phases<N: Nonlinearity>(
    meshes: &[Gearing<N>],
    kinematics: &Kinematics,
    planets: &Planets,
    centres: &Centres,
) -> Result<Vec<f64>, TrainError> {
    let mut phases: Vec<Option<f64>> = meshes
        .iter()
        .map(|mesh| {
            let planet = mesh.ends.iter().find_map(|&body| planets[body].as_ref());
            let ahead = planet.map_or(0.0, |planet| planet.ahead);
            match mesh.part.phase {
                Phase::Unstated => Some(snapped(ahead)),
                Phase::Ahead(cycles) => Some(snapped(ahead + cycles)),
                Phase::FromTeeth => None,
            }
        })
        .collect();
    let from_teeth = |mesh: usize| meshes[mesh].part.phase == Phase::FromTeeth;
    if phases.contains(&None) {
        let meet = |i: usize| {
            [0, 1].into_iter().filter_map(move |gear| meeting(i, &meshes[i], gear, kinematics, centres))
        };
        let meetings: Vec<Vec<Meeting>> = (0..meshes.len()).map(|i| meet(i).collect()).collect();
        let mut of_gear: HashMap<Gear, Vec<&Meeting>> = HashMap::new();
        for meeting in meetings.iter().flatten() {
            of_gear.entry(meeting.gear).or_default().push(meeting);
        }
        // From mesh to mesh over the gears that they share.
        let mut known: Vec<usize> = (0..phases.len()).filter(|&mesh| phases[mesh].is_some()).collect();
        while let Some(mesh) = known.pop() {
            let Some(own_phase) = phases[mesh] else { continue };
            for own in &meetings[mesh] {
                for other in of_gear[&own.gear].iter().filter(|other| own.shares_its_gear_with(other)) {
                    let phase = own.phase_of(own_phase, other);
                    match phases[other.mesh] {
                        None => {
                            phases[other.mesh] = Some(snapped(phase));
                            known.push(other.mesh);
                        }
                        Some(found) if from_teeth(mesh) || from_teeth(other.mesh) => {
                            let gap = distance(found, phase);
                            if gap > MISS {
                                return Err(miss(meshes, [(mesh, own_phase), (other.mesh, found)], phase));
                            }
                        }
                        Some(_) => {}
                    }
                }
            }
        }
    }
    let checked = meshes.iter().zip(phases).map(|(mesh, phase)| {
        let name = || mesh.name.to_owned();
        let computed = phase.ok_or_else(|| TrainError::PhaseUndetermined { mesh: name() })?;
        match mesh.part.stated_phase {
            Some(stated) if distance(stated, computed) > SAME => {
                Err(TrainError::PhaseContradicts { mesh: name(), stated, computed })
            }
            _ => Ok(computed),
        }
    });
    checked.collect()
}

/// Distance of two phases, in cycles.
fn distance(one: f64, other: f64) -> f64 {
    let gap = snapped(one - other);
    gap.min(1.0 - gap)
}

/// The error of two meshes of one gear whose phases contradict each other: one that is stated is wrong,
/// otherwise the places are. `phase`: of the second mesh by the first one.
fn miss<N>(meshes: &[Gearing<N>], [(one, own), (other, found)]: [(usize, f64); 2], phase: f64) -> TrainError {
    let name = |mesh: usize| meshes[mesh].name.to_owned();
    let contradicts = |mesh: usize, stated: f64, computed: f64| TrainError::PhaseContradicts {
        mesh: name(mesh),
        stated,
        computed: snapped(computed),
    };
    match [one, other].map(|mesh| &meshes[mesh].part.phase) {
        [_, Phase::Unstated | Phase::Ahead(_)] => contradicts(other, found, phase),
        [Phase::Unstated | Phase::Ahead(_), _] => contradicts(one, own, own + found - phase),
        _ => TrainError::TeethMiss { mesh: name(other), gap: distance(found, phase) },
    }
}

/// When and where a tooth of one gear of a mesh is at the pitch point; `None` without places or rotation.
fn meeting<N: Nonlinearity>(
    i: usize,
    gearing: &Gearing<N>,
    gear: usize,
    kinematics: &Kinematics,
    centres: &Centres,
) -> Option<Meeting> {
    let &Gearing { ends, carrier, part: mesh, .. } = gearing;
    let [own, mate] = [ends[gear], ends[1 - gear]];
    let ([x, y], [u, v]) = (centres[own]?, centres[mate]?);
    let turning = kinematics.of_gear(gearing, gear)?;
    if (x, y) == (u, v) || turning.is_zero() || !mesh.is_round() {
        return None;
    }
    let sense = if turning.value() < 0.0 { -1.0 } else { 1.0 };
    let internal = [Kind::FirstInternal, Kind::SecondInternal].map(|kind| mesh.kind == kind);
    // The pitch point lies towards the mate, for the gear inside an internal one away from it.
    let towards = libm::atan2(v - y, u - x) + if internal[1 - gear] { PI } else { 0.0 };
    let teeth = mesh.teeth[gear];
    let pitch = TAU / f64::from(teeth);
    // The first gear pushes with the leading flank of its tooth, the second one is pushed at the trailing
    // one.
    let half = mesh.half_thickness[gear].unwrap_or(0.25 * pitch);
    let middle = sense * towards + if gear == 0 { -half } else { half };
    Some(Meeting {
        mesh: i,
        gear: (own, teeth, internal[gear], carrier),
        radius: mesh.radii[gear],
        cycles: mesh.pitch_point / TAU,
        pitches: middle / pitch,
    })
}

impl Meeting {
    /// Gears of one body with equal teeth and radii are one gear.
    fn shares_its_gear_with(&self, other: &Meeting) -> bool {
        self.mesh != other.mesh && (self.radius / other.radius - 1.0).abs() < SAME
    }
    /// The phase of another mesh of the gear. Teeth reach its pitch point later by the pitches between both.
    fn phase_of(&self, own: f64, other: &Meeting) -> f64 {
        own - self.cycles + other.cycles - (other.pitches - self.pitches)
    }
}
