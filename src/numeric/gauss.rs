//! Gauss-Legendre quadrature.
//!
//! ∫ f(x) dx from -1 to 1 ≈ Σ_i w_i f(x_i), exact for polynomials up to degree 2n - 1 with n points.
//! Source: Abramowitz & Stegun, Table 25.4.

/// Points x_i and weights w_i of the rule with 5 points on [-1, 1].
pub(crate) const FIVE: [[f64; 2]; 5] = [
    [-0.906_179_845_938_664, 0.236_926_885_056_189_08],
    [-0.538_469_310_105_683_1, 0.478_628_670_499_366_47],
    [0.0, 0.568_888_888_888_888_9],
    [0.538_469_310_105_683_1, 0.478_628_670_499_366_47],
    [0.906_179_845_938_664, 0.236_926_885_056_189_08],
];

/// Points c_i and weights b_i of the rule with 6 points on [0, 1]: the nodes of Gauss collocation.
pub(crate) const SIX_ON_UNIT: [[f64; 2]; 6] = [
    [0.033_765_242_898_423_99, 0.085_662_246_189_585_18],
    [0.169_395_306_766_867_73, 0.180_380_786_524_069_3],
    [0.380_690_406_958_401_56, 0.233_956_967_286_345_52],
    [0.619_309_593_041_598_5, 0.233_956_967_286_345_52],
    [0.830_604_693_233_132_2, 0.180_380_786_524_069_3],
    [0.966_234_757_101_576, 0.085_662_246_189_585_18],
];

/// Positive points x_i and weights w_i of the rule with 10 points on [-1, 1].
const HALF_OF_TEN: [[f64; 2]; 5] = [
    [0.148_874_338_981_631_2, 0.295_524_224_714_752_9],
    [0.433_395_394_129_247_2, 0.269_266_719_309_996_4],
    [0.679_409_568_299_024_4, 0.219_086_362_515_982_04],
    [0.865_063_366_688_984_5, 0.149_451_349_150_580_6],
    [0.973_906_528_517_171_7, 0.066_671_344_308_688_14],
];

/// Points x_i and weights w_i of the rule with 10 points on [-1, 1].
pub(crate) fn ten() -> [(f64, f64); 10] {
    std::array::from_fn(|k| {
        let [x, weight] = HALF_OF_TEN[k / 2];
        (if k % 2 == 0 { -x } else { x }, weight)
    })
}

/// ∫ f(x) dx from a to b ≈ (b - a)/2 Σ_i w_i f((a + b)/2 + (b - a)/2 x_i), with 5 points.
pub(crate) fn integral(a: f64, b: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    FIVE.iter().map(|[x, w]| w * f(middle + half * x)).sum::<f64>() * half
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_exact_to_degree_2n_minus_1() {
        let five: Vec<(f64, f64)> = FIVE.iter().map(|[x, w]| (*x, *w)).collect();
        let six: Vec<(f64, f64)> = SIX_ON_UNIT.iter().map(|[c, b]| (2.0 * c - 1.0, 2.0 * b)).collect();
        for rule in [five, six, ten().to_vec()] {
            for degree in 0..2 * rule.len() as i32 {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree)).sum();
                let exact = if degree % 2 == 0 { 2.0 / f64::from(degree + 1) } else { 0.0 };
                assert!((sum - exact).abs() < 2e-15, "{} points, degree {degree}", rule.len());
            }
            let degree = 2 * rule.len() as i32;
            let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree)).sum();
            assert!((sum - 2.0 / f64::from(degree + 1)).abs() > 1e-9);
        }
        assert!((integral(1.0, 3.0, |x| x.powi(9)) - (3f64.powi(10) - 1.0) / 10.0).abs() < 1e-10);
    }
}
