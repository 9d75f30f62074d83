//! From layers to SVG.

pub(crate) mod colours;
pub(crate) mod curve;
pub(crate) mod frame;
pub(crate) mod labels;
pub(crate) mod layers;
pub(crate) mod legend;
pub(crate) mod notes;
pub(crate) mod paint;
pub(crate) mod shown;
pub(crate) mod ticks;
