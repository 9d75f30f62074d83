//! The distances from the edges in the Taylor coefficients of a motion.

use crate::ode::taylor::distances::Distances;
use crate::ode::taylor::expansion::coefficients::Coefficients;
use crate::ode::taylor::expansion::plan::EdgeColumn;

impl Distances for Coefficients {
    fn edges(&self) -> &[EdgeColumn] {
        &self.plan.edges
    }
    fn degree(&self) -> usize {
        self.degree
    }
    #[inline(always)]
    fn coefficient(&self, n: usize, column: usize) -> f64 {
        self.distances(n)[column]
    }
    fn above_until(&self, column: usize, sign: f64, least: f64, h: f64) -> f64 {
        self.samples::<0>(column, h).above_until(sign, least, h)
    }
    fn risen_until(&self, column: usize, sign: f64, least: f64, h: f64) -> f64 {
        let start = self.distances(0)[column];
        self.samples::<1>(column, h).risen_until(sign * start, sign, least, h)
    }
}
