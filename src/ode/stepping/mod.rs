//! One step of a solver: stages, norms, dense output, step sizes.

pub(crate) mod blocks;
pub(crate) mod control;
pub(crate) mod engine;
pub(crate) mod inside;
pub(crate) mod row;
pub(crate) mod vector;
