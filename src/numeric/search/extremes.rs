//! Larger and smaller of two numbers in one instruction, where [`f64::max`] and [`f64::min`] take five.

/// The larger number; y if one of them is NaN.
#[inline(always)]
pub(crate) fn larger(x: f64, y: f64) -> f64 {
    if x > y { x } else { y }
}

/// The smaller number; y if one of them is NaN.
#[inline(always)]
pub(crate) fn smaller(x: f64, y: f64) -> f64 {
    if x < y { x } else { y }
}
