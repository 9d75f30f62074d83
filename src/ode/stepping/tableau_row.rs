//! A row of a Runge-Kutta tableau.

/// A row of a tableau: pairs (column from 0, coefficient), without zero coefficients.
pub type TableauRow<const L: usize> = [(usize, f64); L];

/// Maximum number of slots of a tableau.
pub(crate) const SLOTS: usize = 16;
