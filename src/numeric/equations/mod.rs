//! Linear equations: least solutions of those that may be singular, sparse factors. Units that balance a
//! matrix.

pub(crate) mod balancing;
pub(crate) mod bordered;
pub(crate) mod entries;
pub(crate) mod factors;
pub(crate) mod least;
