//! The pair of gears of the course.

use super::Outcome;
use gear_dynamics::Wave;
use gear_dynamics::contact::Nonlinearity;
use gear_dynamics::teeth::{
    GearPair, InvoluteGear, Piecewise, PotentialEnergy, QualityGrade, TransmissionError,
};
use gear_dynamics::trains::{Coordinates, SpurPair, Train};

/// Mesh stiffness of two gears of 50 teeth [N/m].
pub fn tooth_stiffness() -> Outcome<Piecewise> {
    Ok(PotentialEnergy::ma_2014([0.03; 2])?.wave(&gears()?)?)
}

/// Mesh stiffness, cut after three harmonics [N/m], and transmission error [m].
pub fn waves() -> Outcome<[Wave; 2]> {
    let stiffness = tooth_stiffness()?.fourier_series(3)?;
    let error = TransmissionError::of_grade(&gears()?, [QualityGrade::new(6)?; 2])?.tooth().clone();
    Ok([Wave::new(stiffness), Wave::new(error)])
}

fn gears() -> Outcome<GearPair> {
    let gear = InvoluteGear::external(50, 0.003)?.with_face_width(0.02)?;
    Ok(GearPair::new(&gear, &gear)?)
}

/// The pair without its load.
fn unloaded() -> Outcome<SpurPair> {
    Ok(SpurPair::of_teeth(&gears()?, [0.03; 2], [6; 2], 3)?.damping(2000.0).half_backlash(4e-5))
}

/// The pair on a bench, with a load on the driven gear.
pub fn bench_pair(speed: f64) -> Outcome<Train> {
    Ok(unloaded()?.drive_torque(300.0).parts()?.build("driver", speed)?)
}

/// The same with another contact law.
pub fn with_law<N: Nonlinearity + Clone>(law: N, speed: f64) -> Outcome<Train<N>> {
    Ok(unloaded()?.drive_torque(300.0).parts_with_law(law)?.build_with_laws("driver", speed)?)
}

/// The same in inertial coordinates, where a torque can be random.
pub fn with_brake(speed: f64) -> Outcome<Train> {
    let mut parts = unloaded()?.parts()?;
    parts.torque("drive", "driver", 300.0).torque("brake", "driven", -300.0);
    Ok(parts.coordinates(Coordinates::Inertial).build("driver", speed)?)
}
