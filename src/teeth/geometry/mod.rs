//! Geometry of involute gears.

pub(crate) mod blank;
pub(crate) mod checks;
pub(crate) mod gear;
pub(crate) mod involute;
pub(crate) mod mesh_checks;
pub(crate) mod pair;
