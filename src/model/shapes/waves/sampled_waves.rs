//! The waves of a shape as Fourier series, from samples.

use crate::excitation::Side;
use crate::model::shapes::shape::Shape;
use crate::model::shapes::waves::fourier_angle::Harmonics;
use crate::model::shapes::waves::fourier_waves::FourierWaves;
use crate::numeric::spread::GOLDEN_POINTS;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;
use std::f64::consts::TAU;

/// Largest and smallest number of samples of each wave over one repetition. The largest number is halved
/// until all waves together have at most `ALL_SAMPLES`. The samples do not see a smooth pulse that is
/// narrower than their spacing.
const SAMPLES: [usize; 2] = [4096, 512];
const ALL_SAMPLES: usize = 1 << 22;

/// A harmonic below this number of the largest ones in the upper half of the spectrum is rounding.
const ABOVE_NOISE: f64 = 2.0;

/// Allowed share of the largest sample in the upper half of the spectrum `[1]`: above it the samples are too
/// few.
const TAIL: f64 = 1e-15;

/// Allowed difference between series and wave at points between the samples, as a share of the largest sample
/// `[1]`.
const DIFFERENCE: f64 = 1e-14;

/// The waves at an angle, in their order.
type Waves<'w> = &'w dyn Fn(f64, &mut [f64]);

impl FourierWaves {
    /// The waves of a shape from samples, exact to rounding; `None` if it has edges, or waves whose harmonics
    /// do not decay.
    pub(crate) fn sampled<G: Shape>(shape: &G) -> Option<Self> {
        if shape.next_edge(0.0).is_some() {
            return None;
        }
        let waves = |angle: f64, u: &mut [f64]| shape.waves(angle, Side::After, u);
        FourierWaves::of_samples(shape.size().waves, shape.repeats().max(1), &waves)
    }

    /// Compiled once, in this crate: the planner of the transform is large.
    fn of_samples(count: usize, repeats: u32, at: Waves<'_>) -> Option<Self> {
        let waves = FourierWaves::new(&harmonics(count, repeats, at)?, repeats);
        // With too many orders the sums are neither written nor expanded.
        (waves.weights.is_some() && waves.agree_with(repeats, at)).then_some(waves)
    }

    /// Whether the series agree with the waves at points between the samples.
    fn agree_with(&self, repeats: u32, at: Waves<'_>) -> bool {
        let [mut u, mut sums] = [vec![0.0; self.means.len()], vec![0.0; self.means.len()]];
        GOLDEN_POINTS.iter().all(|place| {
            let angle = place * TAU / f64::from(repeats);
            at(angle, &mut u);
            self.write(angle, &mut sums);
            self.means.iter().zip(&self.terms).zip(u.iter().zip(&sums)).all(|((mean, terms), (u, sum))| {
                let size = terms.iter().fold(mean.abs(), |size, (_, [a, b])| size + a.abs() + b.abs());
                sum == u || (!terms.is_empty() && (sum - u).abs() <= DIFFERENCE * size)
            })
        })
    }
}

/// The harmonics of the waves from samples; `None` if they are too few.
fn harmonics(waves: usize, repeats: u32, at: Waves<'_>) -> Option<Vec<Harmonics>> {
    let mut count = SAMPLES[0];
    while count > SAMPLES[1] && count * waves > ALL_SAMPLES {
        count /= 2;
    }
    let mut samples = vec![vec![0.0; count]; waves];
    let mut u = vec![0.0; waves];
    for i in 0..count {
        at(TAU * i as f64 / (count as f64 * f64::from(repeats)), &mut u);
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
        let least = ABOVE_NOISE * noise;
        let own: Vec<usize> = (1..count / 4).filter(|&k| size(k) > least).collect();
        let pair = |k: usize| [2.0 * spectrum[k].re / count as f64, -2.0 * spectrum[k].im / count as f64];
        let mean = spectrum[0].re / count as f64;
        all.push((mean, own.into_iter().map(|k| (k, pair(k))).collect()));
    }
    Some(all)
}
