//! Torques of a train.

use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::model::equations::Channel;
use crate::trains::assembly::assemble::{Assembly, once};
use crate::trains::assembly::train_error::TrainError;
use crate::trains::parts::collection::{Course, TorquePart};
use crate::trains::shape::elements::Motor;

impl<N: Nonlinearity + Clone> Assembly<'_, N> {
    /// Torques: waves and motors first, then those that are constant.
    pub(crate) fn torques(&mut self) -> Result<(), TrainError> {
        let parts = self.layout.parts;
        let constant = |torque: &&TorquePart| torque.course == Course::Constant;
        let waves = parts.torques.iter().filter(|torque| matches!(torque.course, Course::OfAngle(_)));
        let motors = parts.torques.iter().filter(|torque| matches!(torque.course, Course::OfSpeed(_)));
        for (place, torque) in waves.chain(motors).enumerate() {
            let body = self.names.place(&torque.name, &torque.body)?;
            // A torque drives: its pull is that of a force against its row.
            let row = self.layout.own(body, -1.0);
            let pulls = self.pulls(&row);
            let pulls = self.kept(&pulls);
            match &torque.course {
                Course::OfAngle(wave) => {
                    self.follows(&torque.name, body)?;
                    let wave = self.orders.wave(&torque.name, wave, self.orders.turn(body))?;
                    let wave = once(&mut self.shape.single, wave);
                    self.shape.torque_waves.push((wave, place, pulls));
                }
                Course::OfSpeed(characteristic) => self.shape.motors.push(Motor {
                    at: self.layout.angle[body].unwrap_or(0),
                    pulls,
                    ratio: self.layout.kinematics.speeds[body].value().abs() / self.orders.ratio,
                    rotation: self.rotations[body].clone().map(|wave| once(&mut self.shape.jets, wave)),
                    torque: place,
                    characteristic: characteristic.clone(),
                }),
                Course::Constant => {}
            }
            self.shape.torques.push(Vec::new());
            self.torque_values.push((Channel::new(&torque.name, "N m"), torque.value));
        }
        for torque in parts.torques.iter().filter(constant) {
            let body = self.names.place(&torque.name, &torque.body)?;
            let row = self.layout.own(body, 1.0);
            self.shape.torques.push(if self.dropped.is_some() { self.pulls(&row) } else { row.0 });
            self.torque_values.push((Channel::new(&torque.name, "N m"), torque.value));
        }
        Ok(())
    }
}
