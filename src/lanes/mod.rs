//! Many runs at once: lanes of one table.

mod isa;
mod kernel;
mod meter;
mod number;
mod table;

pub use isa::InstructionSet;
pub(crate) use kernel::{Algebra, Bundle, Kernel, Plain, Shared};
pub(crate) use meter::{ChannelMeter, ContactMeter, Kind, Meters, Reading};
pub use number::Lanes;
pub(crate) use number::Number;
pub(crate) use table::Table;
pub use table::TableError;
