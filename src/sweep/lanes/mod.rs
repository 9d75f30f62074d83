//! Lanes: several runs side by side over one drive table.

pub(crate) mod algebra;
pub(crate) mod compiled;
pub(crate) mod drive_table;
pub(crate) mod flanks;
pub(crate) mod instructions;
pub(crate) mod kernel;
pub(crate) mod meter;
pub(crate) mod number;
pub(crate) mod stages;
