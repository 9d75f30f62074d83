//! Torques of a train.

use crate::contact::Nonlinearity;
use crate::model::Channel;
use crate::trains::assembly::builder::Builder;
use crate::trains::assembly::rows::Row;
use crate::trains::parts::torque_part::Course;
use crate::trains::shape::elements::Motor;
use crate::trains::train_error::TrainError;

impl<N: Nonlinearity + Clone> Builder<'_, N> {
    /// Torques in the order of their constants, and the load that balances them.
    pub(crate) fn torques(&mut self) -> Result<(), TrainError> {
        let plan = self.layout.plan;
        let speed = |body: usize| plan.kinematics.speeds[body].value().abs();
        let load = plan.topology.load.map(|load| match self.layout.angle[load] {
            Some(at) if speed(load) != 0.0 => Ok((at, speed(load))),
            _ => Err(TrainError::AtRest { part: "the load".into() }),
        });
        let load = load.transpose()?;
        let mut torques: Vec<_> = plan.topology.torques.iter().collect();
        torques.sort_by_key(|(torque, _)| match torque.course {
            Course::OfAngle(_) => 0,
            Course::OfSpeed(_) => 1,
            Course::Constant => 2,
        });
        for (place, &&(torque, body)) in torques.iter().enumerate() {
            // A torque drives: its pull is that of a force against its row.
            let driven = self.layout.own(body, -1.0);
            let mut row = Row::default();
            match &torque.course {
                Course::OfAngle(wave) => {
                    plan.turns_evenly(&torque.name, body)?;
                    let wave = plan.orders.wave(&torque.name, wave, plan.orders.turn(body))?;
                    let (wave, pulls) = (self.elements.single(wave), self.kept_pulls(&driven));
                    self.elements.torque_waves.push((wave, place, pulls));
                }
                Course::OfSpeed(characteristic) => {
                    let motor = Motor {
                        at: self.layout.angle[body].unwrap_or(0),
                        pulls: self.kept_pulls(&driven),
                        ratio: speed(body) / plan.orders.ratio,
                        rotation: plan.rotations[body].clone().map(|wave| self.elements.jet(wave)),
                        torque: place,
                        characteristic: characteristic.clone(),
                    };
                    self.elements.motors.push(motor);
                }
                Course::Constant => row = self.layout.own(body, 1.0),
            }
            if let Some((at, of_load)) = load {
                row.add(at, -speed(body) / of_load * torque.mean_factor());
            }
            self.torques.push(if self.frame.is_some() { self.pulls(&row) } else { row.0 });
            self.constants.torques.push((Channel::new(&torque.name, "N m"), torque.value));
        }
        Ok(())
    }
}
