//! Rates of inner kinks.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::Model;
use crate::model::structure::slopes::accelerate;

/// The rates of the contacts that are inner kinks of contact laws. A model does not give them, since they
/// contain its accelerations.
pub(super) struct KinkRates {
    /// Index of the first inner kink.
    first: usize,
    /// Drives, coordinates, velocities and contacts a short time later or earlier.
    u: Vec<f64>,
    q: Vec<f64>,
    v: Vec<f64>,
    contacts: Vec<Contact>,
    /// Accelerations.
    a: Vec<f64>,
    /// Number of evaluations of the accelerations.
    pub(super) evaluations: u64,
}

/// Time over which the rates are differences, as a share of the step `[1]`. The rates serve to choose
/// instants and directions; what is located is the deflection.
const SPAN: f64 = 1e-6;

impl KinkRates {
    /// Room for the rates of a model whose drives at some instant are `u`.
    pub(super) fn new(model: &dyn Model, u: &[f64]) -> Self {
        let (contacts, kinks) = (model.contacts(), model.offers().kinks);
        let needed = |length: usize| if kinks > 0 { length } else { 0 };
        let motion = || vec![0.0; needed(model.dof())];
        KinkRates {
            first: model.offers().touching(contacts),
            u: u[..needed(u.len())].to_vec(),
            q: motion(),
            v: motion(),
            contacts: vec![Contact::default(); needed(contacts)],
            a: motion(),
            evaluations: 0,
        }
    }

    /// Writes s' = (s(t + δ) - s(t))/δ for the deflection s of each inner kink, along q' = v and v' = a on
    /// `pieces`. `h`: length of the step, negative at its end; for 0 the rates remain as they are.
    #[inline(always)]
    pub(super) fn write(
        &mut self,
        model: &dyn Model,
        pieces: &[Piece],
        [t, h]: [f64; 2],
        [u, q, v]: [&[f64]; 3],
        contacts: &mut [Contact],
    ) {
        if self.first < contacts.len() {
            self.difference(model, pieces, [t, h], [u, q, v], contacts);
        }
    }

    #[cold]
    fn difference(
        &mut self,
        model: &dyn Model,
        pieces: &[Piece],
        [t, h]: [f64; 2],
        [u, q, v]: [&[f64]; 3],
        contacts: &mut [Contact],
    ) {
        let delta = (t + SPAN * h) - t;
        if delta == 0.0 {
            return;
        }
        self.evaluations += 1;
        accelerate(model, Some(pieces), u, q, v, &mut self.a);
        for j in 0..q.len() {
            self.q[j] = q[j] + delta * v[j];
            self.v[j] = v[j] + delta * self.a[j];
        }
        let side = if delta < 0.0 { Side::Before } else { Side::After };
        model.redrive(&[t + delta], side, &mut self.u);
        model.contact(&self.u, &self.q, &self.v, &mut self.contacts);
        for (here, there) in contacts.iter_mut().zip(&self.contacts).skip(self.first) {
            here.rate = (there.deflection - here.deflection) / delta;
        }
    }
}
