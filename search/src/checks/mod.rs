//! The checks.

mod symmetric;

use crate::Check;

/// All checks.
pub fn all() -> impl Iterator<Item = &'static Check> {
    [&symmetric::CHECKS[..]].into_iter().flatten()
}
