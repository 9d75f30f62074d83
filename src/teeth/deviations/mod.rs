//! Deviations of teeth: faults, reliefs, tolerances, transmission error.

pub(crate) mod faults;
pub(crate) mod grade;
pub(crate) mod inspected;
pub(crate) mod relief;
pub(crate) mod transmission;
