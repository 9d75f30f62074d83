//! Pointers to models.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::channel::Channel;
use crate::model::equations::{Model, Offers, Periodic};
use crate::model::jacobian::Jacobian;
use std::ops::Deref;
use std::rc::Rc;
use std::sync::Arc;

/// A pointer that is a model or an integrator if it points to one.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a model or integrator, or has no period where one is needed",
    note = "implement `Model`, and `Periodic` for a model whose drives repeat; `from_fn(..)?.with_period(T)?` gives a \
            formula a period"
)]
pub trait Pointer: Deref {}

impl<M: ?Sized> Pointer for &M {}
impl<M: ?Sized> Pointer for Box<M> {}
impl<M: ?Sized> Pointer for Rc<M> {}
impl<M: ?Sized> Pointer for Arc<M> {}

/// `&M`, `Box<M>`, `Rc<M>` and `Arc<M>` are models as M is; M may be `dyn Model`.
impl<P: Pointer<Target: Model>> Model for P {
    fn dof(&self) -> usize {
        (**self).dof()
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        (**self).accel(u, q, v, a);
    }
    fn base(&self) -> Option<&dyn Model> {
        (**self).base()
    }
    fn drives(&self) -> usize {
        (**self).drives()
    }
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        (**self).drive(t, side, u);
    }
    fn redrive(&self, times: &[f64], side: Side, u: &mut [f64]) {
        (**self).redrive(times, side, u);
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        (**self).next_edge(t)
    }
    fn next_knot(&self, t: f64) -> Option<f64> {
        (**self).next_knot(t)
    }
    fn contacts(&self) -> usize {
        (**self).contacts()
    }
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        (**self).contact(u, q, v, out);
    }
    fn offers(&self) -> Offers<'_> {
        (**self).offers()
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        (**self).accel_on_pieces(pieces, u, q, v, a);
    }
    fn accel_of_one(&self, pieces: Option<&[Piece]>, u: &[f64], q: f64, v: f64) -> f64 {
        (**self).accel_of_one(pieces, u, q, v)
    }
    fn itself(&self) -> Option<&dyn Model> {
        (**self).itself()
    }
    fn jacobian(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], out: &mut Jacobian) {
        (**self).jacobian(pieces, u, q, v, out);
    }
    fn impact(&self, contact: usize, on: Piece, u: &[f64], q: &[f64], v: &mut [f64]) {
        (**self).impact(contact, on, u, q, v);
    }
    fn channels(&self) -> Vec<Channel> {
        (**self).channels()
    }
    fn write_channels(&self, u: &[f64], q: &[f64], v: &[f64], contacts: &[Contact], out: &mut [f64]) {
        (**self).write_channels(u, q, v, contacts, out);
    }
}

impl<P: Pointer<Target: Periodic>> Periodic for P {
    fn period(&self) -> f64 {
        (**self).period()
    }
}
