//! The waves of a shape as Taylor series over time.

use crate::excitation::wave_weights::WaveWeights;
use crate::model::shapes::waves::fourier_waves::{FEW, FourierWaves, ORDERS, Turn};
use crate::series::{BLOCKS, EIGHT, Series};

impl FourierWaves {
    /// Writes the needed waves after the angle φ as series over time, at the constant speed φ'. Waves beyond
    /// the end of `needed` are needed, too.
    pub(crate) fn expand(
        &self,
        angle: f64,
        speed: f64,
        coefficients: usize,
        needed: &[bool],
        u: &mut [Series],
    ) {
        // Few orders need no large array, which would be cleared at every step.
        match self.orders.len() {
            0..=FEW => self.expand_in::<FEW>(angle, speed, coefficients, needed, u),
            _ => self.expand_in::<ORDERS>(angle, speed, coefficients, needed, u),
        }
    }

    /// [`expand`](FourierWaves::expand) with room for the sines and cosines of this number of orders.
    fn expand_in<const SPACE: usize>(
        &self,
        angle: f64,
        speed: f64,
        coefficients: usize,
        needed: &[bool],
        u: &mut [Series],
    ) {
        let Some(weights) = &self.weights else { return };
        let mut turns = [[[0.0]; 2]; SPACE];
        self.turn(&[angle], &mut turns);
        let sums = Expansion { waves: self, weights, turns: &turns, speed, coefficients, needed, u };
        self.arch.dispatch(sums);
    }
}

/// The sums over the harmonics, compiled for the instructions of the processor.
struct Expansion<'e> {
    waves: &'e FourierWaves,
    weights: &'e [WaveWeights],
    /// sin nφ and cos nφ of all orders.
    turns: &'e [Turn<1>],
    speed: f64,
    coefficients: usize,
    needed: &'e [bool],
    u: &'e mut [Series],
}

impl pulp::WithSimd for Expansion<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        match self.coefficients.div_ceil(EIGHT) {
            0..=2 => self.sums::<2>(),
            3 => self.sums::<3>(),
            _ => self.sums::<BLOCKS>(),
        }
    }
}

impl Expansion<'_> {
    /// The sums, with this number of blocks of coefficients.
    #[inline(always)]
    fn sums<const USED: usize>(self) {
        let Expansion { waves, weights, turns, speed, coefficients, needed, u } = self;
        let mut powers = [[0.0; EIGHT]; USED];
        let mut power = 1.0;
        for out in &mut powers[0] {
            *out = power;
            power *= speed;
        }
        for k in 1..USED {
            powers[k] = powers[k - 1].map(|below| below * power);
        }
        for (k, ((mean, terms), u)) in waves.means.iter().zip(&waves.terms).zip(u).enumerate() {
            if needed.get(k) == Some(&false) {
                continue;
            }
            if terms.is_empty() {
                u.set_constant(*mean);
                continue;
            }
            let mut sums = [[0.0; EIGHT]; USED];
            sums[0][0] = *mean;
            for &(i, [a, b]) in terms {
                let [[s], [c]] = turns[i];
                weights[i].add([a * c + b * s, b * c - a * s], &mut sums);
            }
            for (sum, powers) in sums.iter_mut().zip(&powers) {
                for l in 0..EIGHT {
                    sum[l] *= powers[l];
                }
            }
            u.set(&sums, coefficients);
            // The sums stay in registers, and are read again where they were written to.
            if let Some(sizes) = &waves.sizes[k] {
                let steepness = sizes.steepness(u.coefficients(), speed, |k| powers[k / EIGHT][k % EIGHT]);
                u.set_hidden(steepness, f64::EPSILON * sizes.at(0));
            }
        }
    }
}
