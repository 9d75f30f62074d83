//! The waves of a shape as Fourier series, from which their Taylor series follow: exact ones, or from samples.

use crate::excitation::side::Side;
use crate::model::expansion::fourier_angle::{Harmonics, fourier_waves};
use crate::model::shape::Shape;
use crate::numeric::sine::sin_cos;
use crate::numeric::spread::GOLDEN_POINTS;
use crate::series::{BLOCKS, EIGHT, Series, wave_weights};
use pulp::Arch;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;
use std::f64::consts::TAU;

type Coefficients = [[f64; EIGHT]; BLOCKS];

/// Largest and smallest number of samples of each wave over one repetition. The largest number is halved
/// until all waves together have at most `ALL_SAMPLES`. The samples do not see a smooth pulse that is narrower
/// than their spacing.
const SAMPLES: [usize; 2] = [4096, 512];
const ALL_SAMPLES: usize = 1 << 22;

/// A harmonic below this number of the largest ones in the upper half of the spectrum is rounding.
const ROUNDING: f64 = 2.0;

/// Allowed share of the largest sample in the upper half of the spectrum `[1]`: above it the samples are too
/// few.
const TAIL: f64 = 1e-15;

/// Allowed difference between series and wave at points between the samples, as a share of the largest sample
/// `[1]`.
const DIFFERENCE: f64 = 1e-14;

/// Maximum number of harmonics of a wave, and of different orders of all waves.
const HARMONICS: usize = 128;
const ROOM: usize = 512;
const FEW: usize = 16;

/// The waves of a shape without edges: f(φ) = mean + Σ a cos nφ + b sin nφ, exact to rounding.
pub(crate) struct WaveTable {
    /// All orders n, increasing, with ±n^k/k! for each k.
    orders: Vec<(f64, Coefficients)>,
    /// Mean of each wave, and index of the order, a and b of each of its harmonics a cos nφ + b sin nφ.
    waves: Vec<Harmonics>,
    arch: Arch,
}

impl WaveTable {
    /// The table of a shape; `None` if it has edges, or waves whose harmonics do not decay.
    pub(crate) fn of<G: Shape>(shape: &G) -> Option<Self> {
        let waves = shape.size().waves;
        if shape.next_edge(0.0).is_some() {
            return None;
        }
        if let Some(exact) = fourier_waves(shape) {
            return WaveTable::from_harmonics(exact, 1);
        }
        let repeats = shape.repeats().max(1);
        let table = WaveTable::from_harmonics(sampled(shape, waves, repeats)?, repeats)?;
        table.agrees_with(shape, repeats).then_some(table)
    }

    /// The table of harmonics whose orders count repetitions; `None` if there are too many.
    fn from_harmonics(mut waves: Vec<Harmonics>, repeats: u32) -> Option<Self> {
        let mut orders: Vec<usize> =
            waves.iter().flat_map(|(_, own)| own.iter().map(|(order, _)| *order)).collect();
        orders.sort_unstable();
        orders.dedup();
        if orders.len() > ROOM || waves.iter().any(|(_, own)| own.len() > HARMONICS) {
            return None;
        }
        for (_, own) in &mut waves {
            own.iter_mut().for_each(|(k, _)| *k = orders.partition_point(|order| order < k));
        }
        let weights = |k: &usize| {
            let n = *k as f64 * f64::from(repeats);
            (n, wave_weights(n))
        };
        Some(WaveTable { orders: orders.iter().map(weights).collect(), waves, arch: Arch::new() })
    }

    /// Whether the series agree with the waves at points between the samples.
    fn agrees_with<G: Shape>(&self, shape: &G, repeats: u32) -> bool {
        let mut u = vec![0.0; self.waves.len()];
        GOLDEN_POINTS.iter().all(|place| {
            let angle = place * TAU / f64::from(repeats);
            shape.waves(angle, Side::After, &mut u);
            let turns = self.turns(angle);
            self.waves.iter().zip(&u).all(|((mean, own), u)| {
                let terms = own.iter().map(|&(i, [a, b])| a * turns[i].1 + b * turns[i].0);
                let size = own.iter().fold(mean.abs(), |size, (_, [a, b])| size + a.abs() + b.abs());
                (own.is_empty() && mean == u) || (mean + terms.sum::<f64>() - u).abs() <= DIFFERENCE * size
            })
        })
    }

    /// sin nφ and cos nφ of all orders.
    fn turns(&self, angle: f64) -> Vec<(f64, f64)> {
        let mut turns = vec![(0.0, 0.0); self.orders.len()];
        self.turn(angle, &mut turns);
        turns
    }
    fn turn(&self, angle: f64, turns: &mut [(f64, f64)]) {
        let Some((first, _)) = self.orders.first() else { return };
        let step = sin_cos(first * angle);
        let mut last = (*first, step);
        for ((n, _), turn) in self.orders.iter().zip(turns) {
            let (before, (s, c)) = last;
            // A neighbouring order by one rotation, any other by a sine and a cosine of its own.
            *turn = match n - before {
                0.0 => step,
                ahead if ahead == *first => (s * step.1 + c * step.0, c * step.1 - s * step.0),
                _ => sin_cos(n * angle),
            };
            last = (*n, *turn);
        }
    }

    /// Writes the needed waves after the angle φ as series over time, at the constant speed φ'. Waves beyond the
    /// end of `needed` are needed, too.
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
            _ => self.expand_in::<ROOM>(angle, speed, coefficients, needed, u),
        }
    }

    /// [`expand`](WaveTable::expand) with room for the sines and cosines of this number of orders.
    fn expand_in<const SPACE: usize>(
        &self,
        angle: f64,
        speed: f64,
        coefficients: usize,
        needed: &[bool],
        u: &mut [Series],
    ) {
        let mut turns = [(0.0, 0.0); SPACE];
        let turns = &mut turns[..self.orders.len()];
        self.turn(angle, turns);
        self.arch.dispatch(Expansion { table: self, turns, speed, coefficients, needed, u });
    }
}

/// The harmonics of the waves from samples; `None` if they are too few.
fn sampled<G: Shape>(shape: &G, waves: usize, repeats: u32) -> Option<Vec<Harmonics>> {
    let mut count = SAMPLES[0];
    while count > SAMPLES[1] && count * waves > ALL_SAMPLES {
        count /= 2;
    }
    let mut samples = vec![vec![0.0; count]; waves];
    let mut u = vec![0.0; waves];
    for i in 0..count {
        shape.waves(TAU * i as f64 / (count as f64 * f64::from(repeats)), Side::After, &mut u);
        samples.iter_mut().zip(&u).for_each(|(samples, u)| samples[i] = *u);
    }
    let fft = FftPlanner::new().plan_fft_forward(count);
    let mut all = Vec::with_capacity(waves);
    for samples in &samples {
        let first = samples[0];
        if samples.iter().all(|x| *x == first) {
            all.push((first, Vec::new()));
            continue;
        }
        let largest = samples.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        if !largest.is_finite() {
            return None;
        }
        let mut spectrum: Vec<Complex64> = samples.iter().map(|x| (*x).into()).collect();
        fft.process(&mut spectrum);
        let size = |k: usize| spectrum[k].norm() / count as f64;
        // The upper half of the spectrum is rounding, or shows that the samples are too few.
        let noise = (count / 4..=count / 2).fold(0.0, |m: f64, k| m.max(size(k)));
        if noise > TAIL * largest {
            return None;
        }
        let least = ROUNDING * noise;
        let own: Vec<usize> = (1..count / 4).filter(|&k| size(k) > least).collect();
        let pair = |k: usize| [2.0 * spectrum[k].re / count as f64, -2.0 * spectrum[k].im / count as f64];
        let mean = spectrum[0].re / count as f64;
        all.push((mean, own.into_iter().map(|k| (k, pair(k))).collect()));
    }
    Some(all)
}

/// The sums over the harmonics, compiled for the instructions of the processor.
struct Expansion<'e> {
    table: &'e WaveTable,
    turns: &'e [(f64, f64)],
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
        let Expansion { table, turns, speed, coefficients, needed, u } = self;
        let mut powers = [[0.0; EIGHT]; USED];
        let mut power = 1.0;
        for out in &mut powers[0] {
            *out = power;
            power *= speed;
        }
        for k in 1..USED {
            powers[k] = powers[k - 1].map(|below| below * power);
        }
        for (k, ((mean, harmonics), u)) in table.waves.iter().zip(u).enumerate() {
            if needed.get(k) == Some(&false) {
                continue;
            }
            if harmonics.is_empty() {
                u.set_constant(*mean);
                continue;
            }
            let mut sums = [[0.0; EIGHT]; USED];
            sums[0][0] = *mean;
            for &(i, [a, b]) in harmonics {
                let (s, c) = turns[i];
                let [value, slope] = [a * c + b * s, b * c - a * s];
                let pattern = [value, slope, value, slope, value, slope, value, slope];
                for (sum, weights) in sums.iter_mut().zip(&table.orders[i].1) {
                    for l in 0..EIGHT {
                        sum[l] += pattern[l] * weights[l];
                    }
                }
            }
            for (sum, powers) in sums.iter_mut().zip(&powers) {
                for l in 0..EIGHT {
                    sum[l] *= powers[l];
                }
            }
            u.set(&sums, coefficients);
        }
    }
}
