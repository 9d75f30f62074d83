//! One function for each kind of picture.

pub(crate) mod band;
pub(crate) mod bifurcation;
pub(crate) mod branch;
pub(crate) mod campbell;
pub(crate) mod map;
pub(crate) mod modes;
pub(crate) mod motion;
pub(crate) mod spectra;
pub(crate) mod stiffness;
