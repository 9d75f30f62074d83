//! The variational equations as a model: a model together with small differences of its motion.

use crate::contact::{Contact, Piece};
use crate::model::drive_slope::DriveSlope;
use crate::model::expansion::expand::{Expand, Recorded};
use crate::model::structure::slopes::{Slopes, accelerate};
use crate::model::{Model, Offers, State};
use crate::numeric::norms::largest_share;
use crate::ode::Taylor;
use crate::periodic::flow::continued::Continued;
use crate::periodic::flow::flow_method::Expansion;
use crate::periodic::flow::tangent_tape::tangent;
use crate::series::Series;
use crate::tape::recording::Recording;
use std::cell::RefCell;

/// q'' = a(u, q, q') together with δq'' = ∂a/∂q δq + ∂a/∂v δv, for any number of differences.
///
/// The last differences are those with respect to parameters, at a fixed phase (see
/// [`tangent`](crate::periodic::flow::tangent_tape::tangent)). The coordinates are (q, δq_1, δq_2, ...); the
/// velocities have the same order. The contacts are those of the model alone. The Jacobian is that of the
/// model on fixed pieces, or central differences if the model has none.
pub(crate) struct Tangent<'m> {
    pub(crate) model: Continued<'m>,
    pub(crate) n: usize,
    /// Number of all differences.
    pub(crate) columns: usize,
    /// Slopes of the drives with respect to the parameters of the last differences.
    pub(crate) forced: &'m [DriveSlope],
    /// Sizes of coordinates and velocities.
    pub(crate) scale: &'m [f64],
    pub(crate) slopes: RefCell<Slopes<'m>>,
    /// Scratch: drives and contacts of a state.
    pub(crate) at_rest: RefCell<(Vec<f64>, Vec<Contact>)>,
    pub(crate) expansion: &'m Expansion,
    /// Order of the Taylor series.
    pub(crate) order: usize,
}

impl<'m> Tangent<'m> {
    pub(crate) fn new(
        model: &'m dyn Model,
        columns: usize,
        forced: &'m [DriveSlope],
        scale: &'m [f64],
        tolerance: f64,
        expansion: &'m Expansion,
    ) -> Self {
        let n = model.dof();
        let slopes = RefCell::new(Slopes::new(model, scale.to_vec(), tolerance));
        let at_rest = RefCell::new((vec![0.0; model.drives()], vec![Contact::default(); model.contacts()]));
        let order = Taylor::order_for(tolerance);
        let model = Continued::new(model, scale);
        Tangent { model, n, columns, forced, scale, slopes, at_rest, expansion, order }
    }

    /// Largest component of difference k, in units of `scale`.
    pub(crate) fn size(&self, k: usize, q: &[f64], v: &[f64]) -> f64 {
        let (of_q, of_v) = self.scale.split_at(self.n);
        let column = self.n * (1 + k);
        largest_share(&q[column..], of_q).max(largest_share(&v[column..], of_v))
    }

    /// Start of the motion and its small differences. Components are the n coordinates, then the n
    /// velocities; difference k is `scale[k]` in component k and 0 elsewhere. The start does not depend on a
    /// parameter.
    pub(crate) fn start(&self, state: &State) -> State {
        let (mut q, mut v) = (state.q.clone(), state.v.clone());
        q.resize(self.n * (1 + self.columns), 0.0);
        v.resize(self.n * (1 + self.columns), 0.0);
        let free = self.free();
        for k in 0..free.min(2 * self.n) {
            let column = self.n * (1 + k);
            let half = if k < self.n { &mut q } else { &mut v };
            half[column + k % self.n] = self.scale[k];
        }
        for (k, by) in self.forced.iter().enumerate() {
            let column = self.n * (1 + free + k);
            (0..self.n).for_each(|i| v[column + i] = -by.speed * state.v[i]);
        }
        State { t: state.t, q, v }
    }

    /// Number of differences with respect to the start.
    pub(crate) fn free(&self) -> usize {
        self.columns - self.forced.len()
    }

    /// Component i of difference k, in units of `scale`.
    pub(crate) fn scaled(&self, state: &State, i: usize, k: usize) -> f64 {
        if i < self.n {
            return state.q[self.n * (1 + k) + i] / self.scale[i];
        }
        let turned = self.forced.get(k.wrapping_sub(self.free())).map_or(0.0, |by| by.speed);
        (state.v[self.n * (1 + k) + i - self.n] + turned * state.v[i - self.n]) / self.scale[i]
    }

    /// The motion without its differences.
    pub(crate) fn motion(&self, state: &State) -> State {
        State::new(state.t, &state.q[..self.n], &state.v[..self.n])
    }

    /// Writes ∂a/∂u u' for the slope u' of the drives.
    fn along_drives(
        &self,
        by: &DriveSlope,
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        out: &mut [f64],
    ) {
        match self.model.offers().constants {
            Some(constants) => constants.accel_along(&by.drives, pieces, u, q, v, out),
            None => out.fill(0.0),
        }
    }

    fn evaluate(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let n = self.n;
        let ((q, dq), (v, dv), (a, da)) = (q.split_at(n), v.split_at(n), a.split_at_mut(n));
        accelerate(&self.model, pieces, u, q, v, a);
        let mut slopes = self.slopes.borrow_mut();
        slopes.read(&self.model, pieces, u, q, v);
        let (by_q, by_v) = (slopes.jacobian.q.as_slice(), slopes.jacobian.v.as_slice());
        let free = self.free();
        for (k, ((dq, dv), da)) in
            dq.chunks_exact(n).zip(dv.chunks_exact(n)).zip(da.chunks_exact_mut(n)).enumerate()
        {
            let turned = match k.checked_sub(free).map(|k| &self.forced[k]) {
                Some(by) => {
                    self.along_drives(by, pieces, u, q, v, da);
                    da.iter_mut().zip(&*a).for_each(|(da, a)| *da -= 2.0 * by.speed * a);
                    by.speed
                }
                None => {
                    da.fill(0.0);
                    0.0
                }
            };
            for j in 0..n {
                let (column_q, column_v) = (&by_q[j * n..][..n], &by_v[j * n..][..n]);
                let dv = dv[j] + turned * v[j];
                for i in 0..n {
                    da[i] += column_q[i] * dq[j] + column_v[i] * dv;
                }
            }
        }
    }
}

impl Model for Tangent<'_> {
    fn dof(&self) -> usize {
        self.n * (1 + self.columns)
    }
    #[inline]
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.evaluate(None, u, q, v, a);
    }
    fn base(&self) -> Option<&dyn Model> {
        Some(&self.model)
    }
    fn offers(&self) -> Offers<'_> {
        let Offers { pieces, stops, kinks, .. } = self.model.offers();
        Offers { pieces, stops, kinks, expansion: Some(self), ..Offers::default() }
    }
    #[inline]
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        self.model.contact(u, &q[..self.n], &v[..self.n], out);
    }
    /// The impact of the motion alone; [`Saltation`](crate::periodic::flow::saltation::Saltation) computes
    /// the jump of the differences.
    fn impact(&self, contact: usize, on: Piece, u: &[f64], q: &[f64], v: &mut [f64]) {
        self.model.impact(contact, on, u, &q[..self.n], &mut v[..self.n]);
    }
    #[inline]
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.evaluate(Some(pieces), u, q, v, a);
    }
}

impl Expand for Tangent<'_> {
    fn record(&self, moving: &dyn Fn(usize) -> bool) -> Recorded {
        match self.model.offers().expansion {
            Some(expanded) => Recorded(tangent(&expanded.record(moving).0, self.columns, self.forced)),
            None => Recorded(Recording::new(self.dof(), self.drives()).finish(Vec::new(), Vec::new())),
        }
    }
    fn drive_series(&self, t: f64, coefficients: usize, u: &mut [Series]) {
        if let Some(expanded) = self.model.offers().expansion {
            expanded.drive_series(t, coefficients, u);
        }
    }
    fn redrive_series(&self, t: f64, coefficients: usize, needed: &[bool], u: &mut [Series]) {
        if let Some(expanded) = self.model.offers().expansion {
            expanded.redrive_series(t, coefficients, needed, u);
        }
    }
}
