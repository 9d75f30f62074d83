//! Centres of the bodies, and whether planets fit their places.

use crate::error::check;
use crate::trains::parts::mesh_part::{Kind, MeshGears};
use crate::trains::plan::topology::Topology;
use crate::trains::plan::turning::SAME;
use crate::trains::plan::turning::kinematics::Kinematics;
use crate::trains::train_error::TrainError;
use std::f64::consts::TAU;

/// A planet: carrier, angle, radius of its centre, and the phase that its place gives to its meshes.
#[derive(Clone, Debug)]
pub(crate) struct Planet {
    pub(crate) carrier: usize,
    pub(crate) angle: f64,
    pub(crate) radius: f64,
    /// Mesh cycles in [0, 1) by which the meshes of the planet are ahead of those of a planet at angle 0.
    pub(crate) ahead: f64,
}

/// The planets among the bodies, by their places.
pub(crate) type Planets = Vec<Option<Planet>>;

/// Phases within this distance of a multiple of 1/5040 are this multiple: planets in phase have equal waves.
const SNAP: f64 = 1e-9;

/// A phase in [0, 1).
pub(crate) fn snapped(cycles: f64) -> f64 {
    let parts = (cycles * 5040.0).round() / 5040.0;
    let cycles = if (cycles - parts).abs() < SNAP { parts } else { cycles };
    cycles.rem_euclid(1.0) % 1.0
}

pub(crate) fn planets<N>(topology: &Topology<N>, kinematics: &Kinematics) -> Result<Planets, TrainError> {
    let mut planets: Planets = vec![None; topology.bodies.len()];
    // The first central mesh of each planet: its phase, and the teeth of its central gear.
    let mut found: Vec<Option<(f64, f64)>> = vec![None; topology.bodies.len()];
    for ((planet, (name, body)), carrier) in planets.iter_mut().zip(topology.bodies).zip(&topology.carriers) {
        let (Some(place), Some(carrier)) = (&body.place, *carrier) else {
            if body.radius.is_some() {
                return Err(TrainError::RadiusWithoutCarrier { body: name.clone() });
            }
            continue;
        };
        check::quantity(format!("angle of \"{name}\""), place.angle)?;
        if let Some(radius) = body.radius {
            check::scale(format!("radius of \"{name}\""), radius)?;
        }
        let radius = body.radius.unwrap_or(f64::NAN);
        *planet = Some(Planet { carrier, angle: place.angle, radius, ahead: 0.0 });
    }
    for mesh in &topology.meshes {
        let [a, b] = mesh.ends;
        let (planet, central, teeth) = match (&planets[a], &planets[b]) {
            (Some(_), None) => (a, b, mesh.part.teeth[1]),
            (None, Some(_)) => (b, a, mesh.part.teeth[0]),
            _ => continue,
        };
        let required = centre_distance(mesh.part);
        let Some(place) = &mut planets[planet] else { continue };
        if place.radius.is_nan() {
            place.radius = required;
        }
        let title = || topology.name(planet);
        if (place.radius / required - 1.0).abs() > SAME {
            let (mesh, found) = (mesh.name.into(), place.radius);
            return Err(TrainError::CentreDistance { mesh, planet: title(), required, found });
        }
        // The teeth of a central gear that turns counterclockwise reach a planet at a larger angle later.
        let turns =
            kinematics.relative(central, Some(place.carrier)).is_none_or(|speed| speed.value() >= 0.0);
        let way = if turns { -1.0 } else { 1.0 };
        let ahead = way * f64::from(teeth) * place.angle / TAU;
        match found[planet] {
            None => {
                place.ahead = snapped(ahead);
                found[planet] = Some((ahead, way * f64::from(teeth)));
            }
            Some((first, per_turn)) => {
                // Both meshes must be shifted alike: (z_1 ± z_2) angle/2π is whole.
                let (gap, per_turn) = (ahead - first, way * f64::from(teeth) - per_turn);
                if (gap - gap.round()).abs() > SAME * per_turn.abs().max(1.0) {
                    let nearest = gap.round() / per_turn * TAU;
                    return Err(TrainError::DoesNotAssemble { planet: title(), angle: place.angle, nearest });
                }
            }
        }
    }
    match planets.iter().position(|planet| planet.as_ref().is_some_and(|planet| planet.radius.is_nan())) {
        Some(planet) => Err(TrainError::PlanetWithoutMesh { planet: topology.name(planet) }),
        None => Ok(planets),
    }
}

/// Centre distance (r_1 ± r_2)/cos α `[m]` of a mesh.
pub(crate) fn centre_distance(mesh: &MeshGears) -> f64 {
    let [r1, r2] = mesh.radii;
    let across = if mesh.kind == Kind::External { r1 + r2 } else { (r1 - r2).abs() };
    across / libm::cos(mesh.pressure_angle)
}

/// The centres of all bodies `[m]`: as stated, of a planet on its carrier, of a central gear without a
/// statement that of its carrier. `None`: unknown.
pub(crate) type Centres = Vec<Option<[f64; 2]>>;

pub(crate) fn centres<N>(topology: &Topology<N>, planets: &Planets) -> Centres {
    let stated = |body: usize| topology.body(body).centre;
    let mut centres: Vec<_> = (0..topology.bodies.len()).map(stated).collect();
    for mesh in &topology.meshes {
        let Some(carrier) = mesh.carrier else { continue };
        for body in mesh.ends {
            centres[body] = centres[body].or(Some(stated(carrier).unwrap_or_default()));
        }
    }
    for (centre, planet) in centres.iter_mut().zip(planets) {
        let Some(planet) = planet else { continue };
        let ([x, y], (sin, cos)) = (stated(planet.carrier).unwrap_or_default(), libm::sincos(planet.angle));
        *centre = Some([x + planet.radius * cos, y + planet.radius * sin]);
    }
    centres
}
