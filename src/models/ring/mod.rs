//! The closed-loop ring of gears of Yao 2020.

pub(crate) mod algebra;
pub(crate) mod columns;
pub(crate) mod matrices;
pub(crate) mod relative;
pub(crate) mod ring_params;
pub(crate) mod ring_shape;

pub use crate::models::ring::relative::RelativeView;
pub use crate::models::ring::ring_params::{Gear, Load, Motor, RingParams, RingSet, Shaft};
pub use crate::models::ring::ring_shape::{Frame, Ring, RingShape};
