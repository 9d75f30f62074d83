//! Bands of estimates.

/// The x with this probability of a standard normal number below it, by bisection.
pub fn normal_quantile(probability: f64) -> f64 {
    let below = |x: f64| 0.5 * libm::erfc(-x / std::f64::consts::SQRT_2);
    let [mut low, mut high] = [-40.0, 40.0];
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        *(if below(middle) < probability { &mut low } else { &mut high }) = middle;
    }
    0.5 * (low + high)
}

/// The x with this probability of χ²/n, n degrees of freedom, below it.   Source: Wilson and Hilferty, PNAS 17 (1931)
/// 684; its error is below 1e-3 for the numbers of degrees used here, hundreds.
pub fn mean_square_quantile(probability: f64, degrees: f64) -> f64 {
    let spread = 2.0 / (9.0 * degrees);
    (1.0 - spread + normal_quantile(probability) * spread.sqrt()).powi(3)
}
