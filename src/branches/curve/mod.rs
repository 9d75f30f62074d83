//! Solution curves of G(x, p) = 0: corrector, step control, location of points.

pub(crate) mod bordered;
pub(crate) mod continuous;
pub(crate) mod crossing;
pub(crate) mod engine;
pub(crate) mod equations;
pub(crate) mod locate;
pub(crate) mod past;
pub(crate) mod point;
