//! The line of models through a plane of two parameters.

use crate::branches::family::{Family, Models};
use crate::branches::orbits::without_stops::WithoutStops;
use crate::contact::edge::Edge;
use crate::error::ParameterError;
use crate::model::Periodic;
use std::cell::{Cell, RefCell};
use std::rc::Rc;

/// The models over p at a value of λ that changes from point to point.
pub(crate) struct Slice<'p> {
    pub(crate) plane: &'p Family<'p, 2>,
    pub(crate) other: Cell<f64>,
    /// The rigid stops that the orbits of the boundary graze: they are left out.
    pub(crate) left_out: RefCell<Rc<[(usize, Edge)]>>,
}

impl<'p> Slice<'p> {
    pub(crate) fn new(plane: &'p Family<'p, 2>, other: f64) -> Self {
        Slice { plane, other: Cell::new(other), left_out: RefCell::new(Rc::new([])) }
    }

    /// The model at a place of the plane.
    pub(crate) fn model(&self, values: [f64; 2]) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        let model = self.plane.at(values)?;
        let stops = self.left_out.borrow().clone();
        Ok(if stops.is_empty() { model } else { Box::new(WithoutStops::new(model, &stops)) })
    }

    /// The family over p.
    pub(crate) fn family(self: &Rc<Self>) -> Family<'p> {
        let [p, _] = self.plane.parameters.clone();
        let constants = self.plane.constants.map(|[p, _]| [p]);
        Family { parameters: [p], constants, models: self.clone() }
    }
}

impl Models<1> for Slice<'_> {
    fn at(&self, [p]: [f64; 1]) -> Result<Box<dyn Periodic + '_>, ParameterError> {
        self.model([p, self.other.get()])
    }
}
