//! The closed-loop ring of gears of Yao 2020.

pub(crate) mod algebra;
pub(crate) mod columns;
pub(crate) mod matrices;
pub(crate) mod params;
pub(crate) mod relative;
pub(crate) mod shape;

pub use crate::models::ring::matrices::Modes;
pub use crate::models::ring::params::{Gear, Load, Motor, RingParams, RingSet, Shaft};
pub use crate::models::ring::relative::RelativeView;
pub use crate::models::ring::shape::{Frame, Ring, RingShape};
