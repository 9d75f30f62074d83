//! How closely two numbers have to agree.

/// Relative agreement asked of differences, and of two ways to one number.
pub(crate) const ROUGH: f64 = 1e-4;

pub(crate) const FINE: f64 = 1e-9;

/// Share of the terms of a sum that rounding may take.
pub(crate) const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// The golden section visits an interval evenly and avoids round fractions of it.
pub(crate) const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Whether two numbers part by more than a share of their size; a NaN always does.
pub(crate) fn differ(a: f64, b: f64, scale: f64, tolerance: f64) -> bool {
    let apart = (a - b).abs();
    apart.is_nan() || apart > tolerance * (scale.abs() + a.abs().max(b.abs()))
}
