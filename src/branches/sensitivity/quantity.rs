//! Quantities along an orbit whose derivatives are computed.

use crate::contact::edge::Edge;
use crate::excitation::Side;
use crate::ode::probe::Probe;

/// A number at each instant of an orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Quantity {
    /// A channel of the model, by its index.
    Channel(usize),
    /// Deflection of a contact minus its edge.
    Distance { contact: usize, edge: Edge },
}

impl Quantity {
    pub(crate) fn read(self, probe: &mut Probe<'_>, t: f64, side: Side, q: &[f64], v: &[f64]) -> f64 {
        match self {
            Quantity::Channel(index) => probe.read(t, side, q, v)[index],
            Quantity::Distance { contact, edge } => {
                edge.distance(&probe.read_contacts(t, side, q, v)[contact])
            }
        }
    }
}
