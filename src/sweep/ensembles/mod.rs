//! Random models: ensembles, distributions, random parameters, Sobol indices.

pub(crate) mod bands;
pub(crate) mod confidence;
pub(crate) mod distribution;
pub(crate) mod members;
pub(crate) mod sobol;
