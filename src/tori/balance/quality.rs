//! Measures of the error of a torus.

use crate::excitation::Side;
use crate::numeric::norms::largest;
use crate::numeric::spread::weyl;
use crate::ode::Exhausted;
use crate::ode::budget::Meter;
use crate::tori::balance::torus::{Torus, rate};
use crate::tori::balance::torus_equations::TorusEquations;
use crate::tori::balance::wave_vectors::WaveVectors;
use crate::tori::quasi_periodic::QuasiPeriodic;
use std::f64::consts::TAU;

impl Torus {
    /// Largest residual of the balance, over the size of its coordinate. NaN for a torus that was not solved,
    /// as for the other measures of error.
    pub fn residual(&self) -> f64 {
        self.quality.residual
    }
    /// max |q'' - a(u, q, q')| over max |a|, at angles between the points of the grid `[1]`: the residual of
    /// the equation itself, which contains all orders. The largest value among the coordinates.
    pub fn residual_between(&self) -> f64 {
        self.quality.between
    }
    /// Change of the kept coefficients of the accelerations on a grid twice as fine, over the largest of them
    /// `[1]`. The largest value among the coordinates.
    pub fn aliasing(&self) -> f64 {
        self.quality.aliasing
    }
    /// Number of Newton corrections.
    pub fn iterations(&self) -> usize {
        self.quality.iterations
    }
    /// Number of evaluations of the balance, without those for the measures of error.
    pub fn evaluations(&self) -> usize {
        self.quality.evaluations
    }
    /// The largest residual of every iterate, the guess first.
    pub fn residuals(&self) -> &[f64] {
        &self.quality.residuals
    }

    /// Largest amplitude at the outermost wave vectors, over the largest amplitude apart from the mean `[1]`:
    /// an estimate of the error by the orders that are not kept. The largest value among the coordinates. A
    /// vector is outermost if a neighbour, one order higher or lower in one angle, is not kept.
    pub fn outermost_share(&self) -> f64 {
        let vectors = self.wave_vectors();
        (0..self.dof()).fold(0.0, |most: f64, j| {
            let (mut all, mut outer) = (0.0f64, 0.0f64);
            for (index, k) in vectors.vectors().enumerate().skip(1) {
                let amplitude = self.amplitude(j, k);
                all = all.max(amplitude);
                if vectors.is_outermost(index) {
                    outer = outer.max(amplitude);
                }
            }
            if all > 0.0 { most.max(outer / all) } else { most }
        })
    }

    /// The smallest |k·ω| of the kept vectors other than 0, and that vector: how close the base frequencies
    /// are to a resonance within the kept orders.
    pub fn smallest_rate(&self) -> (f64, Vec<i32>) {
        smallest_rate(self.wave_vectors(), self.frequencies())
    }
}

/// The smallest |k·ω| of wave vectors other than 0, and its vector.
pub(crate) fn smallest_rate(vectors: &WaveVectors, frequencies: &[f64]) -> (f64, Vec<i32>) {
    let mut smallest = (f64::INFINITY, &[][..]);
    for k in vectors.vectors().skip(1) {
        let rate = rate(k, frequencies).abs();
        if rate < smallest.0 {
            smallest = (rate, k);
        }
    }
    (smallest.0, smallest.1.to_vec())
}

/// Number of angles at which the equation is evaluated, per wave vector, and its limits.
const PER_VECTOR: usize = 8;
const LIMITS: (usize, usize) = (256, 8192);

/// max |q'' - a| over max |a| of every coordinate, at evenly spread angles; the largest of them.
pub(crate) fn between(model: &dyn QuasiPeriodic, torus: &Torus, meter: &Meter<'_>) -> Result<f64, Exhausted> {
    let n = model.dof();
    let count = (PER_VECTOR * torus.wave_vectors().len()).clamp(LIMITS.0, LIMITS.1);
    let (mut u, mut angles) = (vec![0.0; model.drives()], vec![0.0; torus.frequencies().len()]);
    let [mut q, mut v, mut second, mut a] = [(); 4].map(|()| vec![0.0; n]);
    let (mut miss, mut size) = (vec![0.0; n], vec![0.0f64; n]);
    for index in 0..count {
        meter.check()?;
        angles.iter_mut().enumerate().for_each(|(d, angle)| *angle = TAU * weyl(index, d));
        torus.motion(&angles, [&mut q, &mut v, &mut second]);
        model.drive_at(&angles, Side::After, &mut u);
        model.accel(&u, &q, &v, &mut a);
        for i in 0..n {
            miss[i] = largest(&[miss[i], second[i] - a[i]]);
            size[i] = size[i].max(a[i].abs());
        }
    }
    Ok(shares(&miss, &size))
}

/// Largest change of the coefficients of the accelerations from one grid to another, over the largest
/// coefficient.
pub(crate) fn aliasing(coarse: &mut TorusEquations<'_>, fine: &mut TorusEquations<'_>, torus: &Torus) -> f64 {
    let (x, y) = (coarse.unknowns(torus), fine.unknowns(torus));
    let width = torus.wave_vectors().unknowns();
    let pairs = coarse.forces(&x).chunks_exact(width).zip(fine.forces(&y).chunks_exact(width));
    let (miss, size): (Vec<f64>, Vec<f64>) = pairs
        .map(|(a, b)| {
            let change: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
            (largest(&change), largest(b))
        })
        .unzip();
    shares(&miss, &size)
}

/// The largest miss over its size; 0 for a miss of 0.
fn shares(miss: &[f64], size: &[f64]) -> f64 {
    let all: Vec<f64> = miss.iter().zip(size).map(|(m, s)| if *m == 0.0 { 0.0 } else { m / s }).collect();
    largest(&all)
}
