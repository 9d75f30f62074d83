//! Recorded algebra: sums, products and functions in the order of their evaluation.
//!
//! An algebra that runs once on [`Node`](crate::model::recording::Node)s leaves a [`Tape`](operations::Tape):
//! its operations with operands that are weighted sums of coordinates, velocities, drives and earlier
//! results. The tape is evaluated order by order to Taylor series ([`Taylor`](crate::Taylor)), for any set of
//! pieces.

pub(crate) mod columns;
pub(crate) mod form;
pub(crate) mod node;
pub(crate) mod operations;
pub(crate) mod recording;
