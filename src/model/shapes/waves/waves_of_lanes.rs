//! The waves of a shape as Taylor series over time, for several runs with their own angles and speeds.
#![allow(
    clippy::needless_range_loop,
    reason = "index loops over arrays become vector instructions, iterators do not"
)]

use crate::excitation::wave_weights::Sizes;
use crate::model::shapes::waves::fourier_waves::{FourierWaves, Turn};

/// Scratch of [`FourierWaves::expand_lanes`].
pub(crate) struct Turns<const W: usize> {
    /// Sines and cosines of all orders.
    turns: Vec<Turn<W>>,
    /// Value and slope over nφ of each term of a wave.
    terms: Vec<[[f64; W]; 2]>,
}

impl<const W: usize> Turns<W> {
    pub(crate) fn new(waves: &FourierWaves) -> Self {
        let most = waves.terms.iter().map(Vec::len).max().unwrap_or(0);
        let zeros = [[0.0; W]; 2];
        Turns { turns: vec![zeros; waves.orders.len()], terms: vec![zeros; most] }
    }
}

impl FourierWaves {
    /// The value of a wave that does not vary.
    pub(crate) fn constant(&self, wave: usize) -> Option<f64> {
        self.terms[wave].is_empty().then_some(self.means[wave])
    }

    /// What the sums of a wave may hide; `None` if they show it.
    pub(crate) fn sizes(&self, wave: usize) -> Option<&Sizes> {
        self.sizes[wave].as_ref()
    }

    /// Writes the coefficients of the chosen waves after the angles φ as series over time, at the constant
    /// speeds φ': `write(i, n, c)` receives coefficient n of the i-th of `chosen`. Every lane has the same
    /// bits for any W.
    #[inline(always)]
    pub(crate) fn expand_lanes<const W: usize>(
        &self,
        [angles, speeds]: [&[f64; W]; 2],
        coefficients: usize,
        chosen: impl Iterator<Item = usize>,
        scratch: &mut Turns<W>,
        mut write: impl FnMut(usize, usize, [f64; W]),
    ) {
        let Some(weights) = &self.weights else { return };
        let Turns { turns, terms } = scratch;
        self.turn(angles, turns);
        for (place, wave) in chosen.enumerate() {
            let of_wave = &self.terms[wave];
            let terms = &mut terms[..of_wave.len()];
            for (term, &(i, [a, b])) in terms.iter_mut().zip(of_wave) {
                let [s, c] = &turns[i];
                for l in 0..W {
                    term[0][l] = a * c[l] + b * s[l];
                    term[1][l] = b * c[l] - a * s[l];
                }
            }
            let mut power = [1.0; W];
            let mut finish = |n: usize, mut sum: [f64; W]| {
                for l in 0..W {
                    sum[l] *= power[l];
                    power[l] *= speeds[l];
                }
                if n == 0 {
                    for l in 0..W {
                        sum[l] += self.means[wave];
                    }
                }
                if n < coefficients {
                    write(place, n, sum);
                }
            };
            // Four orders together: each term is read once. Four sums that do not wait for one another.
            for n in (0..coefficients).step_by(4) {
                let [mut first, mut second, mut third, mut fourth] = [[0.0; W]; 4];
                for ([value, slope], &(i, _)) in terms.iter().zip(of_wave) {
                    let [[w, x], [y, z]] = [weights[i].pair(n), weights[i].pair(n + 2)];
                    for l in 0..W {
                        first[l] += value[l] * w;
                        second[l] += slope[l] * x;
                        third[l] += value[l] * y;
                        fourth[l] += slope[l] * z;
                    }
                }
                finish(n, first);
                finish(n + 1, second);
                finish(n + 2, third);
                finish(n + 3, fourth);
            }
        }
    }
}
