//! The motion from one node to the next, enclosed.

pub(crate) mod algebra;
pub(crate) mod continuity;
pub(crate) mod crossing;
pub(crate) mod field;
pub(crate) mod image;
pub(crate) mod leg;
pub(crate) mod part;
pub(crate) mod signs;
pub(crate) mod stretch;
pub(crate) mod window;
