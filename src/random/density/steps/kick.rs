//! The random part of a step: an Ornstein-Uhlenbeck step of the velocity.

use crate::random::density::panels::Panels;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// v' = -κ v + √D ξ over a duration h: v(h) = exp(-κ h) v(0) + s Z, with s² = D (1 - exp(-2 κ h))/(2 κ).
///
/// p(v, h) = exp(κ h) ∫ φ(z) p(exp(κ h) (v - s z), 0) dz, φ the normal density. The trapezoidal rule with
/// the spacing 1/2 integrates it to rounding. The result is a matrix for the values at the nodes.
#[derive(Clone, Debug)]
pub(crate) struct Kick {
    /// For each node the first node that it reads, and the factors.
    rows: Vec<(usize, Vec<f64>)>,
}

impl Kick {
    pub(crate) fn new<const N: usize>(axis: &Panels<N>, damping: f64, intensity: f64, duration: f64) -> Self {
        let rate = damping * duration;
        let spread = if rate == 0.0 { 1.0 } else { -libm::expm1(-2.0 * rate) / (2.0 * rate) };
        let (growth, deviation) = (libm::exp(rate), (intensity * duration * spread).sqrt());
        let row = |v: f64| {
            let mut factors = vec![0.0; axis.len()];
            for k in -16..=16 {
                let z = 0.5 * f64::from(k);
                let density = 0.5 * libm::exp(-0.5 * z * z) / TAU.sqrt();
                if let Some((first, values)) = axis.stencil(growth * (v - deviation * z)) {
                    factors[first..].iter_mut().zip(values).for_each(|(f, l)| *f += growth * density * l);
                }
            }
            let first = factors.iter().position(|f| *f != 0.0).unwrap_or(0);
            let end = factors.iter().rposition(|f| *f != 0.0).map_or(0, |last| last + 1);
            (first, factors[first..end.max(first)].to_vec())
        };
        Kick { rows: axis.nodes.iter().map(|v| row(*v)).collect() }
    }

    /// Writes the density after the step to `to`.
    pub(crate) fn apply(&self, from: &[f64], to: &mut [f64]) {
        let width = self.rows.len();
        to.par_chunks_mut(width).zip(from.par_chunks(width)).for_each(|(to, from)| {
            for (to, (first, factors)) in to.iter_mut().zip(&self.rows) {
                *to = factors.iter().zip(&from[*first..]).map(|(f, p)| f * p).sum();
            }
        });
    }
}
