//! Integration by Taylor series on fixed pieces.

pub(crate) mod coefficients;
pub(crate) mod distances;
pub(crate) mod functions;
pub(crate) mod integrate;
pub(crate) mod pace;
pub(crate) mod plan;
pub(crate) mod polynomials;
pub(crate) mod positive;
pub(crate) mod products;
pub(crate) mod rows;
pub(crate) mod settings;
