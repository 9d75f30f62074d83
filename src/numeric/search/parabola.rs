//! Parabolas through three points: maxima, and functions that may pass 0 twice.

/// Maximum number of parabolas of [`maximum`].
const PARABOLAS: usize = 12;

/// Change of a maximum that is rounding, as a share of its absolute value.
const ROUNDING: f64 = 1e-15;

/// The largest value of a function from three increasing places `x` with the values `f`: the parabola through
/// them, then through the largest value and its neighbours. If its vertex lies outside, the longer half is
/// bisected.
pub(crate) fn maximum(mut x: [f64; 3], mut f: [f64; 3], mut at: impl FnMut(f64) -> f64) -> f64 {
    let mut best = f[1];
    for _ in 0..PARABOLAS {
        let vertex = vertex(x, f);
        let middle = 0.5 * (x[0] + x[2]);
        let inside = vertex > x[0] && vertex < x[2] && vertex != x[1];
        let t = if inside { vertex } else { 0.5 * (x[1] + if middle > x[1] { x[2] } else { x[0] }) };
        if !(t > x[0] && t < x[2]) || t == x[1] {
            break;
        }
        let value = at(t);
        let gained = value - best;
        (x, f) = match (t > x[1], value > f[1]) {
            (true, true) => ([x[1], t, x[2]], [f[1], value, f[2]]),
            (true, false) => ([x[0], x[1], t], [f[0], f[1], value]),
            (false, true) => ([x[0], t, x[1]], [f[0], value, f[1]]),
            (false, false) => ([t, x[1], x[2]], [value, f[1], f[2]]),
        };
        best = best.max(value);
        if gained.abs() <= ROUNDING * best.abs() {
            break;
        }
    }
    best
}

/// The place of the extremum of the parabola through three points.
#[inline]
pub(crate) fn vertex(x: [f64; 3], f: [f64; 3]) -> f64 {
    let (a, b) = ((x[1] - x[0]) * (f[1] - f[2]), (x[1] - x[2]) * (f[1] - f[0]));
    x[1] - 0.5 * ((x[1] - x[0]) * a - (x[1] - x[2]) * b) / (a - b)
}

/// The maximum of the parabola through three points; negative infinity if it has none.
#[inline]
pub(crate) fn peak(x: [f64; 3], f: [f64; 3]) -> f64 {
    let s01 = (f[1] - f[0]) / (x[1] - x[0]);
    let s12 = (f[2] - f[1]) / (x[2] - x[1]);
    let curve = (s12 - s01) / (x[2] - x[0]);
    if curve >= 0.0 {
        return f64::NEG_INFINITY;
    }
    let slope = s01 + curve * (x[1] - x[0]);
    f[1] - slope * slope / (4.0 * curve)
}

/// Factor by which the curvature of a function may exceed that of the parabola through three of its values.
pub(crate) const CURVED: f64 = 4.0;

/// How far outside of the last step the extremum of the parabola may lie, in steps.
const OUTSIDE_STEP: f64 = 1.5;

/// Whether a function with three values of one sign may pass 0 twice within the last of two steps: below a
/// chord over the step h a parabola y = c x² + .. reaches c h²/4.
pub(crate) fn may_dip([y0, y1, y2]: [f64; 3], [h0, h1]: [f64; 2]) -> bool {
    if y1 * y2 <= 0.0 || y0 * y1 <= 0.0 {
        return false;
    }
    // y = y1 + s x + c x² with x from the middle point.
    let (left, right) = ((y1 - y0) / h0, (y2 - y1) / h1);
    let c = (right - left) / (h0 + h1);
    let vertex = 0.5 * h1 - 0.5 * right / c;
    c * y1 > 0.0
        && (-OUTSIDE_STEP * h1..=(1.0 + OUTSIDE_STEP) * h1).contains(&vertex)
        && y1.abs().min(y2.abs()) < 0.25 * CURVED * c.abs() * h1 * h1
}

/// A place between two others with values of one sign at which a function has the opposite one, and its value
/// there; `None` if the parabolas of [`maximum`] find none.
pub(crate) fn beyond_zero(
    [x0, f0]: [f64; 2],
    [x2, f2]: [f64; 2],
    mut at: impl FnMut(f64) -> f64,
) -> Option<[f64; 2]> {
    let mut found = None;
    let mut raised = |x: f64| {
        let value = at(x);
        if value * f0 < 0.0 {
            found = Some([x, value]);
        }
        -f0.signum() * value
    };
    let x1 = 0.5 * (x0 + x2);
    let f1 = raised(x1);
    maximum([x0, x1, x2], [-f0.abs(), f1, -f2.abs()], &mut raised);
    found
}

#[cfg(test)]
mod tests {
    use super::{beyond_zero, maximum, may_dip, peak, vertex};

    #[test]
    fn parabolas_are_exact_and_maxima_are_found() {
        let parabola = |x: f64| 2.0 - 3.0 * (x - 0.4) * (x - 0.4);
        let (x, f) = ([0.0, 0.5, 1.5], [0.0, 0.5, 1.5].map(parabola));
        assert!((vertex(x, f) - 0.4).abs() < 1e-15 && (peak(x, f) - 2.0).abs() < 1e-15);
        assert_eq!(peak(x, f.map(|f| -f)), f64::NEG_INFINITY);
        let x = [1.0, 1.3, 2.0];
        assert!((maximum(x, x.map(f64::sin), f64::sin) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_place_beyond_zero_is_found() {
        let at = |lowest: f64| {
            let y = |x: f64| (x - 0.4).powi(2) + lowest;
            beyond_zero([-1.0, y(-1.0)], [1.0, y(1.0)], y)
        };
        assert!(
            at(-1e-9).is_some_and(|[x, value]| (x - 0.4).abs() < 1e-4 && value < 0.0) && at(1e-9).is_none()
        );
    }

    #[test]
    fn parabolas_that_touch_zero_are_noticed() {
        let at = |lowest: f64, x: f64| (x - 0.4) * (x - 0.4) + lowest;
        let near = |lowest: f64| may_dip([at(lowest, -1.0), at(lowest, 0.0), at(lowest, 1.0)], [1.0, 1.0]);
        assert!(near(-0.01) && near(0.01) && !near(1.0));
        assert!(!may_dip([3.0, 2.0, 1.0], [1.0, 1.0]));
    }
}
