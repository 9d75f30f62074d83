//! The algebra of a train.

pub(crate) mod algebra;
pub(crate) mod contacts;
pub(crate) mod drawing;
pub(crate) mod elements;
pub(crate) mod motion;
pub(crate) mod train_shape;
