//! Invariant circles of a stroboscopic map.

pub(crate) mod circle_equations;
pub(crate) mod circle_error;
pub(crate) mod circle_shooting;
pub(crate) mod closed_curve;
pub(crate) mod growth;
pub(crate) mod guess;
pub(crate) mod invariant_circle;
pub(crate) mod rotation;
pub(crate) mod strobed;
