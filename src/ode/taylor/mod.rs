//! Integration by Taylor series on fixed pieces.

pub(crate) mod course;
pub(crate) mod defect;
pub(crate) mod distances;
pub(crate) mod edge_distances;
pub(crate) mod expansion;
pub(crate) mod integrate;
pub(crate) mod pace;
pub(crate) mod polynomials;
pub(crate) mod positive;
pub(crate) mod settings;
