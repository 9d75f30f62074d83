//! Points of a branch: their kinds, test functions, and the columns kept for each.

pub(crate) mod branch_point;
pub(crate) mod change;
pub(crate) mod detect;
pub(crate) mod kind;
pub(crate) mod test_functions;
