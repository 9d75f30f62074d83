//! The motion of a model backwards in time, with the change of the density along it.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::equations::each_row;
use crate::model::{Model, Offers};

/// A model of one degree of freedom run backwards from the time `end`, without its mean damping κ:
///
/// x'' = f(x, v), f = a(u(t), x, v) + κ v. With s = end - t, w = dx/ds = -v: dw/ds = f(x, -w).
///
/// Along the motion the density follows d(ln p)/dt = -∂f/∂v. The velocity of a second coordinate is the
/// logarithm of p(end)/p(end - s): its acceleration is -∂f/∂v.
pub(crate) struct Reversed<'m> {
    pub(crate) base: &'m (dyn Model + Sync),
    pub(crate) end: f64,
    /// κ [1/time].
    pub(crate) damping: f64,
    /// Half width of the differences over the velocity.
    pub(crate) width: f64,
}

impl Reversed<'_> {
    /// Writes both accelerations, from the base's acceleration as a function of the velocity.
    fn write(&self, w: &[f64], a: &mut [f64], accel: impl Fn(&[f64], &mut [f64])) {
        let at = |v: f64| {
            let mut out = [0.0];
            accel(&[v], &mut out);
            out[0]
        };
        let v = -w[0];
        a[0] = at(v) + self.damping * v;
        a[1] = -((at(v + self.width) - at(v - self.width)) / (2.0 * self.width) + self.damping);
    }
}

impl Model for Reversed<'_> {
    fn dof(&self) -> usize {
        2
    }
    fn accel(&self, u: &[f64], q: &[f64], w: &[f64], a: &mut [f64]) {
        self.write(w, a, |v, out| self.base.accel(u, &q[..1], v, out));
    }
    fn drives(&self) -> usize {
        self.base.drives()
    }
    fn drive(&self, s: f64, side: Side, u: &mut [f64]) {
        self.base.drive(self.end - s, opposite(side), u);
    }
    fn redrive(&self, times: &[f64], side: Side, u: &mut [f64]) {
        each_row(self.drives(), times, u, |s, u| {
            self.base.redrive(&[self.end - s], opposite(side), u);
        });
    }
    fn contacts(&self) -> usize {
        self.base.contacts()
    }
    fn contact(&self, u: &[f64], q: &[f64], w: &[f64], out: &mut [Contact]) {
        self.base.contact(u, &q[..1], &[-w[0]], out);
        for contact in out {
            contact.rate = -contact.rate;
            contact.lower_rate = -contact.lower_rate;
            contact.upper_rate = -contact.upper_rate;
        }
    }
    fn offers(&self) -> Offers<'_> {
        let Offers { pieces, kinks, .. } = self.base.offers();
        Offers { pieces, kinks, ..Offers::default() }
    }
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], w: &[f64], a: &mut [f64]) {
        self.write(w, a, |v, out| self.base.accel_on_pieces(pieces, u, &q[..1], v, out));
    }
}

fn opposite(side: Side) -> Side {
    match side {
        Side::Before => Side::After,
        Side::After => Side::Before,
    }
}
