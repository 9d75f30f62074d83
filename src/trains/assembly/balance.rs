//! Whether the torques balance, and the torque that balances them.

use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::models::ring::ring_params::mean;
use crate::trains::assembly::rows::Layout;
use crate::trains::parts::collection::{Coordinates, Course, Parts, TorquePart};
use crate::trains::train_error::{TrainError, Warning};

/// The torques in the order of their constants: over the angle, over the speed, constant.
pub(crate) fn in_order<N>(parts: &Parts<N>) -> impl Iterator<Item = &TorquePart> {
    let over_angle = |torque: &&TorquePart| matches!(torque.course, Course::OfAngle(_));
    let over_speed = |torque: &&TorquePart| matches!(torque.course, Course::OfSpeed(_));
    let constant = |torque: &&TorquePart| torque.course == Course::Constant;
    let torques = &parts.torques;
    torques
        .iter()
        .filter(over_angle)
        .chain(torques.iter().filter(over_speed))
        .chain(torques.iter().filter(constant))
}

/// The mean of a torque over its constant, at the mean speed for one over the speed.
pub(crate) fn mean_factor(torque: &TorquePart) -> f64 {
    match &torque.course {
        Course::OfAngle(factor) => mean(factor),
        Course::Constant | Course::OfSpeed(_) => 1.0,
    }
}

/// Power of the torques in the rigid motion, as a share of that of all of them, above which they do not balance.
const BALANCED: f64 = 1e-6;

impl<N: Nonlinearity> Layout<'_, N> {
    /// Whether the torques must balance, and do. They need not if a load balances them, if they may be out of balance, or if
    /// something holds the train.
    ///
    /// # Errors
    /// [`Warning::Unbalanced`].
    pub(crate) fn balances(&self) -> Result<bool, TrainError> {
        let parts = self.parts;
        if parts.load.is_some() || !self.is_loose() || parts.accepted.contains(&Warning::Unbalanced) {
            return Ok(false);
        }
        let dof = self.angle.iter().chain(self.centre.iter().flatten()).flatten().count();
        let rigid = self.rigid(dof);
        let mut inertia = 0.0;
        for (body, (_, part)) in parts.bodies.iter().enumerate() {
            inertia += self.angle[body].map_or(0.0, |at| rigid[at] * rigid[at] * part.inertia);
            let mass = part.bearing.map_or(0.0, |bearing| bearing.mass);
            inertia +=
                self.centre[body].iter().flatten().map(|&at| mass * rigid[at] * rigid[at]).sum::<f64>();
        }
        let power = |torque: &TorquePart| {
            let body = parts.bodies.iter().position(|body| body.0 == torque.body).unwrap_or(0);
            self.kinematics.speeds[body].value().abs() * mean_factor(torque)
        };
        let (mut sum, mut size) = (0.0, 0.0f64);
        for torque in in_order(parts) {
            let power = power(torque) * torque.value;
            (sum, size) = (sum + power, size + power.abs());
        }
        if sum.abs() <= BALANCED * size {
            return Ok(true);
        }
        let message = format!(
            "the torques do not balance: they accelerate the reference body by {:e} rad/s²; Parts::load balances them",
            sum / inertia
        );
        Err(TrainError::Warning { warning: Warning::Unbalanced, message })
    }

    /// Whether neither support, drag nor a torque over the speed holds the rotation.
    fn is_loose(&self) -> bool {
        let mut turning = self.parts.bodies.iter().filter(|body| !body.1.held);
        let motors = self.parts.torques.iter().any(|torque| matches!(torque.course, Course::OfSpeed(_)));
        !motors && turning.all(|(_, body)| body.drag == 0.0 && body.support == [0.0; 2])
    }

    /// Whether the coordinates are relative: as stated, otherwise if torques act, balance, and nothing holds the train.
    pub(crate) fn is_relative(&self, balances: bool) -> bool {
        let parts = self.parts;
        match parts.coordinates {
            Some(coordinates) => coordinates == Coordinates::Relative,
            None => {
                let round = parts.meshes.iter().all(|(_, _, mesh)| mesh.is_round());
                let balanced = parts.load.is_some() || balances;
                let free = balanced && self.is_loose() && round && parts.rotating.is_none();
                free && !parts.torques.is_empty()
            }
        }
    }
}
