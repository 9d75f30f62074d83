//! Adaptive quadrature of several functions at once.

use crate::numeric::gauss::ten;

/// Deepest halving of an interval.
const DEPTH: u32 = 30;

/// ∫ f(x) dx from a to b of N functions at once, with an estimate of the largest relative error.
///
/// The rule of Gauss with 10 points on an interval is compared with the same rule on its halves. Intervals
/// on which they differ by more than `tolerance` times the integral are halved.
pub(crate) fn integrals<const N: usize>(
    a: f64,
    b: f64,
    tolerance: f64,
    f: impl Fn(f64) -> [f64; N],
) -> ([f64; N], f64) {
    let rule = ten();
    let on = |a: f64, b: f64| {
        let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
        let mut sum = [0.0; N];
        for (x, w) in &rule {
            let values = f(middle + half * x);
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += half * w * value);
        }
        sum
    };
    let whole = on(a, b);
    let scale = whole.map(|value| value.abs().max(f64::MIN_POSITIVE));
    let (mut total, mut error) = ([0.0; N], [0.0; N]);
    let mut open = vec![(a, b, whole, 0)];
    while let Some((a, b, coarse, depth)) = open.pop() {
        let middle = 0.5 * (a + b);
        let halves = [on(a, middle), on(middle, b)];
        let change: [f64; N] = std::array::from_fn(|i| (halves[0][i] + halves[1][i] - coarse[i]).abs());
        let done = (0..N).all(|i| change[i] <= tolerance * scale[i]);
        if done || depth == DEPTH || change.iter().any(|change| !change.is_finite()) {
            for i in 0..N {
                total[i] += halves[0][i] + halves[1][i];
                error[i] += change[i] / scale[i];
            }
        } else {
            open.push((middle, b, halves[1], depth + 1));
            open.push((a, middle, halves[0], depth + 1));
        }
    }
    (total, error.into_iter().fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    #[test]
    fn integrals_reach_their_estimate() {
        // ∫ √x = 2/3 and ∫ 1/(x + 0.01) = ln 101 from 0 to 1.
        let ([root, log], error) = super::integrals(0.0, 1.0, 1e-12, |x: f64| [x.sqrt(), 1.0 / (x + 0.01)]);
        assert!((root - 2.0 / 3.0).abs() < 1e-10 && (log - 101f64.ln()).abs() < 1e-12);
        assert!(error < 1e-10, "{error}");
    }
}
