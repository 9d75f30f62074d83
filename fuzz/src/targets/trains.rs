//! Gear trains from parts, and the linear analysis of accepted ones.

use super::build::speaks_numbers;
use crate::case::{Case, Run, all_finite, holds};
use gear_dynamics::linear::{Modes, static_state};
use gear_dynamics::trains::{Bearing, Body, Coordinates, MeshPart, OfMesh, Parts, Planetary, Warning};
use gear_dynamics::{Model, ParameterError, State, Wave, excitation::Fourier};

fn wave(case: &mut Case, mean: f64) -> Result<Wave, ParameterError> {
    let pairs = case.pairs(2, 0.1 * mean);
    Ok(Wave::new(Fourier::new(case.number(mean), &pairs)?))
}

fn body(case: &mut Case) -> Body {
    let mut body = Body::new(case.number(1e-3)).at([case.number(0.1), case.number(0.1)]);
    if case.chance(0.4) {
        let bearing = Bearing::new(case.number(1.0), case.number(1e8)).damping(case.number(100.0));
        let bearing = if case.chance(0.3) { bearing.clearance(case.number(1e-5)) } else { bearing };
        body = body.on(if case.chance(0.2) { bearing.along_y() } else { bearing });
    }
    match case.below(8) {
        0 => body.held(case.number(1e5), case.number(1.0)),
        1 => body.restrained(case.number(1e5), case.number(1.0)),
        2 => body.drag(case.number(1.0)),
        3 => body.carried_by("b0", case.number(1.0)),
        4 => body.locked(),
        _ => body,
    }
}

fn mesh(case: &mut Case) -> Result<MeshPart, ParameterError> {
    let teeth = [(); 2].map(|()| case.pick(&[0, 1, 20, 30, 60, 90, 1_000_003, u32::MAX]));
    let module = case.number(1e-3);
    let radii = if case.chance(0.9) {
        teeth.map(|z| module * f64::from(z))
    } else {
        [case.number(0.03), case.number(0.06)]
    };
    let new = if case.chance(0.3) { MeshPart::internal } else { MeshPart::external };
    let mut part =
        new(teeth, radii, wave(case, 2e8)?).half_backlash(case.number(1e-5)).damping(case.number(1e3));
    if case.chance(0.3) {
        part = part.error(wave(case, 1e-6)?);
    }
    if case.chance(0.2) {
        part = part.friction(case.number(0.1)).phase(case.number(0.3));
    }
    if case.chance(0.2) {
        part = part
            .error_of_turn(OfMesh::Driven, wave(case, 1e-6)?)
            .stiffness_of_turn(OfMesh::Driver, wave(case, 1.0)?);
    }
    Ok(part.pressure_angle(case.number(0.35)))
}

/// Parts at random, and planetary sets.
pub fn train(case: &mut Case) -> Run {
    let mut parts = Parts::new();
    if case.chance(0.4) {
        let teeth = [(); 3].map(|()| case.pick(&[0, 19, 20, 30, 90, 89, 1_000_000, u32::MAX]));
        let inertias = [(); 4].map(|()| case.number(1e-3));
        let stiffness = [wave(case, 2e8)?, wave(case, 2e8)?];
        let set = Planetary::torsional(teeth, case.below(6) as u32, case.number(0.03), inertias, stiffness)?;
        let set =
            set.pressure_angle(case.number(0.35)).half_backlash(case.number(1e-5)).damping(case.number(1e3));
        let set = if case.chance(0.5) {
            set.on_bearings([(); 4].map(|()| Bearing::new(case.number(1.0), case.number(1e8))))
        } else {
            set
        };
        let angles = case.list(3, 1.0);
        let set = if case.chance(0.2) { set.at_angles(&angles) } else { set };
        parts.join("b0", set.supports([0.0, case.number(1e6), 0.0]).parts());
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
            0 => parts.shaft_with_clearance(
                &format!("s{i}"),
                &a,
                &b,
                [case.number(1e4), case.number(1.0)],
                case.number(1e-3),
            ),
            1 => parts.torque(&format!("t{i}"), &a, case.number(10.0)),
            2 => parts.motor(&format!("t{i}"), &a, case.number(10.0), case.number(0.2), case.number(100.0)),
            _ => parts.shaft(&format!("s{i}"), &a, &b, case.number(1e4), case.number(1.0)),
        };
    }
    if case.chance(0.2) {
        parts.coordinates(Coordinates::Relative);
    }
    if case.chance(0.1) {
        parts.rotating_with("b0 carrier");
    }
    for warning in [Warning::Unbalanced, Warning::UnusualValue, Warning::Unsupported, Warning::Disconnected] {
        parts.accept(warning);
    }
    let reference = if case.chance(0.5) { "b0 sun".to_owned() } else { name(case) };
    let train = parts.build(&reference, case.number(100.0))?;
    holds(train.dof() == train.shape().coordinates().len(), || "names of coordinates".into())?;
    speaks_numbers(&train, &State::at_rest(train.dof()))?;
    if let Some(modes) = case.accept(Modes::mean_in_contact(&train)) {
        all_finite("frequencies", &modes.frequencies())?;
        holds(train.kinds(&modes).len() == modes.list().len(), || "a kind for each mode".into())?;
        for mode in modes.list() {
            all_finite("shape of a mode", mode.shape())?;
            train
                .strain_energy(mode, 0.3)
                .iter()
                .try_for_each(|energy| all_finite(&energy.0, &[energy.1]))?;
        }
    }
    if let Some(state) = case.accept(static_state(&train, 0.0)) {
        all_finite("static state", &state.q)?;
    }
    Ok(())
}
