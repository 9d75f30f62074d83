//! The checks.

mod branches;
mod closed;
mod densities;
mod drives;
mod engines;
mod forms;
mod infinity;
mod orbits;
mod shapes;
mod steep;
mod stops;
mod symmetric;

use crate::Check;

/// All checks.
pub fn all() -> impl Iterator<Item = &'static Check> {
    [
        &branches::CHECKS[..],
        &closed::CHECKS,
        &densities::CHECKS,
        &drives::CHECKS,
        &engines::CHECKS,
        &forms::CHECKS,
        &infinity::CHECKS,
        &orbits::CHECKS,
        &shapes::CHECKS,
        &steep::CHECKS,
        &stops::CHECKS,
        &symmetric::CHECKS,
    ]
    .into_iter()
    .flatten()
}
