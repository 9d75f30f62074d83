//! Gauss-Legendre quadrature.

/// ∫ f(x) dx from a to b ≈ (b - a)/2 Σ_i w_i f((a + b)/2 + (b - a)/2 x_i): Gauss-Legendre with 5 points.
///
/// Exact for polynomials up to degree 9.   Source: Abramowitz & Stegun, Table 25.4.
pub(crate) fn gauss(a: f64, b: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    GAUSS.iter().map(|[x, w]| w * f(middle + half * x)).sum::<f64>() * half
}

/// Points x_i and weights w_i on [-1, 1].
pub(crate) const GAUSS: [[f64; 2]; 5] = [
    [-0.906_179_845_938_664, 0.236_926_885_056_189_08],
    [-0.538_469_310_105_683_1, 0.478_628_670_499_366_47],
    [0.0, 0.568_888_888_888_888_9],
    [0.538_469_310_105_683_1, 0.478_628_670_499_366_47],
    [0.906_179_845_938_664, 0.236_926_885_056_189_08],
];
