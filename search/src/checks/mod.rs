//! The checks.

mod branches;
mod symmetric;

use crate::Check;

/// All checks.
pub fn all() -> impl Iterator<Item = &'static Check> {
    [&branches::CHECKS[..], &symmetric::CHECKS].into_iter().flatten()
}
