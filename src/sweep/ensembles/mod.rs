//! Ensembles: many members of a random model.

pub(crate) mod bands;
pub(crate) mod members;
pub(crate) mod moments;
