//! Accelerations and slopes of a model at rest on fixed pieces: the short series of the integration in closed
//! form. At rest: all coordinates and velocities are 0.

use crate::contact::Piece;
use crate::excitation::Side;
use crate::model::Periodic;
use crate::model::structure::couplings::Couplings;
use crate::model::structure::slopes::Slopes;
use crate::periodic::balance::series::transform::{Transform, unpack};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Fourier coefficients of a real periodic function, k = 0, 1, ..., over the period of the model.
pub(crate) type Series = Vec<Complex64>;

/// Contribution of one piece: the acceleration at rest of every coordinate, and the periodic slopes in the
/// sequence of [`Couplings::varying`]. An empty series is zero.
#[derive(Clone)]
pub(crate) struct SeriesPart {
    pub(crate) accelerations: Vec<Series>,
    pub(crate) slopes: Vec<Series>,
}

/// Coefficients up to this share of the largest count as rounding `[1]`.
const ROUNDING: f64 = 4e-16;

/// Maximum of the coefficients in the highest quarter of the orders, as a share of the largest `[1]`. If they
/// exceed it, the samples are too few.
const SETTLED: f64 = 1e-13;

/// Sampler of a model at rest, with contacts on fixed pieces.
pub(crate) struct AtRest<'a, 'm> {
    model: &'m dyn Periodic,
    couplings: &'a Couplings,
    slopes: &'a mut Slopes<'m>,
    drives: Vec<Vec<f64>>,
}

/// Accelerations and periodic slopes at rest, sampled over a period.
pub(crate) struct SamplesAtRest {
    pub(crate) accelerations: Vec<Vec<f64>>,
    pub(crate) slopes: Vec<Vec<f64>>,
}

impl<'a, 'm> AtRest<'a, 'm> {
    pub(crate) fn new(
        model: &'m dyn Periodic,
        couplings: &'a Couplings,
        slopes: &'a mut Slopes<'m>,
        samples: usize,
    ) -> Self {
        let mut drives = vec![vec![0.0; model.drives()]; samples];
        for (s, u) in drives.iter_mut().enumerate() {
            model.drive(model.period() * s as f64 / samples as f64, Side::After, u);
        }
        AtRest { model, couplings, slopes, drives }
    }

    /// Evaluates the model at one instant, a share of the period, with all contacts on one piece.
    pub(crate) fn between(&mut self, piece: Piece, share: f64) -> SamplesAtRest {
        let mut u = vec![0.0; self.model.drives()];
        self.model.drive(self.model.period() * share, Side::After, &mut u);
        let samples = std::mem::replace(&mut self.drives, vec![u]);
        let sampled = self.at(&vec![piece; self.model.contacts()], 1);
        self.drives = samples;
        sampled
    }

    /// Evaluates the model at the first `samples` samples.
    pub(crate) fn at(&mut self, pieces: &[Piece], samples: usize) -> SamplesAtRest {
        let n = self.model.dof();
        let (rest, mut a) = (vec![0.0; n], vec![0.0; n]);
        let mut sampled = SamplesAtRest {
            accelerations: vec![vec![0.0; samples]; n],
            slopes: vec![vec![0.0; samples]; self.couplings.varying.len()],
        };
        for (s, u) in self.drives[..samples].iter().enumerate() {
            self.model.accel_on_pieces(pieces, u, &rest, &rest, &mut a);
            sampled.accelerations.iter_mut().zip(&a).for_each(|(f, a)| f[s] = *a);
            self.slopes.at(Some(pieces), u, &rest, &rest);
            for (values, &(i, j, velocity)) in sampled.slopes.iter_mut().zip(&self.couplings.varying) {
                values[s] =
                    if velocity { self.slopes.jacobian.v[(i, j)] } else { self.slopes.jacobian.q[(i, j)] };
            }
        }
        sampled
    }
}

impl SamplesAtRest {
    /// Whether each acceleration, then each slope, differs from the one of `other` at any of these samples.
    pub(crate) fn touched(&self, other: &SamplesAtRest) -> Vec<bool> {
        let both = self
            .accelerations
            .iter()
            .chain(&self.slopes)
            .zip(other.accelerations.iter().chain(&other.slopes));
        both.map(|(x, y)| x.iter().zip(y).any(|(x, y)| x != y)).collect()
    }

    /// The series of the differences from `less`, or of the values themselves without `less`.
    ///
    /// `only` selects accelerations, then slopes; the series of the others are empty. `None` if a series is
    /// too long for the samples.
    pub(crate) fn series(&self, less: Option<&SamplesAtRest>, only: Option<&[bool]>) -> Option<SeriesPart> {
        let wanted = |k: usize| only.is_none_or(|only| only[k]);
        let samples = self.accelerations.first().or(self.slopes.first()).map_or(0, Vec::len);
        let mut transform = Transform::new(samples);
        let mut list = |values: &[Vec<f64>], less: Option<&[Vec<f64>]>, from: usize| -> Option<Vec<Series>> {
            let one = |i: usize| {
                if !wanted(from + i) {
                    return Some(Vec::new());
                }
                let mut buffer: Vec<Complex64> = match less {
                    None => values[i].iter().map(|&x| x.into()).collect(),
                    Some(less) => values[i].iter().zip(&less[i]).map(|(x, y)| (x - y).into()).collect(),
                };
                series(&mut transform, &mut buffer)
            };
            (0..values.len()).map(one).collect()
        };
        let accelerations = list(&self.accelerations, less.map(|l| &l.accelerations[..]), 0)?;
        Some(SeriesPart {
            accelerations,
            slopes: list(&self.slopes, less.map(|l| &l.slopes[..]), self.accelerations.len())?,
        })
    }
}

/// The coefficients of samples, without trailing zeros; `None` if the highest quarter of the orders has not
/// decayed.
pub(crate) fn series(transform: &mut Transform, buffer: &mut [Complex64]) -> Option<Series> {
    let samples = buffer.len();
    transform.analyse(buffer);
    let mut series: Series = (0..samples / 2).map(|k| unpack(buffer, k).0).collect();
    let largest = series.iter().fold(0.0, |m: f64, c| m.max(c.norm_sqr()));
    if series[3 * samples / 8..].iter().any(|c| c.norm_sqr() > SETTLED * SETTLED * largest) {
        return None;
    }
    let length =
        series.iter().rposition(|c| c.norm_sqr() > ROUNDING * ROUNDING * largest).map_or(0, |last| last + 1);
    series.truncate(length);
    Some(series)
}

/// Value of a series at a share of the period.
pub(crate) fn value_at(series: &[Complex64], share: f64) -> f64 {
    let term = |(k, c): (usize, &Complex64)| {
        let (sin, cos) = libm::sincos(TAU * (k as f64 * share).fract());
        (if k == 0 { 1.0 } else { 2.0 }) * (c.re * cos - c.im * sin)
    };
    series.iter().enumerate().map(term).sum()
}
