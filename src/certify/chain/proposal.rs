//! What a proof begins with: nodes, legs and the sequence of contacts, in plain numbers.

use crate::certify::chain::marks::MarkedTurn;
use crate::certify::chain::walk::NodeWalk;
use crate::certify::flow::field::Field;
use crate::certify::flow::leg::Leg;
use crate::certify::unproved::Unproved;
use crate::interval::number::Interval;
use crate::model::Periodic;
use crate::ode::budget::Meter;
use crate::periodic::ShootingOrbit;

/// Nodes of a closed chain with the legs between them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Proposal {
    pub(crate) legs: Vec<Leg>,
    /// Coordinates, then velocities, at the start of each leg; relative ones apart from a rigid motion.
    pub(crate) nodes: Vec<Vec<f64>>,
    /// The coordinate to which all others are relative, if a rigid motion is left out.
    pub(crate) relative_to: Option<usize>,
}

impl Proposal {
    /// The chain along an orbit. `scale`: size of the motion, of coordinates and velocities; `shorter`: the
    /// share of the steps that is taken.
    pub(crate) fn along(
        orbit: &ShootingOrbit,
        model: &dyn Periodic,
        field: &Field<'_>,
        scale: &[f64],
        shorter: f64,
        meter: &Meter<'_>,
    ) -> Result<Self, Unproved> {
        let turn = MarkedTurn::of(orbit, model, meter)?;
        let end = Interval::from(turn.start) + field.drives.period() * orbit.period_multiple() as f64;
        let mut walk = NodeWalk::of(&turn, model, field, scale, shorter, meter);
        walk.through(&turn.marks, end)?;
        let relative_to = field.relative.as_ref().map(|relative| relative.root);
        Ok(Proposal { legs: walk.legs, nodes: walk.nodes, relative_to })
    }
}
