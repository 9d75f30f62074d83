//! The pair of gears of the course.

use crate::Outcome;
use gear_dynamics::contact::Nonlinearity;
use gear_dynamics::teeth::{
    GearPair, InvoluteGear, Piecewise, PotentialEnergy, QualityGrade, TransmissionError,
};
use gear_dynamics::trains::{Body, Coordinates, MeshPart, Parts, Train};
use gear_dynamics::{Backlash, Wave};

/// b, half of the backlash [m].
const HALF_BACKLASH: f64 = 4e-5;

/// Mesh stiffness of two gears of 50 teeth [N/m].
pub fn tooth_stiffness() -> Outcome<Piecewise> {
    Ok(PotentialEnergy::ma_2014([0.03; 2])?.wave(&gears()?.0)?)
}

/// Mesh stiffness, cut after three harmonics [N/m], and transmission error [m].
pub fn waves() -> Outcome<[Wave; 2]> {
    let (teeth, _) = gears()?;
    let stiffness = tooth_stiffness()?.fourier_series(3)?;
    let error = TransmissionError::of_grade(&teeth, [QualityGrade::new(6)?; 2])?.tooth().clone();
    Ok([Wave::new(stiffness), Wave::new(error)])
}

fn gears() -> Outcome<(GearPair, f64)> {
    let gear = InvoluteGear::external(50, 0.003)?.with_face_width(0.02)?;
    Ok((GearPair::new(&gear, &gear)?, gear.blank(0.03, 7850.0)?.polar_inertia))
}

/// The two gears with their mesh, 300 N m on the driver and a contact law.
fn parts<N: Nonlinearity + Clone>(law: N) -> Outcome<Parts<N>> {
    let (teeth, inertia) = gears()?;
    let [stiffness, error] = waves()?;
    let mesh = MeshPart::of_pair(&teeth, stiffness).error(error).damping(2000.0);
    let mut parts = Parts::default();
    parts.body("driver", Body::new(inertia)).body("driven", Body::new(inertia));
    parts.mesh("mesh", "driver", "driven", mesh.law(law)).torque("drive", "driver", 300.0);
    Ok(parts)
}

/// The pair on a bench, with a load on the driven gear.
pub fn bench_pair(speed: f64) -> Outcome<Train> {
    with_law(Backlash::new(HALF_BACKLASH)?, speed)
}

/// The same with another contact law.
pub fn with_law<N: Nonlinearity + Clone>(law: N, speed: f64) -> Outcome<Train<N>> {
    Ok(parts(law)?.load("driven").build("driver", speed)?)
}

/// The same in inertial coordinates, where a torque can be random.
pub fn with_brake(speed: f64) -> Outcome<Train> {
    let mut parts = parts(Backlash::new(HALF_BACKLASH)?)?;
    Ok(parts.coordinates(Coordinates::Inertial).torque("brake", "driven", -300.0).build("driver", speed)?)
}
