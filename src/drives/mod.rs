//! Models whose drives are changed.
//!
//! Each type takes a model and is a model. [`Noisy`] adds random [processes](crate::processes) to
//! constants, [`Driven`] functions of time; [`VaryingSpeed`] replaces the speed by a [`SpeedLaw`].
//! [`Wrapped`] is for rules of one's own ([`DriveRule`]).

pub(crate) mod driven;
pub(crate) mod noisy;
pub(crate) mod speed_law;
pub(crate) mod wrapped;

pub use crate::drives::driven::{Driven, TimeDrives};
pub use crate::drives::noisy::{Noisy, RandomDrives};
pub use crate::drives::speed_law::{SpeedLaw, VaryingSpeed};
pub use crate::drives::wrapped::{DriveRule, Wrapped};
