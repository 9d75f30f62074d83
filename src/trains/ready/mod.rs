//! Gear trains that are ready to use.

pub(crate) mod planetary;
