//! A sweep and how it is run.

pub(crate) mod block;
pub(crate) mod run;
