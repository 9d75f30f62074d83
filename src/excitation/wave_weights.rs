//! The weights with which waves of one order are expanded over time, and what their sums may hide.

use crate::series::{BLOCKS, EIGHT};
use crate::steepness::{HIGH_DEGREE, JETS, SHOWN};
use std::fmt;

/// The weights n^k/k! of the Taylor coefficients k of a wave of order n over its angle, with the signs
/// + + - - in turn.
#[derive(Clone, PartialEq)]
pub(crate) struct WaveWeights([[f64; EIGHT]; BLOCKS]);

impl WaveWeights {
    pub(crate) fn new(n: f64) -> Self {
        let (mut weights, mut weight) = ([[0.0; EIGHT]; BLOCKS], 1.0);
        for (k, out) in weights.as_flattened_mut().iter_mut().enumerate() {
            *out = if k % 4 < 2 { weight } else { -weight };
            weight *= n / (k + 1) as f64;
        }
        WaveWeights(weights)
    }
    /// The weights of the coefficients k and k + 1, k even.
    #[inline(always)]
    pub(crate) fn pair(&self, k: usize) -> [f64; 2] {
        self.0.as_flattened().as_chunks().0[k / 2]
    }

    /// Adds the coefficients of the wave with this value and this slope over nφ.
    #[inline(always)]
    pub(crate) fn add<const USED: usize>(&self, [value, slope]: [f64; 2], sums: &mut [[f64; EIGHT]; USED]) {
        let turns = [value, slope, value, slope, value, slope, value, slope];
        for (sum, weights) in sums.iter_mut().zip(&self.0) {
            for l in 0..EIGHT {
                sum[l] += turns[l] * weights[l];
            }
        }
    }
}

impl fmt::Debug for WaveWeights {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("..")
    }
}

/// The sizes Σ_n A_n n^k/k! that the Taylor coefficients k of a sum of waves over their angle have at most.
/// Waves of many orders can cancel, so that the sum is 0 with many coefficients at one angle and large at
/// the next: (1 - cos φ)^n is 0 with 2n of them at φ = 0.
#[derive(Clone, PartialEq)]
pub(crate) struct Sizes {
    sizes: [[f64; EIGHT]; BLOCKS],
    /// The highest order.
    highest: f64,
}

impl Sizes {
    /// The sizes of a sum of terms n, A_n and weights, orders increasing; `None` if its terms are too few to
    /// hide something. M terms and a mean are 0 with 2M coefficients at most.
    pub(crate) fn of<'w>(terms: impl ExactSizeIterator<Item = (f64, f64, &'w WaveWeights)>) -> Option<Self> {
        if 2 * terms.len() <= HIGH_DEGREE {
            return None;
        }
        let mut of = Sizes { sizes: [[0.0; EIGHT]; BLOCKS], highest: 0.0 };
        for (n, amplitude, weights) in terms {
            of.highest = n;
            let weights = weights.0.as_flattened();
            of.sizes.as_flattened_mut().iter_mut().zip(weights).for_each(|(s, w)| *s += amplitude * w.abs());
        }
        Some(of)
    }

    /// The size of coefficient k over the angle; 0 beyond the last one.
    pub(crate) fn at(&self, k: usize) -> f64 {
        self.sizes.as_flattened().get(k).copied().unwrap_or(0.0)
    }

    /// How steep the sum may be beyond these coefficients over time, at the speed φ'; 0 if the last of them
    /// show it `[1/s]`. `power(k)`: φ'^k.
    #[inline]
    pub(crate) fn steepness(&self, coefficients: &[f64], speed: f64, power: impl Fn(usize) -> f64) -> f64 {
        let is_hidden = self.hides(coefficients.len(), |k| coefficients[k], power);
        if is_hidden { (self.highest * speed).abs() } else { 0.0 }
    }

    /// Whether the last two of the Taylor coefficients `at(k)` over time do not show the sum. Few of them
    /// never do.
    #[inline]
    pub(crate) fn hides(
        &self,
        coefficients: usize,
        at: impl Fn(usize) -> f64,
        power: impl Fn(usize) -> f64,
    ) -> bool {
        let sizes = self.sizes.as_flattened();
        let is_small = |k: usize| at(k).abs() < SHOWN * sizes[k] * power(k).abs();
        coefficients <= JETS + 2 || (coefficients - 2..coefficients).all(is_small)
    }
}

impl fmt::Debug for Sizes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("..")
    }
}
