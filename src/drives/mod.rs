//! Models whose drives are changed.
//!
//! Each type takes a model and is a model. [`Held`] adds a random process to a constant ([`HeldProcess`],
//! which holds a value for a time), [`Driven`] a function of time, [`VaryingSpeed`] replaces the speed by a
//! [`SpeedLaw`]. Module [`rules`] has the base of all three, for rules of one's own.

pub(crate) mod driven;
pub(crate) mod held;
pub(crate) mod process;
pub(crate) mod speed_law;
pub(crate) mod wrapped;

pub use crate::drives::driven::Driven;
pub use crate::drives::held::Held;
pub use crate::drives::process::HeldProcess;
pub use crate::drives::speed_law::{SpeedLaw, VaryingSpeed};

/// Rules that change the drives of a model: for rules of one's own, and those of this module.
pub mod rules {
    pub use crate::drives::driven::TimeDrives;
    pub use crate::drives::held::HeldDrives;
    pub use crate::drives::wrapped::{DriveRule, Wrapped};
}
