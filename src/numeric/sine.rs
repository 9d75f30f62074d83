//! Sine and cosine together, without branches that depend on the quadrant, and their sums of angles.

use std::ops::{Add, Mul, Sub};

/// Largest angle `[rad]` whose quarter turns are subtracted in parts.
const FAR: f64 = 1e6;

/// 1.5 · 2⁵²: adding it rounds a number to a whole one, which the last bits of the sum contain.
const WHOLE: f64 = 6_755_399_441_055_744.0;

/// π/2 in three parts. The first two have 33 bits, so that their products with 10⁶ are exact.
const QUARTER: [f64; 3] = [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];

/// Coefficients of z x, z² x, ... of sin x and of z², z³, ... of cos x, with z = x², |x| <= π/4.   Source:
/// FreeBSD msun, k_sin.c, k_cos.c.
const SIN: [f64; 6] = [
    -0.166_666_666_666_666_32,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];
const COS: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// sin x and cos x of several angles, with an error of at most 3e-16 for |x| <= 1e6 rad, by sums and products
/// alone.
///
/// `libm::sincos` takes longer, since its branches depend on the quadrant, which the processor cannot
/// predict.
#[inline(always)]
pub(crate) fn sin_cos_each<const W: usize>(x: [f64; W]) -> [[f64; W]; 2] {
    sin_cos_of_sums(x, [0.0; W])
}

/// sin nx and cos nx of several angles, as if the product were not rounded.
#[inline(always)]
pub(crate) fn sin_cos_of_multiples<const W: usize>(n: f64, x: [f64; W]) -> [[f64; W]; 2] {
    // The products of n, a whole number below 2^26, with the two halves of x are exact.
    let high = x.map(|x| f64::from_bits(x.to_bits() & !((1 << 27) - 1)));
    let [mut large, mut small] = [[0.0; W]; 2];
    for i in 0..W {
        (large[i], small[i]) = (n * high[i], n * (x[i] - high[i]));
    }
    sin_cos_of_sums(large, small)
}

/// Sine and cosine of x + y. `y`: much smaller than x, or 0.
#[inline(always)]
fn sin_cos_of_sums<const W: usize>(x: [f64; W], y: [f64; W]) -> [[f64; W]; 2] {
    let [mut s, mut c] = [[0.0; W]; 2];
    let mut all_near = true;
    for i in 0..W {
        all_near &= is_near(x[i]);
        (s[i], c[i]) = near(x[i], y[i]);
    }
    if !all_near {
        for i in 0..W {
            if !is_near(x[i]) {
                (s[i], c[i]) = turned(libm::sincos(x[i]), libm::sincos(y[i]));
            }
        }
    }
    [s, c]
}

/// (sin (x + y), cos (x + y)) from the sines and cosines of x and y.
#[inline(always)]
pub(crate) fn turned<S>((s, c): (S, S), (sine, cosine): (S, S)) -> (S, S)
where
    S: Copy + Add<Output = S> + Sub<Output = S> + Mul<Output = S>,
{
    (s * cosine + c * sine, c * cosine - s * sine)
}

/// Turns several angles, given by sine and cosine, by the angles `by`.
#[inline(always)]
pub(crate) fn rotate<const W: usize>(s: &mut [f64; W], c: &mut [f64; W], by: &[[f64; W]; 2]) {
    for i in 0..W {
        (s[i], c[i]) = turned((s[i], c[i]), (by[0][i], by[1][i]));
    }
}

/// Whether |x| <= 1e6 rad.
#[inline(always)]
fn is_near(x: f64) -> bool {
    x.abs() <= FAR
}

/// Sine and cosine of x + y for |x| <= 1e6 rad.
#[inline(always)]
fn near(x: f64, y: f64) -> (f64, f64) {
    let shifted = x * std::f64::consts::FRAC_2_PI + WHOLE;
    let (turns, quadrant) = (shifted - WHOLE, shifted.to_bits());
    let x = (((x - turns * QUARTER[0]) + y) - turns * QUARTER[1]) - turns * QUARTER[2];
    let z = x * x;
    let w = z * z;
    let s = SIN[0] + z * SIN[1] + w * ((SIN[2] + z * SIN[3]) + w * (SIN[4] + z * SIN[5]));
    let c = COS[0] + z * COS[1] + w * ((COS[2] + z * COS[3]) + w * (COS[4] + z * COS[5]));
    let (s, c) = (x + x * (z * s), (1.0 - 0.5 * z) + w * c);
    // Both are exchanged in odd quadrants. The sine is negative in the quadrants 2 and 3, the cosine in 1 and
    // 2.
    let (s, c) = (s.to_bits(), c.to_bits());
    let swap = (s ^ c) & (quadrant & 1).wrapping_neg();
    let sign = |quadrant: u64| (quadrant & 2) << 62;
    (f64::from_bits(s ^ swap ^ sign(quadrant)), f64::from_bits(c ^ swap ^ sign(quadrant.wrapping_add(1))))
}

#[cfg(test)]
mod tests {
    use super::{sin_cos_each, sin_cos_of_multiples};

    #[test]
    fn agrees_with_libm() {
        for i in -400_000..=400_000 {
            let x = f64::from(i) * 2.499_871;
            let ([[s], [c]], (sin, cos)) = (sin_cos_each([x]), libm::sincos(x));
            assert!((s - sin).abs() < 3e-16 && (c - cos).abs() < 3e-16, "{x}: {s} {sin}, {c} {cos}");
        }
        assert_eq!(sin_cos_each([0.0]), [[0.0], [1.0]]);
        assert!(sin_cos_each([f64::NAN, f64::INFINITY]).as_flattened().iter().all(|x| x.is_nan()));
    }

    /// The product of an angle of 26 bits and an order is exact.
    #[test]
    fn multiples_are_not_rounded() {
        for i in -40_000_i32..=40_000 {
            let (x, n) = (f64::from(i) * 24.998_71 + 1e-7, f64::from(1 + i.unsigned_abs() % 97));
            let high = f64::from_bits(x.to_bits() & !((1 << 27) - 1));
            let ((s, c), (small, one)) = (libm::sincos(n * high), libm::sincos(n * (x - high)));
            let ([[sin], [cos]], s, c) =
                (sin_cos_of_multiples(n, [x]), s * one + c * small, c * one - s * small);
            assert!((s - sin).abs() < 1e-15 && (c - cos).abs() < 1e-15, "{n} {x}: {s} {sin}, {c} {cos}");
        }
        assert!(sin_cos_of_multiples(3.0, [f64::NAN, 1.0])[0][0].is_nan());
    }
}
