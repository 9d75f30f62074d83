//! The drawing of a train from its plan.

use crate::contact::Nonlinearity;
use crate::trains::assembly::rows::Layout;
use crate::trains::parts::mesh_part::Kind;
use crate::trains::plan::places::centre_distance;
use crate::trains::shape::drawing::{Drawing, DrawnBody, DrawnLink};

impl<N: Nonlinearity> Layout<'_, N> {
    /// φ over the angle of a body that turns evenly.
    fn ratio_to(&self, body: usize) -> Option<f64> {
        let speed = self.plan.kinematics.speeds[body].value().abs();
        (speed != 0.0 && self.plan.rotations[body].is_none()).then(|| self.plan.orders.ratio / speed)
    }
    pub(crate) fn drawing(&self) -> Drawing {
        let topology = &self.plan.topology;
        let body = |(i, (name, _)): (usize, &(String, _))| {
            let mut drawn = DrawnBody {
                name: name.clone(),
                centre: self.plan.centres[i],
                radius: 0.0,
                internal: false,
                carrier: topology.carriers[i],
                motion: self.motion(i),
                ratio: self.ratio_to(i),
            };
            for mesh in &topology.meshes {
                let inner = [Kind::FirstInternal, Kind::SecondInternal];
                for end in (0..2).filter(|&end| mesh.ends[end] == i) {
                    let radius = mesh.part.radii[end] / libm::cos(mesh.part.pressure_angle);
                    if radius > drawn.radius {
                        drawn.radius = radius;
                        drawn.internal = mesh.part.kind == inner[end];
                    }
                }
            }
            drawn
        };
        let link = |ends, distance| DrawnLink { ends, distance };
        let meshes = topology.meshes.iter().map(|mesh| link(mesh.ends, Some(centre_distance(mesh.part))));
        let shafts = topology.shafts.iter().map(|(_, ends)| link(*ends, None));
        Drawing {
            bodies: topology.bodies.iter().enumerate().map(body).collect(),
            links: meshes.chain(shafts).collect(),
        }
    }
}
