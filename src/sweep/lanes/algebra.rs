//! The functions of a model that runs over a drive table need, for lanes and for plain numbers.

use crate::contact::{ByDeflection, Contact};
use crate::model::{Drives, Model, Shape};
use crate::scalar::{Scalar, keep_rolled};
use std::ops::Range;

/// The functions of a model that a step needs, on numbers `S`. The drives of the table come first, then the
/// drives that differ between lanes.
pub(crate) trait Algebra<S> {
    fn dof(&self) -> usize;
    fn drives(&self) -> usize;
    /// Number of leading drives that the table contains.
    fn columns(&self) -> usize;
    fn contacts(&self) -> usize;
    fn accel(&self, u: &[S], q: &[S], v: &[S], a: &mut [S]);
    /// Evaluates at least the contacts `which`.
    fn contact(&self, which: Range<usize>, u: &[S], q: &[S], v: &[S], out: &mut [Contact<S>]);
}

/// The shape of a model, shared by all lanes.
pub(crate) struct Shared<'m, G>(pub(crate) &'m G);

impl<S: Scalar, G: Shape> Algebra<S> for Shared<'_, G> {
    #[inline(always)]
    fn dof(&self) -> usize {
        self.0.size().dof
    }
    #[inline(always)]
    fn drives(&self) -> usize {
        self.0.size().drives()
    }
    #[inline(always)]
    fn columns(&self) -> usize {
        self.0.size().waves
    }
    #[inline(always)]
    fn contacts(&self) -> usize {
        self.0.size().contacts
    }
    // Not inlined without optimisation: it is then compiled once for each shape and width, instead of once
    // for each call and instruction set.
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn accel(&self, u: &[S], q: &[S], v: &[S], a: &mut [S]) {
        self.0.accel(&ByDeflection, Drives::new(self.0.size().waves, u), q, v, a);
    }
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn contact(&self, which: Range<usize>, u: &[S], q: &[S], v: &[S], out: &mut [Contact<S>]) {
        let (u, out) = (Drives::new(self.0.size().waves, u), &mut out[..self.0.size().contacts]);
        for i in which {
            let i = keep_rolled(i);
            out[i] = self.0.contact(&ByDeflection, i, u, q, v);
        }
    }
}

/// Any model, run alone.
pub(crate) struct Plain<'m, M: ?Sized>(pub(crate) &'m M);

impl<M: Model + ?Sized> Algebra<f64> for Plain<'_, M> {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn drives(&self) -> usize {
        self.0.drives()
    }
    fn columns(&self) -> usize {
        self.0.drives()
    }
    fn contacts(&self) -> usize {
        self.0.contacts()
    }
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.0.accel(u, q, v, a);
    }
    fn contact(&self, _: Range<usize>, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        self.0.contact(u, q, v, out);
    }
}
