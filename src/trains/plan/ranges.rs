//! Ranges of all numbers of the parts.

use crate::contact::Nonlinearity;
use crate::error::{ParameterError, check};
use crate::excitation::{Side, Wave};
use crate::trains::parts::characteristic::Characteristic;
use crate::trains::parts::collection::Parts;
use crate::trains::parts::mesh_part::{MeshPart, Phase};
use crate::trains::parts::torque_part::Course;
use crate::trains::plan::turning::SAME;
use crate::trains::train_error::TrainError;
use std::f64::consts::TAU;

/// Number of angles at which the radius of a noncircular gear is checked.
const RADII: u32 = 1024;

/// Number of angles at which the stiffness of a mesh is checked.
const STIFFNESSES: u32 = 128;

/// Every number in its range.
pub(crate) fn check<N: Nonlinearity>(parts: &Parts<N>) -> Result<(), TrainError> {
    if parts.bodies.is_empty() {
        return Err(ParameterError::Empty { name: "bodies of the train".into(), min: 1 }.into());
    }
    for (name, body) in &parts.bodies {
        if !body.is_prescribed() {
            if body.inertia == 0.0 {
                return Err(TrainError::NoInertia { body: name.clone() });
            }
            check::scale(format!("inertia of \"{name}\""), body.inertia)?;
        }
        check::not_negative(format!("drag of \"{name}\""), body.drag)?;
        check::quantities(&format!("centre of \"{name}\""), &body.centre.unwrap_or_default())?;
        for (what, value) in ["stiffness", "damping"].into_iter().zip(body.support) {
            check::not_negative(format!("{what} of the support of \"{name}\""), value)?;
        }
        let Some(bearing) = &body.bearing else { continue };
        check::scale(format!("mass of \"{name}\""), bearing.mass)?;
        for axis in [0, 1] {
            check::not_negative(format!("bearing stiffness of \"{name}\""), bearing.stiffness[axis])?;
            check::not_negative(format!("bearing damping of \"{name}\""), bearing.damping[axis])?;
        }
        check::not_negative(format!("half clearance of \"{name}\""), bearing.half_clearance)?;
        if bearing.along_y && body.place.is_some() {
            let why = "a planet moves in both directions";
            return Err(TrainError::NotIsotropic { body: name.clone(), why });
        }
        let alike = [bearing.stiffness, bearing.damping].iter().all(|[x, y]| x == y);
        if bearing.half_clearance > 0.0 && !alike {
            let why = "it has a radial clearance";
            return Err(TrainError::NotIsotropic { body: name.clone(), why });
        }
    }
    for shaft in &parts.shafts {
        check::not_negative(format!("stiffness of \"{}\"", shaft.name), shaft.part.stiffness)?;
        check::not_negative(format!("damping of \"{}\"", shaft.name), shaft.part.damping)?;
        check::not_negative(
            format!("half clearance of \"{}\"", shaft.name),
            shaft.part.clearance.as_ref().map_or(0.0, |(half, _)| *half),
        )?;
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
                    return Err(ParameterError::Empty { name: of("coefficients"), min: 1 }.into());
                }
                coefficients.iter().try_for_each(|c| check::quantity(of("coefficient"), *c).map(drop))?;
            }
            Course::Constant | Course::OfAngle(_) => {}
        }
    }
    for (name, _, MeshPart { gears: mesh, .. }) in &parts.meshes {
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
            return Err(ParameterError::OutOfRange { name, value: angle, allowed: "[0, 1.4] rad" }.into());
        }
        stiffness(name, &mesh.stiffness)?;
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
        for (factor, gear) in mesh.radius_of_turn.iter().zip(["first", "second"]) {
            factor.as_ref().map_or(Ok(()), |factor| radius(name, gear, factor))?;
        }
        if mesh.is_round() && (radii / teeth - 1.0).abs() > SAME {
            return Err(TrainError::RadiiContradictTeeth { mesh: name.clone(), radii, teeth });
        }
    }
    Ok(())
}

/// The stiffness of a mesh is nowhere negative.
fn stiffness(mesh: &str, wave: &Wave) -> Result<(), TrainError> {
    let turn = TAU / f64::from(wave.order());
    let mut edges = Vec::new();
    let mut angle = -1e-9;
    while let Some(edge) = wave.next_edge(angle).filter(|edge| *edge < turn && edges.len() < RADII as usize) {
        edges.push(edge);
        angle = edge;
    }
    let spread = (0..STIFFNESSES).map(|i| turn * f64::from(i) / f64::from(STIFFNESSES));
    for angle in spread.chain(edges) {
        for value in [Side::Before, Side::After].map(|side| wave.value(angle, side)) {
            let what = || format!("stiffness of \"{mesh}\" at φ = {angle:.4} rad of its mesh cycle [N/m]");
            if value < 0.0 {
                check::not_negative(what(), value)?;
            }
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
