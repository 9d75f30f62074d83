//! Gaussian Markov processes on grids: the nodes of a grid, bridges between them, the cell read last.

pub(crate) mod bridges;
pub(crate) mod grid;
pub(crate) mod last_cell;
