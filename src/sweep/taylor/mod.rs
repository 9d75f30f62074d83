//! Taylor series in lanes: several runs side by side, each with its own time, step, pieces and edges.

pub(crate) mod columns;
pub(crate) mod crew;
pub(crate) mod lane;
pub(crate) mod lane_taylor;
pub(crate) mod meters;
pub(crate) mod pace;
pub(crate) mod program;
pub(crate) mod still;
pub(crate) mod tangents;
pub(crate) mod tasks;
pub(crate) mod view;
