//! The checks.

use crate::Check;

/// All checks.
pub const CHECKS: &[Check] = &[];
