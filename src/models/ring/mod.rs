//! The closed-loop ring of n gears.

mod algebra;
mod matrices;
mod params;
mod relative;
mod shape;

pub use matrices::Modes;
pub use params::{Gear, Load, Motor, RingParams, RingSet, Shaft};
pub use relative::RelativeView;
pub use shape::{Frame, Ring, RingShape};
