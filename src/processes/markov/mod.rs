//! Gaussian Markov processes on grids: the nodes of a grid, bridges between them.

pub(crate) mod bridges;
pub(crate) mod grid;
