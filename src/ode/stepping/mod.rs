//! One step of a solver: stages, norms, dense output, step sizes.

pub(crate) mod control;
pub(crate) mod dense;
pub(crate) mod ends;
pub(crate) mod engine;
pub(crate) mod kink_rates;
pub(crate) mod nodes;
pub(crate) mod one_step;
pub(crate) mod tableau_row;
pub(crate) mod vector;
pub(crate) mod vector_blocks;
