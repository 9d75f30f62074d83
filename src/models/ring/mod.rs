//! The closed-loop ring of n gears.

mod algebra;
mod matrices;
mod params;
mod relative;
#[path = "ring.rs"]
mod system;

pub use matrices::Modes;
pub use params::{Gear, Load, Motor, RingParams, RingSet, Shaft};
pub use relative::RelativeView;
pub use system::{Frame, Ring};
