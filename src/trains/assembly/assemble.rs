//! Makes the shape and its constants from the parts.

use crate::contact::Nonlinearity;
use crate::trains::assembly::builder::Builder;
use crate::trains::assembly::rows::Layout;
use crate::trains::parts::collection::Parts;
use crate::trains::plan::train_plan::Plan;
use crate::trains::shape::elements::{Entry, Uneven};
use crate::trains::shape::train_shape::Train;
use crate::trains::train_error::TrainError;

impl Parts {
    /// Checks the parts and makes the model. `body` turns at the mean speed `speed` [rad/s]; the speeds of
    /// all others follow from tooth numbers.
    ///
    /// # Errors
    /// A value out of range, with its name; two parts with the same name; a name that does not exist; a mesh
    /// of a body with itself; a loop that cannot turn; a body whose speed does not follow; radii or phases
    /// that contradict tooth numbers; planets that do not assemble; [`Warning`](crate::trains::Warning)s that
    /// have not been accepted.
    pub fn build(&self, body: &str, speed: f64) -> Result<Train, TrainError> {
        assemble(self, body, speed)
    }
}

impl<N: Nonlinearity + Clone> Parts<N> {
    /// [`build`](Parts::build) for parts with another law than [`Backlash`](crate::Backlash)
    /// ([`MeshPart::law`](crate::trains::MeshPart::law)). The code of such a train is compiled in the program
    /// that calls it.
    ///
    /// # Errors
    /// As [`build`](Parts::build).
    pub fn build_with_laws(&self, body: &str, speed: f64) -> Result<Train<N>, TrainError> {
        assemble(self, body, speed)
    }
}

fn assemble<N: Nonlinearity + Clone>(
    parts: &Parts<N>,
    body: &str,
    speed: f64,
) -> Result<Train<N>, TrainError> {
    let plan = Plan::of(parts, body)?;
    let mut builder = Builder::of(&plan);
    builder.linear();
    builder.uneven();
    builder.torques()?;
    builder.meshes()?;
    builder.couplings()?;
    builder.bearings()?;
    builder.rotating()?;
    builder.train(speed)
}

impl<N: Nonlinearity + Clone> Builder<'_, N> {
    /// Shafts without clearance, and what holds bodies to the ground.
    fn linear(&mut self) {
        let topology = &self.layout.plan.topology;
        for (shaft, ends) in topology.shafts.iter().filter(|(shaft, _)| shaft.part.clearance.is_none()) {
            let row = self.layout.shaft(*ends);
            self.spring(shaft.name.clone(), &row, shaft.part.stiffness, shaft.part.damping);
        }
        for (body, (name, part)) in topology.bodies.iter().enumerate() {
            let row = self.layout.own(body, 1.0);
            let [stiffness, damping] = part.support;
            self.spring(format!("{name} support"), &row, stiffness, damping + part.drag);
        }
    }

    /// Accelerations of the coordinates by φ'' = 1. The bodies lag behind their ideal rotation by their
    /// inertia; a torque on the reference body accelerates them all along it, unless a body whose rotation is
    /// prescribed does. Bodies that turn unevenly are not among them.
    pub(crate) fn inertia(&self) -> Vec<f64> {
        let Layout { plan, angle, masses, .. } = &self.layout;
        let mut rates: Vec<f64> = self.layout.rigid().iter().map(|rate| rate / plan.orders.ratio).collect();
        for (_, at) in plan.rotations.iter().zip(angle).filter(|(rotation, _)| rotation.is_some()) {
            at.iter().for_each(|at| rates[*at] = 0.0);
        }
        let mut inertia = match &self.frame {
            None => rates.iter().map(|rate| -rate).collect(),
            // The bodies lag along the rigid motion, which is left out.
            Some(_) => vec![0.0; masses.len() - 1],
        };
        if self.is_driven() {
            return inertia;
        }
        let torque =
            plan.orders.ratio * masses.iter().zip(&rates).map(|(m, rate)| m * rate * rate).sum::<f64>();
        for entry in self.pulls(&self.layout.own(plan.topology.reference, torque)) {
            inertia[entry.at] += entry.by;
        }
        inertia
    }

    /// Whether a body whose rotation is prescribed drives the train.
    fn is_driven(&self) -> bool {
        self.layout.plan.topology.bodies.iter().any(|(_, body)| body.is_prescribed())
    }

    /// The accelerations of bodies that turn unevenly.
    fn uneven(&mut self) {
        let plan = self.layout.plan;
        for (body, rotation) in plan.rotations.iter().enumerate() {
            if let (Some(wave), Some(at)) = (rotation, self.layout.angle[body]) {
                let ratio = plan.kinematics.speeds[body].value().abs() / plan.orders.ratio;
                let wave = self.elements.jet(wave.clone());
                // The power J θ'' θ' over the speed of the reference body is the torque on it.
                let torque = self.layout.masses[at] * ratio * ratio * plan.orders.ratio;
                let driver = self.layout.angle[plan.topology.reference].filter(|_| !self.is_driven());
                let driver = driver.map(|at| Entry { at, by: torque * self.per_inertia(at) });
                self.elements.uneven.push(Uneven { at, ratio, wave, driver });
            }
        }
    }
}
