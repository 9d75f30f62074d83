//! A step, as the observer receives it.

use crate::contact::Piece;
use crate::ode::step::StepView;
use crate::ode::taylor::expansion::coefficients::Coefficients;

/// Orders per part of a full step.
const PER_PART: usize = 6;

/// A step with its polynomials.
pub(super) struct Polynomials<'p> {
    pub(super) c: &'p Coefficients,
    pub(super) times: (f64, f64),
    pub(super) ends: [&'p [f64]; 2],
    pub(super) pieces: &'p [Piece],
    pub(super) parts: usize,
}

/// Largest share of its full length for which a step has more parts `[1]`.
const LONGEST: f64 = 2.0;

impl Polynomials<'_> {
    /// Number of parts of a step with the given share of its full length `[1]`. Only the resolution of the
    /// time makes a step much longer than that: then all of it is resolved no better.
    pub(super) fn parts(degree: usize, share: f64) -> usize {
        ((degree as f64 / PER_PART as f64) * share.min(LONGEST)).ceil().max(1.0) as usize
    }
}

impl StepView for Polynomials<'_> {
    fn times(&self) -> (f64, f64) {
        self.times
    }
    fn start(&self) -> &[f64] {
        self.ends[0]
    }
    fn end(&self) -> &[f64] {
        self.ends[1]
    }
    fn parts(&self) -> usize {
        self.parts
    }
    fn pieces(&self) -> Option<&[Piece]> {
        Some(self.pieces)
    }
    fn at(&mut self, t: f64, y: &mut [f64]) {
        self.c.at(t - self.times.0, y);
    }
}

#[cfg(test)]
mod tests {
    use super::Polynomials;

    #[test]
    fn a_long_share_has_few_parts() {
        let parts = [0.0, 0.2, 1.0, 1.5, 1e300].map(|share| Polynomials::parts(24, share));
        assert_eq!(parts, [1, 1, 4, 6, 8]);
    }
}
