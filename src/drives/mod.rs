//! Models whose drives are changed.
//!
//! Each type takes a model and is a model. [`Noisy`] adds random [processes](crate::processes) to
//! constants, [`Driven`] functions of time; [`VaryingSpeed`] replaces the speed by a [`SpeedLaw`].
//! Module [`rules`] has the base of all three, for rules of one's own.

pub(crate) mod driven;
pub(crate) mod noisy;
pub(crate) mod speed_law;
pub(crate) mod wrapped;

pub use crate::drives::driven::Driven;
pub use crate::drives::noisy::Noisy;
pub use crate::drives::speed_law::{SpeedLaw, VaryingSpeed};

/// Rules that change the drives of a model: for rules of one's own, and those of this module.
pub mod rules {
    pub use crate::drives::driven::TimeDrives;
    pub use crate::drives::noisy::RandomDrives;
    pub use crate::drives::speed_law::LawOfBody;
    pub use crate::drives::wrapped::{DriveRule, Wrapped};
}
