//! A row of a Runge-Kutta tableau.

/// A row of a tableau: (column from 0, coefficient), zeros left out.
pub type Row<const L: usize> = [(usize, f64); L];

/// Slots that any tableau may use.
pub(crate) const SLOTS: usize = 16;
