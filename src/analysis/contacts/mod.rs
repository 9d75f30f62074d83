//! What contacts do in a run: times on their pieces, impacts, rattle.

pub(crate) mod impact;
pub(crate) mod impacts;
pub(crate) mod pieces;
pub(crate) mod rattle;
