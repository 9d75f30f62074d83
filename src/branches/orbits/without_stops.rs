//! A model without some of its rigid stops.

use crate::contact::Piece;
use crate::contact::edge::Edge;
use crate::model::{Jacobian, Model, Offers, Periodic};

/// A model without the impacts on some of its rigid stops.
///
/// Along the grazing of a stop the orbits touch it. Rounding would decide whether they strike it, and an
/// impact of any speed changes their derivatives without bound. Without the stop the orbit and the distance
/// are smooth.
pub(crate) struct WithoutStops<'m> {
    model: Box<dyn Periodic + 'm>,
    /// The stops that are left.
    stops: Vec<[bool; 2]>,
}

impl<'m> WithoutStops<'m> {
    /// `out`: the contacts and edges whose stops are left out.
    pub(crate) fn new(model: Box<dyn Periodic + 'm>, out: &[(usize, Edge)]) -> Self {
        let mut stops = model.offers().rigid_edges(model.contacts());
        for (contact, rigid) in stops.iter_mut().enumerate() {
            Edge::BOTH.iter().for_each(|edge| rigid[*edge as usize] &= !out.contains(&(contact, *edge)));
        }
        WithoutStops { model, stops }
    }
}

impl Model for WithoutStops<'_> {
    fn dof(&self) -> usize {
        self.model.dof()
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.model.accel(u, q, v, a);
    }
    fn base(&self) -> Option<&dyn Model> {
        Some(&*self.model)
    }
    fn offers(&self) -> Offers<'_> {
        Offers { stops: &self.stops, ..self.model.offers() }
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.model.accel_on_pieces(pieces, u, q, v, a);
    }
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) {
        self.model.jacobian(pieces, u, q, v, out);
    }
}

impl Periodic for WithoutStops<'_> {
    fn period(&self) -> f64 {
        self.model.period()
    }
}
