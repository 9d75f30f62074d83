//! Models with changed drives: held processes, functions of time, varying speed.

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
