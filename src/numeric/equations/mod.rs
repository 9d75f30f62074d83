//! Linear equations: least solutions of those that may be singular, sparse factors.

pub(crate) mod bordered;
pub(crate) mod entries;
pub(crate) mod factors;
pub(crate) mod least;
