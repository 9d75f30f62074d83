//! Checks of the parts: ranges, connections, balance.

use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::error::check;
use crate::excitation::side::Side;
use crate::excitation::wave::Wave;
use crate::trains::parts::body::Body;
use crate::trains::parts::collection::{Course, Parts};
use crate::trains::parts::mesh_part::Phase;
use crate::trains::plan::names::Names;
use crate::trains::plan::places::SAME;
use crate::trains::shape::elements::Characteristic;
use crate::trains::shape::train_shape::TrainShape;
use crate::trains::train_error::{TrainError, Warning};
use std::f64::consts::TAU;

/// Stiffnesses of meshes of gears [N/m]; steel gears have some 1e8 to 1e10.
const MESH_STIFFNESS: [f64; 2] = [1e6, 1e12];
/// Modules of gears `[m]`.
const MODULE: [f64; 2] = [1e-5, 0.2];
/// Half backlashes `[m]`.
const HALF_BACKLASH: [f64; 2] = [0.0, 1e-2];

/// Number of angles at which the radius of a noncircular gear is checked.
const RADII: u32 = 1024;

/// Every number in its range.
pub(crate) fn values<N: Nonlinearity>(parts: &Parts<N>) -> Result<(), TrainError> {
    if parts.bodies.is_empty() {
        return Err(crate::ParameterError::Empty { name: "bodies of the train".into(), min: 1 }.into());
    }
    for (name, body) in &parts.bodies {
        check::scale(format!("inertia of \"{name}\""), body.inertia)?;
        check::not_negative(format!("drag of \"{name}\""), body.drag)?;
        check::quantities(&format!("centre of \"{name}\""), &body.centre.unwrap_or_default())?;
        for (what, value) in [("stiffness", 0), ("damping", 1)].into_iter().zip(body.support) {
            check::not_negative(format!("{} of the support of \"{name}\"", what.0), value)?;
        }
        let Some(bearing) = &body.bearing else { continue };
        check::scale(format!("mass of \"{name}\""), bearing.mass)?;
        for axis in [0, 1] {
            check::not_negative(format!("bearing stiffness of \"{name}\""), bearing.stiffness[axis])?;
            check::not_negative(format!("bearing damping of \"{name}\""), bearing.damping[axis])?;
        }
        check::not_negative(format!("clearance of \"{name}\""), bearing.clearance)?;
        if bearing.along_y && body.place.is_some() {
            return Err(TrainError::NotIsotropic {
                body: name.clone(),
                why: "a planet moves in both directions",
            });
        }
        let alike = [bearing.stiffness, bearing.damping].iter().all(|[x, y]| x == y);
        if bearing.clearance > 0.0 && !alike {
            let why = "it has a radial clearance";
            return Err(TrainError::NotIsotropic { body: name.clone(), why });
        }
    }
    for shaft in &parts.shafts {
        check::not_negative(format!("stiffness of \"{}\"", shaft.name), shaft.stiffness)?;
        check::not_negative(format!("damping of \"{}\"", shaft.name), shaft.damping)?;
        check::not_negative(format!("clearance of \"{}\"", shaft.name), shaft.half_clearance.unwrap_or(0.0))?;
    }
    for torque in &parts.torques {
        check::quantity(format!("\"{}\"", torque.name), torque.value)?;
        let of = |what: &str| format!("{what} of \"{}\"", torque.name);
        match &torque.course {
            Course::OfSpeed(Characteristic::Induction { breakdown_slip, synchronous }) => {
                check::scale(of("breakdown slip"), *breakdown_slip)?;
                check::scale(of("synchronous speed"), *synchronous)?;
            }
            Course::OfSpeed(Characteristic::Polynomial(coefficients)) => {
                if coefficients.is_empty() {
                    return Err(crate::ParameterError::Empty { name: of("coefficients"), min: 1 }.into());
                }
                coefficients.iter().try_for_each(|c| check::quantity(of("coefficient"), *c).map(drop))?;
            }
            Course::Constant | Course::OfAngle(_) => {}
        }
    }
    for (name, _, mesh) in &parts.meshes {
        for teeth in mesh.teeth {
            if !(1..=1_000_000).contains(&teeth) {
                return Err(TrainError::ToothNumber { mesh: name.clone(), teeth });
            }
        }
        for radius in mesh.radii {
            check::scale(format!("base radius of \"{name}\""), radius)?;
        }
        let angle = mesh.pressure_angle;
        if !(0.0..=1.4).contains(&angle) {
            let name = format!("pressure angle of \"{name}\"");
            check::finite(&name, angle)?;
            return Err(
                crate::ParameterError::OutOfRange { name, value: angle, allowed: "[0, 1.4] rad" }.into()
            );
        }
        check::not_negative(format!("{name} damping"), mesh.damping)?;
        check::not_negative(format!("{name} half backlash"), mesh.half_backlash)?;
        if let Phase::Ahead(cycles) = mesh.phase {
            check::quantity(format!("phase of \"{name}\""), cycles)?;
        }
        check::quantity(format!("stated phase of \"{name}\""), mesh.stated_phase.unwrap_or(0.0))?;
        if let Some(friction) = &mesh.friction {
            check::not_negative(format!("{name} friction"), friction.coefficient)?;
        }
        let [radii, teeth] =
            [mesh.radii[0] / mesh.radii[1], f64::from(mesh.teeth[0]) / f64::from(mesh.teeth[1])];
        for (factor, gear) in mesh.radius_factors.iter().zip(["first", "second"]) {
            factor.as_ref().map_or(Ok(()), |factor| radius(name, gear, factor))?;
        }
        if mesh.is_round() && (radii / teeth - 1.0).abs() > SAME {
            return Err(TrainError::RadiiContradictTeeth { mesh: name.clone(), radii, teeth });
        }
    }
    Ok(())
}

/// The radius of a noncircular gear is positive and does not jump.
fn radius(mesh: &str, gear: &str, factor: &Wave) -> Result<(), TrainError> {
    for i in 0..RADII {
        let angle = TAU * f64::from(i) / f64::from(RADII) / f64::from(factor.order());
        let value = factor.value(angle, Side::After);
        if value.is_nan() || value <= 0.0 {
            let title = format!("factor of the base radius of the {gear} gear of \"{mesh}\" at {angle} rad");
            check::positive(title, value)?;
        }
    }
    let mut angle = -1e-9;
    while let Some(edge) = factor.next_edge(angle).filter(|edge| *edge < TAU) {
        let [before, after] = [Side::Before, Side::After].map(|side| factor.value(edge, side));
        if (after - before).abs() > SAME * after.abs() {
            return Err(TrainError::RadiusJumps { mesh: mesh.into(), angle: edge });
        }
        angle = edge;
    }
    Ok(())
}

/// Every name exists, values are usual, and the parts are connected.
pub(crate) fn parts<N: Nonlinearity>(parts: &Parts<N>, names: &Names) -> Result<(), TrainError> {
    let warn = |warning: Warning, message: String| {
        if parts.accepted.contains(&warning) { Ok(()) } else { Err(TrainError::Warning { warning, message }) }
    };
    let unusual = |what: String, value: f64, [low, high]: [f64; 2]| {
        if (low..=high).contains(&value) {
            return Ok(());
        }
        warn(Warning::UnusualValue, format!("{what} is {value:e}: usual are {low:e} to {high:e}"))
    };
    // Bodies that are connected have the same number.
    let mut group: Vec<usize> = (0..parts.bodies.len()).collect();
    fn root(group: &mut [usize], mut body: usize) -> usize {
        while group[body] != body {
            group[body] = group[group[body]];
            body = group[body];
        }
        body
    }
    let mut join = |a: usize, b: usize| {
        let [a, b] = [root(&mut group, a), root(&mut group, b)];
        group[a.max(b)] = a.min(b);
    };
    for (name, ends, mesh) in &parts.meshes {
        let [a, b] = names.pair(name, ends)?;
        join(a, b);
        let edges = mesh.law.edges(0.0, Side::After);
        let half = if N::HALF_WIDTH { mesh.half_backlash } else { edges.upper };
        unusual(
            format!("the stiffness of \"{name}\" at φ = 0 [N/m]"),
            mesh.stiffness.value(0.0, Side::After),
            MESH_STIFFNESS,
        )?;
        let module = 2.0 * mesh.radii[0] / (f64::from(mesh.teeth[0]) * libm::cos(mesh.pressure_angle));
        unusual(format!("the module of \"{name}\" [m]"), module, MODULE)?;
        if half.is_finite() {
            unusual(format!("half the backlash of \"{name}\" [m]"), half.abs(), HALF_BACKLASH)?;
        }
    }
    for shaft in &parts.shafts {
        let [a, b] = names.pair(&shaft.name, &shaft.ends)?;
        join(a, b);
    }
    for torque in &parts.torques {
        let body = names.place(&torque.name, &torque.body)?;
        if parts.bodies[body].1.locked {
            return Err(TrainError::AtRest { part: torque.name.clone() });
        }
    }
    for body in 0..parts.bodies.len() {
        if let Some(carrier) = names.carrier(parts, body)? {
            join(body, carrier);
        }
        let (name, part) = &parts.bodies[body];
        let shafts = parts.shafts.iter().flat_map(|shaft| &shaft.ends);
        if part.held && !part.locked && part.support[0] == 0.0 && shafts.into_iter().all(|end| end != name) {
            let message = format!(
                "nothing holds \"{name}\", which is at rest in the mean: give it a stiffness or lock it"
            );
            warn(Warning::Unsupported, message)?;
        }
        if let Some(bearing) = part.bearing
            && (bearing.stiffness[1] == 0.0 || !bearing.along_y && bearing.stiffness[0] == 0.0)
        {
            let message = format!("the bearing of \"{name}\" has no stiffness: the body is not supported");
            warn(Warning::Unsupported, message)?;
        }
    }
    let first = root(&mut group, 0);
    let apart = (0..parts.bodies.len()).find(|&body| root(&mut group, body) != first);
    apart.map_or(Ok(()), |body| {
        let [one, other] = [&parts.bodies[0].0, &parts.bodies[body].0];
        warn(Warning::Disconnected, format!("\"{other}\" is not connected with \"{one}\""))
    })
}

/// Whether something holds a train with bodies that turn unevenly to its kinematic rotation.
pub(crate) fn held<N>(parts: &Parts<N>, shape: &TrainShape<N>) -> Result<(), TrainError> {
    let holds = |body: &Body| !body.held && (body.support[0] > 0.0 || body.drag > 0.0);
    let accepted = parts.accepted.contains(&Warning::Drifts);
    if shape.uneven.is_empty()
        || accepted
        || !shape.motors.is_empty()
        || parts.bodies.iter().any(|body| holds(&body.1))
    {
        return Ok(());
    }
    let message =
        "nothing holds the train to its uneven rotation, and deviations from it grow: restrain a body \
                   that turns evenly (Body::restrained), or give it drag or a torque over the speed"
            .into();
    Err(TrainError::Warning { warning: Warning::Drifts, message })
}
