//! The line of models through a plane of two parameters.

use crate::branches::family::{Family, Models};
use crate::branches::orbits::without_stops::WithoutStops;
use crate::contact::edge::Edge;
use crate::error::ParameterError;
use crate::model::Periodic;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

/// The models over p at a value of λ that changes from point to point.
pub(crate) struct Slice<'p> {
    pub(crate) plane: &'p Family<'p, 2>,
    /// The bits of λ.
    other: AtomicU64,
    /// The rigid stops that the orbits of the boundary graze, once they are known: they are left out.
    left_out: OnceLock<Vec<(usize, Edge)>>,
}

impl<'p> Slice<'p> {
    pub(crate) fn new(plane: &'p Family<'p, 2>, other: f64) -> Self {
        Slice { plane, other: AtomicU64::new(other.to_bits()), left_out: OnceLock::new() }
    }

    /// Moves the line to another value of λ. Returns the one before.
    pub(crate) fn replace(&self, other: f64) -> f64 {
        f64::from_bits(self.other.swap(other.to_bits(), Ordering::Relaxed))
    }

    /// Leaves these rigid stops out from now on.
    pub(crate) fn leave_out(&self, stops: Vec<(usize, Edge)>) {
        self.left_out.get_or_init(|| stops);
    }

    /// The rigid stops that are left out.
    pub(crate) fn left_out(&self) -> &[(usize, Edge)] {
        self.left_out.get().map_or(&[], Vec::as_slice)
    }

    /// The model at a place of the plane.
    pub(crate) fn model(&self, values: [f64; 2]) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        let model = self.plane.at(values)?;
        let stops = self.left_out();
        Ok(if stops.is_empty() { model } else { Box::new(WithoutStops::new(model, stops)) })
    }

    /// The family over p.
    pub(crate) fn family(self: &Arc<Self>) -> Family<'p> {
        let [p, _] = self.plane.parameters.clone();
        let constants = self.plane.constants.map(|[p, _]| [p]);
        Family { parameters: [p], constants, models: self.clone() }
    }
}

impl Models<1> for Slice<'_> {
    fn at(&self, [p]: [f64; 1]) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        self.model([p, f64::from_bits(self.other.load(Ordering::Relaxed))])
    }
}
