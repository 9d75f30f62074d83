//! Gear trains from parts, and the linear analysis of accepted ones.

use super::build::speaks_numbers;
use crate::case::{Case, Run, all_finite, holds};
use gear_dynamics::excitation::{Fourier, InstantCentre};
use gear_dynamics::linear::{Modes, static_state};
use gear_dynamics::trains::{
    Bearing, Body, Coordinates, InductionMotor, Members, MeshPart, OfMesh, Parts, Planetary, ShaftPart,
    Warning,
};
use gear_dynamics::{Model, ParameterError, State, Wave};

/// A number, in most cases a sensible one.
fn number(case: &mut Case, sensible: f64) -> f64 {
    if case.chance(0.95) { sensible * (0.5 + case.unit()) } else { case.number(sensible) }
}

fn wave(case: &mut Case, mean: f64) -> Result<Wave, ParameterError> {
    let pairs = case.pairs(2, 0.1 * mean);
    Ok(Wave::new(Fourier::new(number(case, mean), &pairs)?))
}

fn body(case: &mut Case) -> Body {
    let mut body = Body::new(number(case, 1e-3)).centre([number(case, 0.1), number(case, 0.1)]);
    if case.chance(0.4) {
        let bearing = Bearing::new(number(case, 1.0), number(case, 1e8)).damping(number(case, 100.0));
        let bearing = if case.chance(0.3) { bearing.half_clearance(number(case, 1e-5)) } else { bearing };
        body = body.bearing(if case.chance(0.2) { bearing.along_y() } else { bearing });
    }
    match case.below(8) {
        0 => body.grounded(number(case, 1e5), number(case, 1.0)),
        1 => body.restrained(number(case, 1e5), number(case, 1.0)),
        2 => body.drag(number(case, 1.0)),
        3 => body.carried_by("b0", number(case, 1.0)),
        4 => body.locked(),
        _ => body,
    }
}

fn mesh(case: &mut Case) -> Result<MeshPart, ParameterError> {
    let teeth = [(); 2].map(|()| {
        if case.chance(0.97) { case.pick(&[20, 30, 60]) } else { case.pick(&[0, 1, 1_000_003, u32::MAX]) }
    });
    let module = number(case, 1e-3);
    let mut radii = if case.chance(0.9) {
        teeth.map(|z| module * f64::from(z))
    } else {
        [number(case, 0.03), number(case, 0.06)]
    };
    let eccentric = if case.chance(0.2) { number(case, 0.2) } else { 0.0 };
    if eccentric != 0.0 {
        radii[1] *= (1.0 + eccentric * eccentric) / (1.0 - eccentric * eccentric);
    }
    let new = if case.chance(0.3) { MeshPart::internal } else { MeshPart::external };
    let mut part =
        new(teeth, radii, wave(case, 2e8)?).half_backlash(number(case, 1e-5)).damping(number(case, 1e3));
    if case.chance(0.3) {
        part = part.error(wave(case, 1e-6)?);
    }
    if eccentric != 0.0 {
        let radius = InstantCentre::new(eccentric)?.radius(1.0)?;
        let gear = if case.chance(0.8) { OfMesh::Driven } else { OfMesh::Driver };
        part = part.radius_of_turn(gear, Wave::new(radius));
    }
    if case.chance(0.2) {
        part = part.phase_from_teeth();
    }
    if case.chance(0.2) {
        part = part.friction(number(case, 0.1)).phase(number(case, 0.3));
    }
    if case.chance(0.2) {
        part = part
            .error_of_turn(OfMesh::Driven, wave(case, 1e-6)?)
            .stiffness_of_turn(OfMesh::Driver, wave(case, 1.0)?);
    }
    Ok(part.pressure_angle(number(case, 0.35)))
}

/// Parts at random, and planetary sets.
pub fn train(case: &mut Case) -> Run {
    let mut parts = Parts::new();
    if case.chance(0.4) {
        let teeth = if case.chance(0.8) {
            case.pick(&[[30, 30, 90], [19, 17, 56], [30, 20, 70]])
        } else {
            [(); 3].map(|()| case.pick(&[0, 19, 20, 30, 90, 89, 1_000_000, u32::MAX]))
        };
        let bearings = case.chance(0.5);
        let mut body = || {
            let body = Body::new(number(case, 1e-3));
            if bearings { body.bearing(Bearing::new(number(case, 1.0), number(case, 1e8))) } else { body }
        };
        let [sun, planet, ring, carrier] = [(); 4].map(|()| body());
        let ring = ring.grounded(number(case, 1e6), 0.0);
        let members =
            Members { sun: (teeth[0], sun), planet: (teeth[1], planet), ring: (teeth[2], ring), carrier };
        let stiffness = [wave(case, 2e8)?, wave(case, 2e8)?];
        let set = Planetary::new(case.below(6) as u32, number(case, 0.03), members, stiffness)?;
        let set = set
            .pressure_angle(number(case, 0.35))
            .half_backlash(number(case, 1e-5))
            .damping(number(case, 1e3));
        let angles = case.list(3, 1.0);
        let set = if case.chance(0.2) { set.angles(&angles) } else { set };
        parts.join("b0", set.parts());
    }
    let count = case.below(5);
    for i in 0..count {
        parts.body(&format!("b{i}"), body(case));
    }
    let name = |case: &mut Case| format!("b{}", case.below(count + 1));
    for i in 0..case.below(5) {
        let (a, b) = (name(case), name(case));
        parts.mesh(&format!("m{i}"), &a, &b, mesh(case)?);
    }
    for i in 0..case.below(3) {
        let (a, b) = (name(case), name(case));
        match case.below(4) {
            0 => parts.shaft(
                &format!("s{i}"),
                &a,
                &b,
                ShaftPart::new(number(case, 1e4))
                    .damping(number(case, 1.0))
                    .half_clearance(number(case, 1e-3)),
            ),
            1 => parts.torque(&format!("t{i}"), &a, number(case, 10.0)),
            2 => parts.motor(
                &format!("t{i}"),
                &a,
                InductionMotor {
                    breakdown_torque: number(case, 10.0),
                    breakdown_slip: number(case, 0.2),
                    synchronous_speed: number(case, 100.0),
                },
            ),
            _ => parts.shaft(
                &format!("s{i}"),
                &a,
                &b,
                ShaftPart::new(number(case, 1e4)).damping(number(case, 1.0)),
            ),
        };
    }
    if case.chance(0.2) {
        parts.coordinates(Coordinates::Relative);
    }
    if case.chance(0.1) {
        parts.rotating_with("b0 carrier");
    }
    for warning in [
        Warning::Unbalanced,
        Warning::UnusualValue,
        Warning::Unsupported,
        Warning::Disconnected,
        Warning::Drifts,
        Warning::PhaseUnstated,
    ] {
        parts.accept(warning);
    }
    let reference = if case.chance(0.5) { "b0 sun".to_owned() } else { name(case) };
    let train = parts.build(&reference, number(case, 100.0))?;
    holds(train.dof() == train.shape().coordinates().len(), || "names of coordinates".into())?;
    speaks_numbers(&train, &State::at_rest(train.dof()))?;
    if let Some(modes) = case.accept(Modes::mean_in_contact(&train)) {
        all_finite("frequencies", &modes.frequencies())?;
        holds(train.kinds(&modes).len() == modes.all().len(), || "a kind for each mode".into())?;
        for mode in modes.all() {
            all_finite("shape of a mode", mode.shape())?;
            train
                .strain_energy(mode, 0.3)
                .iter()
                .try_for_each(|energy| all_finite(&energy.0, &[energy.1]))?;
        }
    }
    if let Some(state) = case.accept(static_state(&train, 0.0)) {
        all_finite("static state", &state.state.q)?;
    }
    Ok(())
}
