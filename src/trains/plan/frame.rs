//! Whether the torques balance, what holds the rotation, and the frame of the coordinates that follows from
//! both.

use crate::contact::Nonlinearity;
use crate::trains::parts::coordinates::Coordinates;
use crate::trains::parts::torque_part::{Course, TorquePart};
use crate::trains::plan::places::Planets;
use crate::trains::plan::topology::Topology;
use crate::trains::plan::turning::kinematics::Kinematics;
use crate::trains::train_error::{TrainError, Warning};

impl TorquePart {
    /// The mean of the torque over its constant, at the mean speed for one over the speed.
    pub(crate) fn mean_factor(&self) -> f64 {
        match &self.course {
            Course::OfAngle(factor) => factor.mean(),
            Course::Constant | Course::OfSpeed(_) => 1.0,
        }
    }
}

/// Largest power of torques that balance, as a share of the sum of their magnitudes.
const BALANCED: f64 = 1e-6;

impl<N: Nonlinearity> Topology<'_, N> {
    /// What holds the rotation, if anything does.
    fn holder(&self) -> Option<&'static str> {
        let turning = || self.bodies.iter().map(|(_, body)| body).filter(|body| !body.grounded);
        let over_speed = |torque: &TorquePart| matches!(torque.course, Course::OfSpeed(_));
        let holders = [
            (self.torques.iter().any(|(torque, _)| over_speed(torque)), "a torque over the speed"),
            (turning().any(|body| body.locked), "a prescribed rotation"),
            (turning().any(|body| body.drag != 0.0), "drag"),
            (turning().any(|body| body.support != [0.0; 2]), "the support of a body that turns"),
        ];
        holders.into_iter().find(|(holds, _)| *holds).map(|(_, part)| part)
    }
    /// A part that depends on the absolute motion, if there is one.
    fn absolute(&self) -> Option<&'static str> {
        let noncircular = self.meshes.iter().any(|mesh| !mesh.part.is_round());
        let frame = self.rotating.map(|_| "a rotating frame");
        frame.or(noncircular.then_some("a noncircular gear")).or(self.holder())
    }

    /// Whether the coordinates are relative: as stated, otherwise if torques act, balance, and nothing holds
    /// the train.
    ///
    /// # Errors
    /// [`Warning::Unbalanced`], unless a load balances the torques, they may be out of balance, or something
    /// holds the train; relative coordinates that are stated for a part that depends on the absolute motion.
    pub(crate) fn is_relative(&self, kinematics: &Kinematics, planets: &Planets) -> Result<bool, TrainError> {
        let must_balance =
            self.load.is_none() && self.holder().is_none() && !self.accepts(Warning::Unbalanced);
        if must_balance {
            self.balances(kinematics, planets)?;
        }
        match (self.coordinates, self.absolute()) {
            (Some(Coordinates::Relative), Some(part)) => Err(TrainError::NotRelative { part: part.into() }),
            (Some(coordinates), _) => Ok(coordinates == Coordinates::Relative),
            (None, Some(_)) => Ok(false),
            (None, None) => Ok((self.load.is_some() || must_balance) && !self.torques.is_empty()),
        }
    }

    fn balances(&self, kinematics: &Kinematics, planets: &Planets) -> Result<(), TrainError> {
        let speed = |body: usize| kinematics.speeds[body].value();
        let (mut sum, mut size) = (0.0, 0.0f64);
        for (torque, body) in &self.torques {
            let power = speed(*body).abs() * torque.mean_factor() * torque.value;
            (sum, size) = (sum + power, size + power.abs());
        }
        if sum.abs() <= BALANCED * size {
            return Ok(());
        }
        let mut inertia = 0.0;
        for (body, (_, part)) in self.bodies.iter().enumerate() {
            let pin = planets[body].as_ref().map_or(0.0, |planet| speed(planet.carrier) * planet.radius);
            let mass = part.bearing.map_or(0.0, |bearing| bearing.mass);
            inertia += part.inertia * speed(body) * speed(body) + mass * pin * pin;
        }
        let message = format!(
            "the torques do not balance: they accelerate the reference body by {:e} rad/s²; Parts::load balances \
             them",
            sum / inertia
        );
        self.warn(Warning::Unbalanced, message)
    }

    /// Whether something holds the train, as bodies that turn unevenly need.
    ///
    /// # Errors
    /// [`Warning::Drifts`].
    pub(crate) fn warns_of_drift(&self) -> Result<(), TrainError> {
        if self.holder().is_some() {
            return Ok(());
        }
        let message = "nothing holds the train to its uneven rotation, and deviations from it grow: restrain \
                       a body that turns evenly (Body::restrained), or give it drag or a torque over the speed";
        self.warn(Warning::Drifts, message.into())
    }
}
