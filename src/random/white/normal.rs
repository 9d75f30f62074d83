//! Pairs of normal numbers in lanes, as pure functions of their keys and a number.
#![allow(
    clippy::needless_range_loop,
    reason = "index loops over arrays become vector instructions, iterators do not"
)]

use crate::numeric::sine::sin_cos_each;
use crate::numeric::split_mix::{CounterRng, GOLDEN_GAMMA, mix};
use rand::Rng;
use std::f64::consts::TAU;

/// The key of a sequence of pairs: the start of a SplitMix64 sequence that is mixed from three numbers.
pub(crate) fn key(seed: u64, member: u64, stream: u64) -> u64 {
    CounterRng::new(seed, member, stream, 0).next_u64()
}

/// Pair `number[i]` of the sequence `keys[i]`, for each lane i: two independent normal numbers of mean 0 and
/// variance 1.
///
/// r = √(-2 ln u₁),   z₁ = r cos 2πu₂,   z₂ = r sin 2πu₂
///
/// u₁ and u₂ are the numbers 2k and 2k + 1 of the SplitMix64 sequence, with 52 bits: |z| <= 8.5. Source: Box
/// and Muller 1958 (Ann. Math. Stat. 29, 610).
#[inline(always)]
pub(crate) fn normal_pairs<const W: usize>(keys: &[u64; W], number: &[u64; W]) -> [[f64; W]; 2] {
    let [mut radius, mut angle] = [[0.0; W]; 2];
    for i in 0..W {
        let at = keys[i].wrapping_add(number[i].wrapping_mul(GOLDEN_GAMMA.wrapping_mul(2)));
        // In (0, 1], since the logarithm of 0 is infinite.
        radius[i] = 2.0 - one_to_two(mix(at));
        angle[i] = TAU * (one_to_two(mix(at.wrapping_add(GOLDEN_GAMMA))) - 1.0);
    }
    for i in 0..W {
        radius[i] = (-2.0 * ln(radius[i])).sqrt();
    }
    let [mut sine, mut cosine] = sin_cos_each(angle);
    for i in 0..W {
        cosine[i] *= radius[i];
        sine[i] *= radius[i];
    }
    [cosine, sine]
}

/// A number in [1, 2) from the upper 52 bits of a word.
#[inline(always)]
fn one_to_two(word: u64) -> f64 {
    f64::from_bits((word >> 12) | 0x3ff0_0000_0000_0000)
}

/// ln 2 in two parts; products of the first one with whole numbers up to 2000 are exact.
const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];

/// Coefficients of s², s⁴, ... of (2 atanh s)/s - 2.   Source: FreeBSD msun, e_log.c.
const LOG: [f64; 7] = [
    6.666_666_666_666_735e-1,
    3.999_999_999_940_942e-1,
    2.857_142_874_366_239e-1,
    2.222_219_843_214_978_4e-1,
    1.818_357_216_161_805e-1,
    1.531_383_769_920_937_3e-1,
    1.479_819_860_511_658_6e-1,
];

/// ln x of a positive normal number, by sums, products and one quotient, without branches.
///
/// x = 2^k (1 + f) with √½ <= 1 + f < √2;   ln(1 + f) = f - f²/2 + s (f²/2 + R),   s = f/(2 + f)
#[inline(always)]
fn ln(x: f64) -> f64 {
    // The mantissa of √½, so that the exponent of x/√½ is that of 2^k.
    const HALF_ROOT: u64 = 0x3fe6_a09e_0000_0000;
    // Adding 2⁵² + 2⁵¹ shows whole numbers of small magnitude in the last bits of a number.
    const WHOLE: u64 = 0x4338_0000_0000_0000;
    // An exponent that keeps the shifted difference positive.
    const UP: u64 = 1 << 62;
    let above = x.to_bits().wrapping_add(UP).wrapping_sub(HALF_ROOT);
    let k = f64::from_bits(WHOLE + (above >> 52)) - f64::from_bits(WHOLE) - (UP >> 52) as f64;
    let f = f64::from_bits((above & ((1 << 52) - 1)).wrapping_add(HALF_ROOT)) - 1.0;
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let even = z * (LOG[0] + w * (LOG[2] + w * (LOG[4] + w * LOG[6])));
    let odd = w * (LOG[1] + w * (LOG[3] + w * LOG[5]));
    let half = 0.5 * f * f;
    k * LN_2[0] - ((half - (s * (half + (even + odd)) + k * LN_2[1])) - f)
}

#[cfg(test)]
mod tests {
    use super::{key, ln, normal_pairs};

    #[test]
    fn logarithm_agrees_with_libm() {
        for i in 1..400_000 {
            for x in [f64::from(i) / 400_000.0, (-f64::from(i) * 9e-5).exp2(), 1.0] {
                assert!((ln(x) - libm::log(x)).abs() <= 4e-16 * libm::log(x).abs(), "{x}");
            }
        }
    }

    /// The same bits in 1 and 8 lanes; values that no platform changes.
    #[test]
    fn pairs_are_fixed() {
        let keys: [u64; 8] = std::array::from_fn(|i| key(1, i as u64, 3));
        let numbers: [u64; 8] = std::array::from_fn(|i| 7 * i as u64);
        let pairs = normal_pairs(&keys, &numbers);
        for i in 0..8 {
            assert_eq!(normal_pairs(&[keys[i]], &[numbers[i]]).map(|z| z[0]), pairs.map(|z| z[i]));
        }
    }

    /// Moments of 2 × 10⁵ numbers: 0, 1, 0, 3 within five standard errors √(1, 2, 15, 96)/√n, and no
    /// correlation within pairs and from pair to pair.
    #[test]
    fn moments_are_those_of_a_normal_number() {
        let n = 100_000;
        let (mut moments, mut products, mut last) = ([0.0; 4], [0.0; 2], 0.0);
        for number in 0..n {
            let z = normal_pairs(&[key(5, 0, 0)], &[number]).map(|z| z[0]);
            for z in z {
                let powers = [z, z * z, z * z * z, z * z * z * z];
                moments.iter_mut().zip(powers).for_each(|(sum, power)| *sum += power);
            }
            products[0] += z[0] * z[1];
            products[1] += z[0] * last;
            last = z[1];
        }
        let n = n as f64;
        for ((sum, mean), variance) in moments.iter().zip([0.0, 1.0, 0.0, 3.0]).zip([1.0, 2.0, 15.0, 96.0f64])
        {
            assert!((sum / (2.0 * n) - mean).abs() < 5.0 * (variance / (2.0 * n)).sqrt(), "{moments:?}");
        }
        assert!(products.iter().all(|sum| (sum / n).abs() < 5.0 / n.sqrt()), "{products:?}");
    }
}
