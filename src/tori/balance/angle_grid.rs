//! A grid of equidistant angles and its Fourier transform.

use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Points 2π (j_1/N_1, ..., j_D/N_D); the last index is the fastest.
pub(crate) struct AngleGrid {
    sizes: Vec<usize>,
    forward: Vec<Arc<dyn Fft<f64>>>,
    inverse: Vec<Arc<dyn Fft<f64>>>,
    line: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

/// The smallest number of at least `least` whose prime factors are 2, 3 and 5.
fn smooth(least: usize) -> usize {
    let is_smooth = |mut n: usize| {
        for p in [2, 3, 5] {
            while n.is_multiple_of(p) {
                n /= p;
            }
        }
        n == 1
    };
    (least.max(1)..).find(|n| is_smooth(*n)).unwrap_or(least)
}

impl AngleGrid {
    /// A grid of at least `factor` (2 H_d + 1) points along angle d.
    pub(crate) fn sizes(highest: &[usize], factor: usize) -> Vec<usize> {
        highest.iter().map(|h| smooth((2 * h + 1).saturating_mul(factor))).collect()
    }

    pub(crate) fn new(sizes: &[usize]) -> Self {
        let mut planner = FftPlanner::new();
        let forward: Vec<_> = sizes.iter().map(|n| planner.plan_fft_forward(*n)).collect();
        let inverse: Vec<_> = sizes.iter().map(|n| planner.plan_fft_inverse(*n)).collect();
        let room = forward.iter().chain(&inverse).map(|fft| fft.get_inplace_scratch_len()).max().unwrap_or(0);
        let longest = sizes.iter().copied().max().unwrap_or(0);
        let zero = Complex64::new(0.0, 0.0);
        let (line, scratch) = (vec![zero; longest], vec![zero; room]);
        AngleGrid { sizes: sizes.to_vec(), forward, inverse, line, scratch }
    }

    /// Number of points.
    pub(crate) fn len(&self) -> usize {
        self.sizes.iter().product()
    }

    /// Writes the angles of a point.
    pub(crate) fn angles(&self, point: usize, angles: &mut [f64]) {
        let mut rest = point;
        for (angle, n) in angles.iter_mut().zip(&self.sizes).rev() {
            *angle = TAU * (rest % n) as f64 / *n as f64;
            rest /= n;
        }
    }

    /// Place of exp(i k·θ) in a transform, for k given by its entries; orders are taken modulo the sizes.
    pub(crate) fn place(&self, k: impl Iterator<Item = i32>) -> usize {
        k.zip(&self.sizes).fold(0, |place, (k, n)| place * n + (k as i64).rem_euclid(*n as i64) as usize)
    }

    /// Σ_j z_j exp(-i k·θ_j) in place, without a factor.
    pub(crate) fn analyse(&mut self, z: &mut [Complex64]) {
        self.transform(z, true);
    }
    /// Σ_k z_k exp(i k·θ_j) in place.
    pub(crate) fn synthesise(&mut self, z: &mut [Complex64]) {
        self.transform(z, false);
    }

    fn transform(&mut self, z: &mut [Complex64], forward: bool) {
        let AngleGrid { sizes, line, scratch, .. } = self;
        let mut stride = 1;
        for (d, &n) in sizes.iter().enumerate().rev() {
            let fft = if forward { &self.forward[d] } else { &self.inverse[d] };
            if stride == 1 {
                fft.process_with_scratch(z, scratch);
            } else {
                let line = &mut line[..n];
                for block in z.chunks_exact_mut(n * stride) {
                    for offset in 0..stride {
                        line.iter_mut().enumerate().for_each(|(j, x)| *x = block[j * stride + offset]);
                        fft.process_with_scratch(line, scratch);
                        line.iter().enumerate().for_each(|(j, x)| block[j * stride + offset] = *x);
                    }
                }
            }
            stride *= n;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_transform_is_the_sum_over_all_points() {
        let sizes = [4, 3, 5];
        let mut grid = AngleGrid::new(&sizes);
        let samples: Vec<Complex64> =
            (0..grid.len()).map(|j| Complex64::new((j as f64).sin(), (2.0 * j as f64).cos())).collect();
        let mut spectrum = samples.clone();
        grid.analyse(&mut spectrum);
        let mut angles = [0.0; 3];
        for k in [[0, 0, 0], [1, -1, 2], [-2, 1, -1], [3, 0, 4]] {
            let mut sum = Complex64::new(0.0, 0.0);
            for (j, x) in samples.iter().enumerate() {
                grid.angles(j, &mut angles);
                let phase: f64 = k.iter().zip(&angles).map(|(k, angle)| f64::from(*k) * angle).sum();
                sum += x * Complex64::cis(-phase);
            }
            assert!((spectrum[grid.place(k.into_iter())] - sum).norm() < 1e-12);
        }
        grid.synthesise(&mut spectrum);
        assert!(spectrum.iter().zip(&samples).all(|(a, b)| (a / 60.0 - b).norm() < 1e-14));
    }

    #[test]
    fn sizes_have_small_factors() {
        assert_eq!(AngleGrid::sizes(&[3, 11, 1], 2), [15, 48, 6]);
    }
}
