//! Multiple shooting.

pub(crate) mod cyclic;
pub(crate) mod failure;
pub(crate) mod guess;
pub(crate) mod multiple;
pub(crate) mod orbit;
pub(crate) mod segments;
