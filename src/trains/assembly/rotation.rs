//! Noncircular gears: their levers as waves, and the bodies that they turn unevenly.

use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::error::ParameterError;
use crate::excitation::combine::{Product, Quotient};
use crate::excitation::side::Side;
use crate::excitation::wave::Wave;
use crate::trains::assembly::assemble::{Assembly, once};
use crate::trains::assembly::kinematics::Kinematics;
use crate::trains::assembly::names::Names;
use crate::trains::assembly::orders::{Orders, varies};
use crate::trains::assembly::places::SAME;
use crate::trains::assembly::rows::Row;
use crate::trains::assembly::train_error::TrainError;
use crate::trains::parts::collection::Parts;
use crate::trains::parts::mesh_part::MeshPart;
use crate::trains::shape::elements::{Lever, Uneven};
use std::f64::consts::TAU;
use std::ops::Range;

/// R = (dθ/dφ)/mean of each body in the kinematic motion, as a wave of φ; `None` if the body turns evenly.
pub(crate) type Rotations = Vec<Option<Wave>>;

/// Bodies whose rotations follow from each other.
struct Link<'p> {
    part: &'p str,
    bodies: Vec<usize>,
    /// R of the second body over that of the first one; 1 without it.
    ratio: Option<Wave>,
}

/// The rotations of all bodies: the reference body turns evenly, and each noncircular mesh multiplies by g_1/g_2.
pub(crate) fn rotations<N: Nonlinearity>(
    parts: &Parts<N>,
    names: &Names,
    kinematics: &Kinematics,
    orders: &Orders,
    reference: usize,
) -> Result<Rotations, TrainError> {
    let mut found: Vec<Option<Option<Wave>>> = vec![None; parts.bodies.len()];
    if parts.meshes.iter().all(|(_, _, mesh)| mesh.is_round()) {
        return Ok(vec![None; found.len()]);
    }
    let links = links(parts, names, kinematics, orders)?;
    found[reference] = Some(None);
    let mut open: Vec<&Link> = links.iter().collect();
    loop {
        let before = open.len();
        for link in std::mem::take(&mut open) {
            let Some(from) = link.bodies.iter().position(|&body| found[body].is_some()) else {
                open.push(link);
                continue;
            };
            let known = found[link.bodies[from]].clone().flatten();
            if link.bodies.len() > 2 && known.is_some() {
                let why = "its carrier and gears must turn evenly";
                return Err(TrainError::NotRound { mesh: link.part.into(), why });
            }
            let own = match (known, &link.ratio) {
                (None, None) => None,
                (Some(known), None) => Some(known),
                (known, Some(ratio)) => Some(turned(known, ratio, from == 1)?),
            };
            for (_, &body) in link.bodies.iter().enumerate().filter(|(i, _)| *i != from) {
                match &found[body] {
                    None => found[body] = Some(own.clone()),
                    Some(other) if alike(other.as_ref(), own.as_ref()) => {}
                    Some(_) => {
                        let why = "other parts turn its gears by another ratio";
                        return Err(TrainError::NotRound { mesh: link.part.into(), why });
                    }
                }
            }
        }
        if open.len() == before {
            break;
        }
    }
    let rotations: Rotations = found.into_iter().map(Option::flatten).collect();
    for (name, ends, mesh) in parts.meshes.iter().filter(|(_, _, mesh)| !mesh.is_round()) {
        for (gear, body) in names.pair(name, ends)?.into_iter().enumerate() {
            let mean = rotations[body].as_ref().map_or(1.0, mean);
            if (mean - 1.0).abs() > SAME {
                let teeth = f64::from(mesh.teeth[0]) / f64::from(mesh.teeth[1]);
                let radii = if gear == 0 { teeth / mean } else { teeth * mean };
                return Err(TrainError::RadiiContradictTeeth { mesh: name.clone(), radii, teeth });
            }
        }
    }
    Ok(rotations)
}

fn links<'p, N: Nonlinearity>(
    parts: &'p Parts<N>,
    names: &Names,
    kinematics: &Kinematics,
    orders: &Orders,
) -> Result<Vec<Link<'p>>, TrainError> {
    let mut links = Vec::new();
    for shaft in &parts.shafts {
        let bodies = names.pair(&shaft.name, &shaft.ends)?.to_vec();
        links.push(Link { part: &shaft.name, bodies, ratio: None });
    }
    for (name, ends, mesh) in &parts.meshes {
        let bodies = names.pair(name, ends)?;
        let carrier = names.carrier_of(parts, name, bodies)?;
        let why = match carrier {
            Some(_) => "a planet and its carrier have constant levers",
            None if mesh.friction.is_some() => "tooth friction has constant levers",
            None if bodies.iter().any(|&body| kinematics.speeds[body].is_zero()) => "it does not turn",
            None => "",
        };
        if !mesh.is_round() && !why.is_empty() {
            return Err(TrainError::NotRound { mesh: name.clone(), why });
        }
        let ratio = if mesh.is_round() { None } else { Some(ratio(name, bodies, mesh, orders)?) };
        links.push(Link { part: name, bodies: bodies.into_iter().chain(carrier).collect(), ratio });
    }
    Ok(links)
}

/// R of the second gear over R of the first one: r_1 g_1 z_2/(r_2 g_2 z_1).
fn ratio<N: Nonlinearity>(
    name: &str,
    bodies: [usize; 2],
    mesh: &MeshPart<N>,
    orders: &Orders,
) -> Result<Wave, TrainError> {
    let [r1, r2] = mesh.radii;
    let [z1, z2] = mesh.teeth.map(f64::from);
    let mut radii = [Wave::constant(r1 / r2 * z2 / z1)?, Wave::constant(1.0)?];
    for ((radius, factor), body) in radii.iter_mut().zip(&mesh.radius_factors).zip(bodies) {
        if let Some(factor) = factor {
            let factor = orders.wave(name, factor, orders.turn(body))?;
            *radius = Wave::new(Product::new(vec![radius.clone(), factor]));
        }
    }
    Ok(Wave::new(Quotient(radii)))
}

/// R times or over a ratio.
fn turned(known: Option<Wave>, ratio: &Wave, over: bool) -> Result<Wave, ParameterError> {
    Ok(match (known, over) {
        (None, false) => ratio.clone(),
        (Some(known), false) => Wave::new(Product::new(vec![known, ratio.clone()])),
        (None, true) => Wave::new(Quotient([Wave::constant(1.0)?, ratio.clone()])),
        (Some(known), true) => Wave::new(Quotient([known, ratio.clone()])),
    })
}

/// Number of angles at which rotations are compared; they are spread evenly.
const ANGLES: u32 = 1024;

/// Whether two rotations are equal.
fn alike(one: Option<&Wave>, other: Option<&Wave>) -> bool {
    let value = |wave: Option<&Wave>, angle| wave.map_or(1.0, |wave| wave.value(angle, Side::After));
    (0..ANGLES).all(|i| {
        let angle = TAU * crate::numeric::spread::golden(f64::from(i));
        (value(one, angle) - value(other, angle)).abs() < SAME
    })
}

/// The mean of a rotation over a turn of φ, by the rectangle rule.
fn mean(wave: &Wave) -> f64 {
    const POINTS: u32 = 1 << 16;
    let value = |i| wave.value(TAU * (f64::from(i) + 0.5) / f64::from(POINTS), Side::After);
    (0..POINTS).map(value).sum::<f64>() / f64::from(POINTS)
}

impl<N: Nonlinearity + Clone> Assembly<'_, N> {
    /// The accelerations of bodies that turn unevenly.
    pub(crate) fn uneven(&mut self) {
        for (body, rotation) in self.rotations.iter().enumerate() {
            if let (Some(wave), Some(at)) = (rotation, self.layout.angle[body]) {
                let ratio = self.layout.kinematics.speeds[body].value().abs() / self.orders.ratio;
                let wave = once(&mut self.shape.jets, wave.clone());
                self.shape.uneven.push(Uneven { at, ratio, wave });
            }
        }
    }

    /// Moves the levers that vary out of the row of a mesh.
    pub(crate) fn levers_that_vary(
        &mut self,
        name: &str,
        bodies: [usize; 2],
        part: &MeshPart<N>,
        row: &mut Row,
    ) -> Result<Range<usize>, TrainError> {
        let start = self.shape.varying.len();
        for (factor, body) in part.radius_factors.iter().zip(bodies) {
            let (Some(factor), Some(at)) = (factor, self.layout.angle[body]) else { continue };
            let Some(place) = row.0.iter().position(|entry| entry.at == at) else { continue };
            let by = row.0.remove(place).by;
            let wave = self.orders.wave(name, factor, self.orders.turn(body))?;
            let wave = once(&mut self.shape.jets, wave);
            self.shape.varying.push(Lever { at, lever: by, pull: by * self.per_inertia[at], wave });
        }
        Ok(start..self.shape.varying.len())
    }

    /// Refuses waves of a part that follow bodies of which none turns evenly.
    pub(crate) fn follows(&self, part: &str, bodies: &[usize]) -> Result<(), TrainError> {
        if bodies.iter().any(|&body| self.rotations[body].is_none()) {
            return Ok(());
        }
        let body = self.layout.parts.bodies[bodies[0]].0.clone();
        Err(TrainError::Uneven { part: part.into(), body })
    }
}

/// Whether any wave of a mesh follows its teeth.
pub(crate) fn follows_teeth<N: Nonlinearity>(mesh: &MeshPart<N>) -> bool {
    varies(&mesh.stiffness) || varies(&mesh.error) || mesh.law.moves() || mesh.friction.is_some()
}
