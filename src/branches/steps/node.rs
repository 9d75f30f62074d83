//! Points of a curve with what is measured along their orbits.

use crate::branches::curve::point::CurvePoint;
use crate::branches::orbits::measured::Measured;
use crate::branches::points::test_functions::Values;
use crate::periodic::Multipliers;

/// A point of the curve with what is measured along its orbit.
pub(crate) struct Node<S> {
    pub(crate) point: CurvePoint<S>,
    pub(crate) measured: Measured,
    pub(crate) multipliers: Option<Multipliers>,
    pub(crate) values: Values,
}

impl<S> Node<S> {
    pub(crate) fn new(point: CurvePoint<S>, measured: Measured, multipliers: Option<Multipliers>) -> Self {
        let values = Values::new(point.slope(), multipliers.as_ref(), &measured.trace);
        Node { point, measured, multipliers, values }
    }
}
