//! Meshes, clearances of shafts, and bearings of a train.

use crate::contact::{Backlash, Mesh, Nonlinearity};
use crate::excitation::Wave;
use crate::model::Channel;
use crate::trains::assembly::builder::{ABOUT, ALONG, Builder};
use crate::trains::assembly::rows::Row;
use crate::trains::plan::topology::Gearing;
use crate::trains::shape::elements::{Friction, Journal, Lever};
use crate::trains::train_error::TrainError;
use std::ops::Range;

impl<N: Nonlinearity + Clone> Builder<'_, N> {
    pub(crate) fn meshes(&mut self) -> Result<(), TrainError> {
        let plan = self.layout.plan;
        for (mesh, phase) in plan.topology.meshes.iter().zip(&plan.phases) {
            let (name, part) = (mesh.name, mesh.part);
            let [mut row, friction_row] = self.layout.mesh(mesh)?;
            let varying = self.levers_that_vary(mesh, &mut row)?;
            let waves = plan.waves(mesh, *phase)?;
            self.fastest = self.fastest.max(waves.order.unwrap_or(1));
            // The algebra reads stiffness and error by their places among the waves of the train.
            let contact = Mesh::of_law(mesh.law.clone())
                .with_contact_damping(part.contact_damping)
                .per_turn(waves.order.unwrap_or(1))?;
            let half = N::HALF_BACKLASH.then_some(("half backlash", part.half_backlash));
            let channel = self.contact(name, ALONG, part.damping, half);
            self.tooth(channel, &row, varying, [waves.stiffness, waves.error], contact);
            if let (Some(friction), Some(sign)) = (&part.friction, waves.sign) {
                let (pulls, sign) = (self.kept_pulls(&friction_row), self.elements.single(sign));
                let tooth = self.teeth.len() - 1;
                self.elements.frictions.push(Friction { tooth, sign, pulls });
                let constant = Channel::new(format!("{name} friction"), "1");
                self.constants.frictions.push((constant, friction.coefficient));
            }
        }
        Ok(())
    }

    /// Moves the levers of noncircular gears out of the row of a mesh.
    fn levers_that_vary(&mut self, mesh: &Gearing<N>, row: &mut Row) -> Result<Range<usize>, TrainError> {
        let (start, orders) = (self.elements.varying.len(), &self.layout.plan.orders);
        for (factor, body) in mesh.part.radius_of_turn.iter().zip(mesh.ends) {
            let (Some(factor), Some(at)) = (factor, self.layout.angle[body]) else { continue };
            let Some(place) = row.0.iter().position(|entry| entry.at == at) else { continue };
            let lever = row.0.remove(place).by;
            let wave = self.elements.jet(orders.wave(mesh.name, factor, orders.turn(body))?);
            self.elements.varying.push(Lever { at, lever, pull: lever * self.per_inertia(at), wave });
        }
        Ok(start..self.elements.varying.len())
    }

    /// Shafts with a clearance. Like all contacts of these trains they have a [`Backlash`].
    pub(crate) fn couplings(&mut self) -> Result<(), TrainError> {
        let topology = &self.layout.plan.topology;
        for (shaft, ends) in &topology.shafts {
            let Some((half, law)) = &shaft.part.clearance else { continue };
            let row = self.layout.shaft(*ends);
            let contact = Mesh::of_law(law.clone());
            let channel =
                self.contact(&shaft.name, ABOUT, shaft.part.damping, Some(("half clearance", *half)));
            self.tooth(channel, &row, 0..0, [Wave::constant(shaft.part.stiffness)?, Wave::zero()], contact);
        }
        Ok(())
    }

    pub(crate) fn bearings(&mut self) -> Result<(), TrainError> {
        for (body, (name, part)) in self.layout.plan.topology.bodies.iter().enumerate() {
            let Some(bearing) = part.bearing else { continue };
            let rows = self.layout.bearing(body);
            if bearing.half_clearance == 0.0 {
                for (axis, row) in rows.iter().enumerate() {
                    let name = format!("{name} bearing {}", ["x", "y"][axis]);
                    self.spring(name, row, bearing.stiffness[axis], bearing.damping[axis]);
                }
                continue;
            }
            let levers = rows.each_ref().map(|row| self.elements.kept(&self.levers(row)));
            let pulls = rows.each_ref().map(|row| self.kept_pulls(row));
            let (stiffness, law) = (bearing.stiffness[0], Backlash::new(0.0)?);
            let least = (1e-9 * bearing.half_clearance).powi(2);
            let half = Some(("half clearance", bearing.half_clearance));
            let Channel { name, .. } =
                self.contact(&format!("{name} bearing"), ALONG, bearing.damping[0], half);
            self.elements.journals.push(Journal { name, levers, pulls, stiffness, least, law });
        }
        Ok(())
    }
}
