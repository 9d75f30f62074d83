//! What a continuation follows from where: orbits, balances, crossings of branches, infinity, boundaries.

pub(crate) mod beyond;
pub(crate) mod boundary;
pub(crate) mod by_balance;
pub(crate) mod orbit;
pub(crate) mod run;
pub(crate) mod start;
pub(crate) mod switch;
