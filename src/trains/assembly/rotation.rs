//! Noncircular gears: their levers as waves, and the bodies that they turn unevenly.

use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::error::ParameterError;
use crate::excitation::combine::{Product, Quotient};
use crate::excitation::side::Side;
use crate::excitation::wave::Wave;
use crate::trains::assembly::assemble::{Assembly, once};
use crate::trains::assembly::rows::Row;
use crate::trains::parts::collection::Parts;
use crate::trains::parts::mesh_part::MeshPart;
use crate::trains::plan::kinematics::Kinematics;
use crate::trains::plan::names::Names;
use crate::trains::plan::orders::{Orders, follows_teeth};
use crate::trains::plan::places::SAME;
use crate::trains::shape::elements::{Lever, Uneven};
use crate::trains::train_error::TrainError;
use std::f64::consts::TAU;
use std::ops::Range;

/// R = (dθ/dφ)/mean of each body in the kinematic motion, as a wave of φ; `None` if the body turns evenly.
pub(crate) type Rotations = Vec<Option<Wave>>;

/// Bodies whose rotations follow from each other.
struct Link<'p> {
    part: &'p str,
    bodies: Vec<usize>,
    /// z_1/z_2, and R of the second body divided by R of the first one. `None`: all bodies have the same R.
    ratio: Option<(f64, Wave)>,
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
    let name = |body: usize| parts.bodies[body].0.clone();
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
                return Err(TrainError::Uneven { part: link.part.into(), body: name(link.bodies[from]) });
            }
            let own = link.from(known, from)?;
            for (_, &body) in link.bodies.iter().enumerate().filter(|(i, _)| *i != from) {
                match &found[body] {
                    None => found[body] = Some(own.clone()),
                    Some(other) if alike(other.as_ref(), own.as_ref()) => {}
                    Some(_) => {
                        return Err(TrainError::UnevenLoop { part: link.part.into(), body: name(body) });
                    }
                }
            }
        }
        if open.len() == before {
            break;
        }
    }
    Ok(found.into_iter().map(Option::flatten).collect())
}

impl Link<'_> {
    /// R of the other bodies of the link. `from`: the place of the body whose R is `known`.
    fn from(&self, known: Option<Wave>, from: usize) -> Result<Option<Wave>, TrainError> {
        let Some((teeth, ratio)) = &self.ratio else { return Ok(known) };
        let own = turned(known, ratio, from == 1)?;
        let mean = mean(&own);
        if (mean - 1.0).abs() > SAME {
            let ratio = if from == 0 { teeth * mean } else { teeth / mean };
            return Err(TrainError::MeanRatio { mesh: self.part.into(), ratio, teeth: *teeth });
        }
        Ok((!alike(Some(&own), None)).then_some(own))
    }
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
            None => "",
        };
        if !mesh.is_round() && !why.is_empty() {
            return Err(TrainError::NotRound { mesh: name.clone(), why });
        }
        let ratio = if mesh.is_round() { None } else { Some(ratio(name, bodies, mesh, kinematics, orders)?) };
        links.push(Link { part: name, bodies: bodies.into_iter().chain(carrier).collect(), ratio });
    }
    Ok(links)
}

/// z_1/z_2, and R of the second gear over R of the first one: r_1 g_1 z_2/(r_2 g_2 z_1).
fn ratio<N: Nonlinearity>(
    name: &str,
    bodies: [usize; 2],
    mesh: &MeshPart<N>,
    kinematics: &Kinematics,
    orders: &Orders,
) -> Result<(f64, Wave), TrainError> {
    if bodies.iter().any(|&body| kinematics.speeds[body].is_zero()) {
        return Err(TrainError::AtRest { part: name.into() });
    }
    let [r1, r2] = mesh.radii;
    let [z1, z2] = mesh.teeth.map(f64::from);
    let mut radii = [vec![Wave::constant(r1 / r2 * z2 / z1)?], vec![Wave::constant(1.0)?]];
    for ((radius, factor), body) in radii.iter_mut().zip(&mesh.radius_factors).zip(bodies) {
        if let Some(factor) = factor {
            radius.push(orders.wave(name, factor, orders.turn(body))?);
        }
    }
    let [above, below] = radii.map(product);
    Ok((z1 / z2, quotient(above?, below?)?))
}

/// A wave made of others, with their common order: it repeats as often as they do.
fn combined(waves: Vec<Wave>, made: impl Fn(Vec<Wave>) -> Wave) -> Result<Wave, ParameterError> {
    let order = Wave::common_order(&waves);
    made(waves.into_iter().map(|wave| wave.slower(order)).collect()).per_turn(order)
}

fn product(mut waves: Vec<Wave>) -> Result<Wave, ParameterError> {
    if waves.len() == 1 {
        return Ok(waves.remove(0));
    }
    combined(waves, |waves| Wave::new(Product::new(waves)))
}

fn quotient(above: Wave, below: Wave) -> Result<Wave, ParameterError> {
    combined(vec![above, below], |waves| {
        let [above, below] = [0, 1].map(|i| waves[i].clone());
        Wave::new(Quotient([above, below]))
    })
}

/// R multiplied by a ratio, or divided by it if `over`.
fn turned(known: Option<Wave>, ratio: &Wave, over: bool) -> Result<Wave, ParameterError> {
    match (known, over) {
        (None, false) => Ok(ratio.clone()),
        (Some(known), false) => product(vec![known, ratio.clone()]),
        (known, true) => quotient(known.map_or_else(|| Wave::constant(1.0), Ok)?, ratio.clone()),
    }
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

/// The mean of a rotation over a turn of φ, by the rectangle rule with more and more points until it is 1. The counts are
/// prime: no order divides them.
fn mean(wave: &Wave) -> f64 {
    let by = |points: u32| {
        let value = |i| wave.value(TAU * (f64::from(i) + 0.5) / f64::from(points), Side::After);
        (0..points).map(value).sum::<f64>() / f64::from(points)
    };
    let mut mean = f64::NAN;
    for points in [4099, 65_537, 1_048_583] {
        mean = by(points);
        if (mean - 1.0).abs() <= SAME {
            break;
        }
    }
    mean
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

    /// Refuses a part that follows the turn of a body which turns unevenly.
    pub(crate) fn follows(&self, part: &str, body: usize) -> Result<(), TrainError> {
        match &self.rotations[body] {
            None => Ok(()),
            Some(_) => {
                let body = self.layout.parts.bodies[body].0.clone();
                Err(TrainError::Uneven { part: part.into(), body })
            }
        }
    }
    /// Refuses waves over the teeth of a mesh without a round gear that turns evenly.
    pub(crate) fn teeth_turn_evenly(
        &self,
        name: &str,
        bodies: [usize; 2],
        part: &MeshPart<N>,
    ) -> Result<(), TrainError> {
        let even = |gear: usize| self.rotations[bodies[gear]].is_none();
        if !follows_teeth(part) || [0, 1].into_iter().any(|i| part.radius_factors[i].is_none() && even(i)) {
            return Ok(());
        }
        let body = if even(0) { bodies[1] } else { bodies[0] };
        Err(TrainError::Uneven { part: name.into(), body: self.layout.parts.bodies[body].0.clone() })
    }
}
