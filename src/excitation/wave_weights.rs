//! The weights with which waves of one order are expanded over time.

use crate::series::{BLOCKS, EIGHT};
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
