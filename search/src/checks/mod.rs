//! The checks.

mod branches;
mod infinity;
mod symmetric;

use crate::Check;

/// All checks.
pub fn all() -> impl Iterator<Item = &'static Check> {
    [&branches::CHECKS[..], &infinity::CHECKS, &symmetric::CHECKS].into_iter().flatten()
}
