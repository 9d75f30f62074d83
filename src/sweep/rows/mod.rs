//! The rows of a sweep: the results of its points.

pub(crate) mod collection;
pub(crate) mod hash;
pub(crate) mod layout;
pub(crate) mod merge;
pub(crate) mod row;
pub(crate) mod table;
