//! The involute function and its inverse.

use crate::numeric::search::bracket::{Bracket, rounding};

/// inv α = tan α - α.
pub(crate) fn involute(angle: f64) -> f64 {
    libm::tan(angle) - angle
}

/// The angle α in [0, 1.5] rad with inv α = `value`; `None` if there is none.
pub(crate) fn inverse(value: f64) -> Option<f64> {
    let bracket = Bracket { lo: 0.0, hi: 1.5 };
    if !(value >= 0.0 && value <= involute(bracket.hi)) {
        return None;
    }
    let residual = |angle: f64| (involute(angle) - value, libm::tan(angle) * libm::tan(angle));
    Some(bracket.solve(libm::cbrt(3.0 * value).min(1.4), true, rounding, residual))
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_inverse_returns_the_angle() {
        for angle in [1e-3, 0.05, 0.3, 0.6, 1.0, 1.4] {
            let back = super::inverse(super::involute(angle)).unwrap();
            // The slope of inv α is tan² α: rounding of inv α counts the more, the smaller the angle is.
            assert!((back - angle).abs() < 1e-15 / angle.powi(2), "{angle} {back}");
        }
        assert_eq!(super::inverse(0.0), Some(0.0));
        assert_eq!(
            (super::inverse(-1e-9), super::inverse(f64::NAN), super::inverse(50.0)),
            (None, None, None)
        );
    }
}
