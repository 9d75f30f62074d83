//! The polynomials of one lane.

use crate::ode::taylor::defect::MotionPolynomials;
use crate::ode::taylor::distances::Distances;
use crate::ode::taylor::expansion::plan::EdgeColumn;
use crate::ode::taylor::expansion::sums::{Samples, Sampling};
use crate::sweep::taylor::columns::Columns;
use pulp::Arch;

/// The coefficients of all columns in one lane.
pub(crate) struct LaneView<'c> {
    pub(super) columns: &'c Columns,
    pub(super) lane: usize,
    pub(super) edges: &'c [EdgeColumn],
    pub(super) arch: Arch,
    /// What has no series where its operand is 0.
    pub(super) singular: Option<&'static str>,
}

impl LaneView<'_> {
    /// Writes coordinates and velocities, the first columns, at the time `s` after the start of the step.
    pub(super) fn at(&self, s: f64, y: &mut [f64]) {
        for (column, y) in y.iter_mut().enumerate() {
            *y = (0..=self.columns.degree).rev().fold(0.0, |sum, n| sum * s + self.coefficient(n, column));
        }
    }
    fn samples<const SHIFT: usize>(&self, column: usize, h: f64) -> Samples {
        let sampling = Sampling { arch: self.arch, count: self.columns.degree + 1 - SHIFT, h };
        sampling.of(|n| self.coefficient(n + SHIFT, column))
    }
}

impl Distances for LaneView<'_> {
    fn edges(&self) -> &[EdgeColumn] {
        self.edges
    }
    fn degree(&self) -> usize {
        self.columns.degree
    }
    #[inline(always)]
    fn coefficient(&self, n: usize, column: usize) -> f64 {
        self.columns.at(column, n).0[self.lane]
    }
    fn above_until(&self, column: usize, sign: f64, least: f64, h: f64) -> f64 {
        self.samples::<0>(column, h).above_until(sign, least, h)
    }
    fn risen_until(&self, column: usize, sign: f64, least: f64, h: f64) -> f64 {
        let start = self.coefficient(0, column);
        self.samples::<1>(column, h).risen_until(sign * start, sign, least, h)
    }
}

impl MotionPolynomials for LaneView<'_> {
    fn state(&self, s: f64, y: &mut [f64]) {
        self.at(s, y);
    }
    fn acceleration(&self, s: f64, a: &mut [f64]) {
        let n = a.len();
        for (i, a) in a.iter_mut().enumerate() {
            let terms = (1..=self.columns.degree).rev();
            *a = terms.fold(0.0, |sum, k| sum * s + k as f64 * self.coefficient(k, n + i));
        }
    }
}
