//! The terms of a rotating frame, with the preload of planets by their centrifugal forces.

use crate::contact::Nonlinearity;
use crate::trains::assembly::builder::Builder;
use crate::trains::plan::places::Planet;
use crate::trains::shape::elements::{Entry, Rotating};
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
                (x, y, -damping, -2.0, 0.0, -1.0),
                (y, x, damping, 2.0, 0.0, 1.0),
                (x, x, 0.0, 0.0, -1.0, 0.0),
                (y, y, 0.0, 0.0, -1.0, 0.0),
            ];
            for (i, j, damping, gyroscopic, centripetal, euler) in terms {
                self.elements.rotating.push(Rotating { i, j, damping, gyroscopic, centripetal, euler });
            }
            if let Some(planet) = plan.planets[body].as_ref().filter(|_| topology.preloaded) {
                self.preload(planet, [x, y], bearing.mass);
            }
        }
        Ok(())
    }

    /// The centrifugal force m r Ω² of a planet, and the preload m (r Ω² inwards + r Ω' along the rotation)
    /// with which its bearing carries it. The preload turns with the carrier: in the rotating terms the
    /// displacement of the planet counts from its pin as the carrier turns, y = x - δ k × p with the angle δ
    /// of the carrier and the place p. A rigid rotation then has no force.
    ///
    /// m x'' = ... + m (Ω² y - Ω' k × y),   J δ'' = ... - m k·(p × (Ω² y + Ω' k × y))
    fn preload(&mut self, planet: &Planet, [x, y]: [usize; 2], mass: f64) {
        let (sin, cos) = libm::sincos(planet.angle);
        let [px, py] = [planet.radius * cos, planet.radius * sin];
        self.elements.outward.extend([Entry { at: x, by: px }, Entry { at: y, by: py }]);
        let Some(turn) = self.layout.angle[planet.carrier] else { return };
        let sense = self.layout.plan.kinematics.sense(planet.carrier);
        let share = sense * mass * self.per_inertia(turn);
        let terms = [
            (x, turn, -sense * py, sense * px),
            (y, turn, sense * px, sense * py),
            (turn, x, -share * py, share * px),
            (turn, y, share * px, share * py),
            (turn, turn, -share * sense * planet.radius * planet.radius, 0.0),
        ];
        for (i, j, centripetal, euler) in terms {
            let [damping, gyroscopic] = [0.0; 2];
            self.elements.rotating.push(Rotating { i, j, damping, gyroscopic, centripetal, euler });
        }
    }
}
