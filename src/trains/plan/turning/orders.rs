//! Orders of all waves over one common angle.

use crate::contact::Nonlinearity;
use crate::excitation::Wave;
use crate::trains::parts::torque_part::Course;
use crate::trains::plan::topology::{Gearing, Topology};
use crate::trains::plan::turning::fraction::Fraction;
use crate::trains::plan::turning::kinematics::Kinematics;
use crate::trains::train_error::TrainError;

/// The angle φ of all waves: the slowest one that every mesh and every turn repeats a whole number of times.
pub(crate) struct Orders {
    /// φ' over the speed of the reference body.
    base: Option<Fraction>,
    pub(crate) ratio: f64,
    turns: Vec<Fraction>,
}

impl Orders {
    pub(crate) fn of<N: Nonlinearity>(topology: &Topology<N>, kinematics: &Kinematics) -> Self {
        let mut base: Option<Fraction> = None;
        let mut add = |rate: Option<Fraction>| {
            if let Some(rate) = rate.map(Fraction::abs).filter(|rate| !rate.is_zero()) {
                base = Some(base.map_or(rate, |base| base.common(rate).unwrap_or(Fraction::ZERO)));
            }
        };
        for mesh in &topology.meshes {
            if follows_teeth(mesh) {
                add(kinematics.of_teeth(mesh));
            }
            for gear in [0, 1] {
                let waves =
                    [&mesh.part.error_of_turn, &mesh.part.stiffness_of_turn, &mesh.part.radius_of_turn];
                if waves.iter().any(|waves| waves[gear].is_some()) {
                    add(kinematics.of_gear(mesh, gear));
                }
            }
        }
        for (torque, body) in &topology.torques {
            if matches!(torque.course, Course::OfAngle(_)) {
                add(Some(kinematics.speeds[*body]));
            }
        }
        let turns = kinematics.speeds.iter().map(|speed| speed.abs()).collect();
        Orders { base, ratio: base.map_or(1.0, Fraction::value), turns }
    }

    /// Turns of a body over those of the reference body.
    pub(crate) fn turn(&self, body: usize) -> Option<Fraction> {
        Some(self.turns[body])
    }
    /// The whole number of repetitions in a turn of φ.
    pub(crate) fn order(&self, rate: Option<Fraction>) -> Option<u32> {
        rate?.over(self.base?)?.as_count().filter(|order| *order > 0)
    }
    /// A wave that repeats at `rate` as a wave of φ.
    pub(crate) fn wave(&self, part: &str, wave: &Wave, rate: Option<Fraction>) -> Result<Wave, TrainError> {
        if !varies(wave) {
            return Ok(wave.clone());
        }
        match self.order(rate) {
            Some(order) => Ok(wave.clone().per_turn(order)?),
            None if rate.is_some_and(Fraction::is_zero) => Err(TrainError::AtRest { part: part.into() }),
            None => Err(TrainError::NoCommonAngle { part: part.into() }),
        }
    }
}

/// Whether a wave is no constant.
pub(crate) fn varies(wave: &Wave) -> bool {
    Wave::gcd_of_orders([wave]) != 0
}

/// Whether any wave of a mesh is one over its teeth.
pub(crate) fn follows_teeth<N: Nonlinearity>(mesh: &Gearing<N>) -> bool {
    let part = mesh.part;
    varies(&part.stiffness) || varies(&part.error) || mesh.law.moves() || part.friction.is_some()
}
