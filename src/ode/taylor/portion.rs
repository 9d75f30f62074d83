//! A portion of a step, as the observer receives it.

use crate::contact::piece::Piece;
use crate::ode::step::StepView;
use crate::ode::taylor::coefficients::Coefficients;

/// Orders per portion of a full step. Observers sample a step at a few points, which a step of high order
/// would exceed.
const PER_PORTION: usize = 6;

/// A portion of a step with its polynomials.
pub(super) struct Portion<'p> {
    pub(super) c: &'p Coefficients,
    /// Start of the step.
    pub(super) origin: f64,
    /// Start and end of the portion.
    pub(super) times: (f64, f64),
    pub(super) ends: [&'p [f64]; 2],
    pub(super) pieces: &'p [Piece],
}

impl Portion<'_> {
    /// Number of portions of a step with the given share of its full length `[1]`.
    pub(super) fn count(degree: usize, share: f64) -> usize {
        ((degree as f64 / PER_PORTION as f64) * share).ceil().max(1.0) as usize
    }
}

impl StepView for Portion<'_> {
    fn times(&self) -> (f64, f64) {
        self.times
    }
    fn start(&self) -> &[f64] {
        self.ends[0]
    }
    fn end(&self) -> &[f64] {
        self.ends[1]
    }
    fn pieces(&self) -> Option<&[Piece]> {
        Some(self.pieces)
    }
    fn at(&mut self, t: f64, y: &mut [f64]) {
        self.c.at(t - self.origin, y);
    }
}
