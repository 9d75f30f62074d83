//! A model without some of its rigid stops.

use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::excitation::side::Side;
use crate::model::constants::Constants;
use crate::model::equations::{Channel, Jacobian, Model, Periodic};
use crate::model::expansion::expand::Expand;
use crate::model::offers::Offers;
use crate::model::terms::Terms;

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
    /// `out`: the contacts and flanks whose stops are left out.
    pub(crate) fn new(model: Box<dyn Periodic + 'm>, out: &[(usize, Piece)]) -> Self {
        let mut stops = model.offers().rigid_edges(model.contacts());
        for (contact, rigid) in stops.iter_mut().enumerate() {
            rigid[0] &= !out.contains(&(contact, Piece::Lower));
            rigid[1] &= !out.contains(&(contact, Piece::Upper));
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
    fn offers(&self) -> Offers<'_> {
        Offers { stops: &self.stops, ..self.model.offers() }
    }
    fn drives(&self) -> usize {
        self.model.drives()
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.model.drive(t, side, u);
    }
    fn redrive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.model.redrive(t, side, u);
    }
    fn redrive_nodes(&self, times: &[f64], u: &mut [f64]) {
        self.model.redrive_nodes(times, u);
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        self.model.next_edge(t)
    }
    fn contacts(&self) -> usize {
        self.model.contacts()
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        self.model.contact(u, q, v, out);
    }
    fn expand(&self) -> Option<&dyn Expand> {
        self.model.expand()
    }
    fn named_constants(&self) -> Option<&dyn Constants> {
        self.model.named_constants()
    }
    fn terms(&self) -> Option<&dyn Terms> {
        self.model.terms()
    }
    fn impact(&self, contact: usize, on: Piece, u: &[f64], q: &[f64], v: &mut [f64]) {
        self.model.impact(contact, on, u, q, v);
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.model.accel_on_pieces(pieces, u, q, v, a);
    }
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) {
        self.model.jacobian(pieces, u, q, v, out);
    }
    fn channels(&self) -> Vec<Channel> {
        self.model.channels()
    }
    fn observe(&self, u: &[f64], q: &[f64], v: &[f64], contacts: &[Contact], out: &mut [f64]) {
        self.model.observe(u, q, v, contacts, out);
    }
}

impl Periodic for WithoutStops<'_> {
    fn period(&self) -> f64 {
        self.model.period()
    }
}
