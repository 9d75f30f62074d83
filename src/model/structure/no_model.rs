//! The place of a model while there is none.

use crate::model::{Model, Periodic};

/// No coordinates: stands in arrays that are kept from one model to the next.
pub(crate) struct NoModel;

impl Model for NoModel {
    fn dof(&self) -> usize {
        0
    }
    fn accel(&self, _: &[f64], _: &[f64], _: &[f64], _: &mut [f64]) {}
}

impl Periodic for NoModel {
    fn period(&self) -> f64 {
        1.0
    }
}
