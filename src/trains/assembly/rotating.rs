//! The terms of a rotating frame.

use crate::contact::Nonlinearity;
use crate::trains::assembly::builder::Builder;
use crate::trains::shape::elements::Rotating;
use crate::trains::train_error::TrainError;

impl<N: Nonlinearity + Clone> Builder<'_, N> {
    /// Gyroscopic and centripetal terms of all masses, and dampers at rest, seen from a rotating frame.
    pub(crate) fn rotating(&mut self) -> Result<(), TrainError> {
        let plan = self.layout.plan;
        let topology = &plan.topology;
        let Some(carrier) = topology.rotating else { return Ok(()) };
        plan.turns_evenly("the rotating frame", carrier)?;
        for mesh in &topology.meshes {
            let moves = mesh.ends.iter().any(|&body| topology.body(body).bearing.is_some());
            if moves && mesh.carrier != Some(carrier) {
                let why = "its line of action stands still";
                return Err(TrainError::NotRotating { part: mesh.name.into(), why });
            }
        }
        // x and y are counterclockwise from each other; the frame turns with the sense of the carrier.
        self.elements.frame_ratio = plan.kinematics.speeds[carrier].value() / plan.orders.ratio;
        for (body, (name, part)) in topology.bodies.iter().enumerate() {
            let (Some(bearing), [x, Some(y)]) = (part.bearing, self.layout.centre[body]) else { continue };
            let planet = plan.planets[body].is_some();
            if bearing.half_clearance > 0.0 && !planet {
                let why = "a damper with a clearance has no term for the rotation";
                return Err(TrainError::NotRotating { part: name.clone(), why });
            }
            let [c, other] = bearing.damping;
            let isotropic = c == other && bearing.stiffness[0] == bearing.stiffness[1];
            let Some(x) = x.filter(|_| planet || isotropic) else {
                let why = "its directions turn in a rotating frame";
                return Err(TrainError::NotIsotropic { body: name.clone(), why });
            };
            // The damper of a planet's bearing turns with the carrier.
            let damping = if planet { 0.0 } else { c / bearing.mass };
            let terms = [
                (x, y, -damping, -2.0, 0.0),
                (y, x, damping, 2.0, 0.0),
                (x, x, 0.0, 0.0, -1.0),
                (y, y, 0.0, 0.0, -1.0),
            ];
            for (i, j, damping, gyroscopic, centripetal) in terms {
                self.elements.rotating.push(Rotating { i, j, damping, gyroscopic, centripetal });
            }
        }
        Ok(())
    }
}
