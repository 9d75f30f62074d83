//! The Taylor coefficients of a motion as polynomials over a step.

use crate::ode::taylor::defect::MotionPolynomials;
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

impl MotionPolynomials for Coefficients {
    fn state(&self, s: f64, y: &mut [f64]) {
        self.at(s, y);
    }
    fn acceleration(&self, s: f64, a: &mut [f64]) {
        Coefficients::acceleration(self, s, a);
    }
}
