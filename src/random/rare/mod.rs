//! Rare events and first passages.

pub(crate) mod particles;
pub(crate) mod passage;
pub(crate) mod score;
pub(crate) mod splitting;
