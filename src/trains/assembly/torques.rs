//! Torques of a train.

use crate::contact::laws::nonlinearity::Nonlinearity;
use crate::model::channel::Channel;
use crate::trains::assembly::assemble::{Assembly, once};
use crate::trains::assembly::balance::{in_order, mean_factor};
use crate::trains::assembly::rows::Row;
use crate::trains::parts::collection::Course;
use crate::trains::shape::elements::Motor;
use crate::trains::train_error::TrainError;

impl<N: Nonlinearity + Clone> Assembly<'_, N> {
    /// Torques, and the load that balances them.
    pub(crate) fn torques(&mut self) -> Result<(), TrainError> {
        let parts = self.layout.parts;
        let speed = |body: usize| self.layout.kinematics.speeds[body].value().abs();
        let part = "the load";
        let load = parts.load.as_ref().map(|body| self.names.place(part, body)).transpose()?;
        if load.is_some_and(|body| speed(body) == 0.0 || self.layout.angle[body].is_none()) {
            return Err(TrainError::AtRest { part: part.into() });
        }
        for (place, torque) in in_order(parts).enumerate() {
            let body = self.names.place(&torque.name, &torque.body)?;
            // A torque drives: its pull is that of a force against its row.
            let driven = self.layout.own(body, -1.0);
            let mut row = Row::default();
            if torque.course == Course::Constant {
                row = self.layout.own(body, 1.0);
            }
            if let Some((load, at)) = load.and_then(|load| Some((load, self.layout.angle[load]?))) {
                row.add(at, -speed(body) / speed(load) * mean_factor(torque));
            }
            match &torque.course {
                Course::OfAngle(wave) => {
                    self.follows(&torque.name, body)?;
                    let wave = self.orders.wave(&torque.name, wave, self.orders.turn(body))?;
                    let wave = once(&mut self.shape.single, wave);
                    let pulls = self.kept_pulls(&driven);
                    self.shape.torque_waves.push((wave, place, pulls));
                }
                Course::OfSpeed(characteristic) => {
                    let motor = Motor {
                        at: self.layout.angle[body].unwrap_or(0),
                        pulls: self.kept_pulls(&driven),
                        ratio: speed(body) / self.orders.ratio,
                        rotation: self.rotations[body].clone().map(|wave| once(&mut self.shape.jets, wave)),
                        torque: place,
                        characteristic: characteristic.clone(),
                    };
                    self.shape.motors.push(motor);
                }
                Course::Constant => {}
            }
            self.shape.torques.push(if self.dropped.is_some() { self.pulls(&row) } else { row.0 });
            self.torque_values.push((Channel::new(&torque.name, "N m"), torque.value));
        }
        Ok(())
    }
}
