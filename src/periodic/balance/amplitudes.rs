//! Sizes of the coordinates of an orbit: the scales of the unknowns.

use crate::numeric::norms::largest;
use crate::periodic::balance::fourier_orbit::{AT_REST, FourierOrbit};

/// Size of every coordinate: Σ |coefficients|. A coordinate at rest gets the largest size; if all are at
/// rest, the size is 1.
pub(crate) fn sizes(orbit: &FourierOrbit) -> Vec<f64> {
    sizes_apart(orbit, &[])
}

/// [`sizes`] without the mean position along the rigid motions. That position is arbitrary and may be large.
pub(crate) fn sizes_apart(orbit: &FourierOrbit, rigid: &[Vec<f64>]) -> Vec<f64> {
    let mut means: Vec<f64> = (0..orbit.dof()).map(|j| orbit.mean(j)).collect();
    for r in rigid {
        let share: f64 = r.iter().zip(&means).map(|(r, mean)| r * mean).sum();
        means.iter_mut().zip(r).for_each(|(mean, r)| *mean -= share * r);
    }
    let swing = |j: usize| {
        orbit
            .coefficients(j)
            .iter()
            .skip(usize::from(orbit.harmonics().has_mean()))
            .map(|c| c.abs())
            .sum::<f64>()
    };
    let own: Vec<f64> = means.iter().enumerate().map(|(j, mean)| mean.abs() + swing(j)).collect();
    let most = largest(&own);
    let fallback = if most > 0.0 { most } else { 1.0 };
    own.iter().map(|&s| if s > AT_REST * fallback { s } else { fallback }).collect()
}
