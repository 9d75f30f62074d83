//! What follows from the parts alone, with their checks: bodies by their places, mean speeds, centres, the
//! frame of the coordinates, orders, phases and waves.

pub(crate) mod checks;
pub(crate) mod frame;
pub(crate) mod mesh_waves;
pub(crate) mod phases;
pub(crate) mod places;
pub(crate) mod ranges;
pub(crate) mod topology;
pub(crate) mod train_plan;
pub(crate) mod turning;
