//! Evenly spread points without a period. Samples at such points are not in phase with any wave.

/// 1/φ = (√5 - 1)/2 of the golden ratio φ.
pub(crate) const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// frac(i/φ): multiples of the golden ratio modulo 1, evenly spread over (0, 1).
///
/// Source: Knuth, The Art of Computer Programming, vol. 3, Sect. 6.4, Theorem S.
#[inline]
pub(crate) fn golden(i: f64) -> f64 {
    (i * GOLDEN).fract()
}

/// frac(i/φ) for i = 1, ..., 8, as constants.
pub(crate) const GOLDEN_POINTS: [f64; 8] = [
    0.618_033_988_749_895,
    0.236_067_977_499_79,
    0.854_101_966_249_684,
    0.472_135_954_999_579,
    0.090_169_943_749_474,
    0.708_203_932_499_369,
    0.326_237_921_249_264,
    0.944_271_909_999_159,
];

/// frac((i + 1) √(2 d + 3) + 0.137 d): points evenly spread over (0, 1), a different sequence for each
/// direction d.
///
/// Weyl's sequence of square roots.   Source: Kuipers and Niederreiter, Uniform Distribution of Sequences,
/// Sect. 1.6.
pub(crate) fn weyl(index: usize, direction: usize) -> f64 {
    ((index + 1) as f64 * ((2 * direction + 3) as f64).sqrt() + 0.137 * direction as f64).fract()
}

/// Patterns of signs ±1 of `n` components: in pattern k component j has the sign of bit k of j. Any two
/// components have opposite signs in at least one pattern.
pub(crate) fn sign_patterns(n: usize) -> impl Iterator<Item = impl Fn(usize) -> f64> {
    let bits = usize::BITS - n.leading_zeros();
    (0..bits).map(|bit| move |j: usize| if (j >> bit) & 1 == 0 { 1.0 } else { -1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_two_components_have_opposite_signs_in_a_pattern() {
        for n in [1, 2, 3, 8, 9] {
            let rows: Vec<Vec<f64>> = sign_patterns(n).map(|sign| (0..n).map(sign).collect()).collect();
            for (i, j) in (0..n).flat_map(|i| (0..i).map(move |j| (i, j))) {
                assert!(rows.iter().any(|row| row[i] == -row[j]), "{i} and {j} of {n}");
            }
        }
    }

    #[test]
    fn constants_are_the_first_multiples() {
        for (i, point) in GOLDEN_POINTS.iter().enumerate() {
            assert!((point - golden((i + 1) as f64)).abs() < 2e-15);
        }
    }

    /// Discrepancy of N points: at most (log N)/N times a small constant, against 1/√N of random points.
    #[test]
    fn points_are_spread_evenly() {
        let sequences: [Box<dyn Fn(usize) -> f64>; 3] =
            [Box::new(|i| golden((i + 1) as f64)), Box::new(|i| weyl(i, 0)), Box::new(|i| weyl(i, 7))];
        for sequence in sequences {
            let mut points: Vec<f64> = (0..1000).map(sequence).collect();
            points.sort_by(f64::total_cmp);
            let apart = |(i, x): (usize, &f64)| (x - i as f64 / 1000.0).abs();
            let discrepancy = points.iter().enumerate().map(apart).fold(0.0, f64::max);
            assert!(discrepancy < 0.01, "{discrepancy}");
        }
    }
}
