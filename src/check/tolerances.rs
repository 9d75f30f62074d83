//! Tolerances of the comparisons.

/// Relative tolerance for finite differences.
pub(crate) const ROUGH: f64 = 1e-4;

/// Relative tolerance for two evaluations of the same quantity.
pub(crate) const FINE: f64 = 1e-9;

/// Allowed rounding of a sum, relative to its terms.
pub(crate) const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Whether |a - b| > tolerance (|scale| + max(|a|, |b|)). A NaN always differs.
pub(crate) fn differ(a: f64, b: f64, scale: f64, tolerance: f64) -> bool {
    let apart = (a - b).abs();
    apart.is_nan() || apart > tolerance * (scale.abs() + a.abs().max(b.abs()))
}
