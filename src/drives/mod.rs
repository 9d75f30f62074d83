//! Models whose drives are changed.
//!
//! Each type takes a model and is a model. [`Held`] adds a random process to a constant ([`HeldProcess`],
//! which holds a value for a time), [`Driven`] a function of time, [`VaryingSpeed`] replaces the speed by a
//! [`SpeedLaw`]. [`Wrapped`] is for rules of one's own ([`DriveRule`]).

pub(crate) mod driven;
pub(crate) mod held;
pub(crate) mod process;
pub(crate) mod speed_law;
pub(crate) mod wrapped;

pub use crate::drives::driven::{Driven, TimeDrives};
pub use crate::drives::held::{Held, HeldDrives};
pub use crate::drives::process::HeldProcess;
pub use crate::drives::speed_law::{SpeedLaw, VaryingSpeed};
pub use crate::drives::wrapped::{DriveRule, Wrapped};
