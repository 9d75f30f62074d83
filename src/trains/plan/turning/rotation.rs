//! Noncircular gears: the bodies that they turn unevenly.

use crate::contact::Nonlinearity;
use crate::error::ParameterError;
use crate::excitation::functions::combine::Quotient;
use crate::excitation::{Product, Side, Wave};
use crate::trains::plan::topology::{Gearing, Topology};
use crate::trains::plan::turning::SAME;
use crate::trains::plan::turning::kinematics::Kinematics;
use crate::trains::plan::turning::orders::Orders;
use crate::trains::train_error::TrainError;
use std::f64::consts::TAU;

/// R = (dθ/dφ)/mean of each body in the kinematic motion, as a wave of φ; `None` if the body turns evenly.
pub(crate) type Rotations = Vec<Option<Wave>>;

/// Bodies whose rotations follow from each other.
struct Link<'p> {
    part: &'p str,
    bodies: Vec<usize>,
    /// z_1/z_2, and R of the second body divided by R of the first one. `None`: all bodies have the same R.
    ratio: Option<(f64, Wave)>,
}

/// The rotations of all bodies: the reference body turns evenly, each noncircular mesh multiplies by g_1/g_2.
pub(crate) fn rotations<N: Nonlinearity>(
    topology: &Topology<N>,
    kinematics: &Kinematics,
    orders: &Orders,
) -> Result<Rotations, TrainError> {
    let mut found: Vec<Option<Option<Wave>>> = vec![None; topology.bodies.len()];
    if topology.meshes.iter().all(|mesh| mesh.part.is_round()) {
        return Ok(vec![None; found.len()]);
    }
    let links = links(topology, kinematics, orders)?;
    found[topology.reference] = Some(None);
    let mut open: Vec<&Link> = links.iter().collect();
    loop {
        let before = open.len();
        for link in std::mem::take(&mut open) {
            let Some(from) = link.bodies.iter().position(|&body| found[body].is_some()) else {
                open.push(link);
                continue;
            };
            let body = link.bodies[from];
            let known = found[body].clone().flatten();
            if link.bodies.len() > 2 && known.is_some() {
                return Err(TrainError::Uneven { part: link.part.into(), body: topology.name(body) });
            }
            let own = link.from(known, from)?;
            for (_, &body) in link.bodies.iter().enumerate().filter(|(i, _)| *i != from) {
                match &found[body] {
                    None => found[body] = Some(own.clone()),
                    Some(other) if alike(other.as_ref(), own.as_ref()) => {}
                    Some(_) => {
                        let (part, body) = (link.part.into(), topology.name(body));
                        return Err(TrainError::UnevenLoop { part, body });
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
    topology: &Topology<'p, N>,
    kinematics: &Kinematics,
    orders: &Orders,
) -> Result<Vec<Link<'p>>, TrainError> {
    let mut links = Vec::new();
    for (shaft, ends) in &topology.shafts {
        links.push(Link { part: &shaft.name, bodies: ends.to_vec(), ratio: None });
    }
    for mesh in &topology.meshes {
        let why = match mesh.carrier {
            Some(_) => "a planet and its carrier have constant levers",
            None if mesh.part.friction.is_some() => "tooth friction has constant levers",
            None => "",
        };
        let round = mesh.part.is_round();
        if !round && !why.is_empty() {
            return Err(TrainError::NotRound { mesh: mesh.name.into(), why });
        }
        let ratio = if round { None } else { Some(ratio(mesh, kinematics, orders)?) };
        let bodies = mesh.ends.into_iter().chain(mesh.carrier).collect();
        links.push(Link { part: mesh.name, bodies, ratio });
    }
    Ok(links)
}

/// z_1/z_2, and R of the second gear over R of the first one: r_1 g_1 z_2/(r_2 g_2 z_1).
fn ratio<N: Nonlinearity>(
    mesh: &Gearing<N>,
    kinematics: &Kinematics,
    orders: &Orders,
) -> Result<(f64, Wave), TrainError> {
    if mesh.ends.iter().any(|&body| kinematics.speeds[body].is_zero()) {
        return Err(TrainError::AtRest { part: mesh.name.into() });
    }
    let [r1, r2] = mesh.part.radii;
    let [z1, z2] = mesh.part.teeth.map(f64::from);
    let mut radii = [vec![Wave::constant(r1 / r2 * z2 / z1)?], vec![Wave::constant(1.0)?]];
    for ((radius, factor), body) in radii.iter_mut().zip(&mesh.part.radius_of_turn).zip(mesh.ends) {
        if let Some(factor) = factor {
            radius.push(orders.wave(mesh.name, factor, orders.turn(body))?);
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

/// The mean of a rotation over a turn of φ, by the rectangle rule with more and more points until it is 1.
/// The counts are prime: no order divides them.
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
