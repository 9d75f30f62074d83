//! Models with other drives: held random processes, functions of time, a varying speed.

pub(crate) mod driven;
pub(crate) mod held;
pub(crate) mod phase;
pub(crate) mod wrapped;

pub use crate::drives::driven::{Driven, TimeDrives};
pub use crate::drives::held::{CounterRng, Held, HeldDrives, HeldProcess};
pub use crate::drives::phase::{PhaseLaw, VaryingSpeed};
pub use crate::drives::wrapped::{DriveRule, Wrapped};
