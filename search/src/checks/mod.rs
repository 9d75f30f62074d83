//! The checks.

mod branches;
mod cancelling;
mod closed;
mod densities;
mod drives;
mod engines;
mod ensembles;
mod forms;
mod infinity;
mod noise;
mod orbits;
mod powers;
mod processes;
mod random_drives;
mod settling;
mod shapes;
mod steep;
mod stops;
mod symmetric;
mod tables;
mod waterfall;
mod wide;

use crate::Check;

/// All checks.
pub fn all() -> impl Iterator<Item = &'static Check> {
    [
        &branches::CHECKS[..],
        &cancelling::CHECKS,
        &closed::CHECKS,
        &densities::CHECKS,
        &drives::CHECKS,
        &engines::CHECKS,
        &ensembles::CHECKS,
        &forms::CHECKS,
        &infinity::CHECKS,
        &noise::CHECKS,
        &orbits::CHECKS,
        &processes::CHECKS,
        &random_drives::CHECKS,
        &settling::CHECKS,
        &shapes::CHECKS,
        &steep::CHECKS,
        &powers::CHECKS,
        &stops::CHECKS,
        &symmetric::CHECKS,
        &tables::CHECKS,
        &waterfall::CHECKS,
        &wide::CHECKS,
    ]
    .into_iter()
    .flatten()
}
