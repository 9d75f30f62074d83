//! Fourier coefficients of accelerations and their slopes, from samples.

use crate::contact::Piece;
use crate::model::structure::couplings::{Couplings, Slope};
use crate::model::structure::slopes::{Slopes, accelerate};
use crate::periodic::balance::series::grid::Grid;
use crate::periodic::balance::series::harmonics::Harmonics;
use crate::periodic::balance::series::slope_series::SlopeTable;
use crate::periodic::balance::series::transform::{unpack, write};
use num_complex::Complex64;

/// Fourier coefficients along a motion, the result of an integration.
pub(crate) struct Spectra {
    /// Coefficients of every acceleration, in the order of the harmonics.
    pub(crate) accelerations: Vec<Vec<f64>>,
    /// D_k of every periodic slope, up to 2H.
    pub(crate) slopes: Vec<SlopeTable>,
    /// Jumps of the accelerations at crossings.
    pub(crate) jumps: Vec<Jump>,
}

/// A jump of the accelerations at a crossing. Its instant depends on the orbit.
pub(crate) struct Jump {
    /// Phase ω t of the crossing.
    pub(crate) phase: f64,
    /// (a⁺ - a⁻)/(2π dg/d(ω t)) of each coordinate: a⁻ and a⁺ are the accelerations before and after the
    /// crossing, g is the deflection minus the edge.
    pub(crate) size: Vec<f64>,
    /// ∂d/∂q_j, with d the deflection.
    pub(crate) row: Vec<f64>,
}

impl Jump {
    /// Adds the Fourier coefficients of `share` times an impulse at phase θ: share for the mean, 2 share cos
    /// kθ and 2 share sin kθ for order k.
    pub(crate) fn add(&self, block: &mut [f64], harmonics: &Harmonics, share: f64) {
        for (index, &order) in harmonics.orders().iter().enumerate() {
            let (at, (sin, cos)) = (harmonics.place(index), libm::sincos(self.phase * order as f64));
            if order == 0 {
                block[at] += share;
            } else {
                block[at] += 2.0 * cos * share;
                block[at + 1] += 2.0 * sin * share;
            }
        }
    }
}

/// Adds the coefficients of a slope times a constant. `tables`: those of the periodic slopes.
pub(crate) fn add_mean(
    tables: &[SlopeTable],
    slope: Slope,
    harmonics: &Harmonics,
    times: f64,
    column: &mut [f64],
) {
    match slope {
        Slope::Constant(b) => column[0] += times * b,
        Slope::Periodic(number) => tables[number].add(column, harmonics, 0, false, times),
    }
}

impl Spectra {
    pub(crate) fn new(dof: usize, varying: usize, harmonics: &Harmonics) -> Self {
        Spectra {
            accelerations: vec![vec![0.0; harmonics.unknowns()]; dof],
            slopes: (0..varying).map(|_| SlopeTable::new(harmonics.highest())).collect(),
            jumps: Vec::new(),
        }
    }
}

/// Accelerations and slopes at every sample.
pub(crate) struct Samples {
    /// i x M.
    pub(crate) accelerations: Vec<Vec<f64>>,
    /// Periodic slopes x M.
    pub(crate) slopes: Vec<Vec<f64>>,
    buffer: Vec<Complex64>,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
}

impl Samples {
    pub(crate) fn new(dof: usize, varying: usize, samples: usize) -> Self {
        Samples {
            accelerations: vec![vec![0.0; samples]; dof],
            slopes: vec![vec![0.0; samples]; varying],
            buffer: vec![Complex64::ZERO; samples],
            q: vec![0.0; dof],
            v: vec![0.0; dof],
            a: vec![0.0; dof],
        }
    }

    /// Samples the accelerations, on fixed pieces if these are given.
    pub(crate) fn accelerate(&mut self, grid: &Grid<'_>, pieces: Option<&[Piece]>) {
        if let [values] = &mut self.accelerations[..] {
            // One coordinate needs no copies. This saves a fifth of the residual of a Duffing oscillator at
            // 64 samples.
            for (s, a) in values.chunks_exact_mut(1).enumerate() {
                let z = grid.z[0][s];
                accelerate(grid.model, pieces, grid.drives(s), &[z.re], &[z.im], a);
            }
            return;
        }
        for s in 0..grid.samples() {
            grid.state(s, &mut self.q, &mut self.v);
            accelerate(grid.model, pieces, grid.drives(s), &self.q, &self.v, &mut self.a);
            for (values, a) in self.accelerations.iter_mut().zip(&self.a) {
                values[s] = *a;
            }
        }
    }

    /// Samples the periodic slopes, on fixed pieces if these are given.
    pub(crate) fn differentiate(
        &mut self,
        grid: &Grid<'_>,
        pieces: Option<&[Piece]>,
        slopes: &mut Slopes<'_>,
        couplings: &Couplings,
    ) {
        for s in 0..grid.samples() {
            grid.state(s, &mut self.q, &mut self.v);
            slopes.at(pieces, grid.drives(s), &self.q, &self.v);
            for (values, &(i, j, velocity)) in self.slopes.iter_mut().zip(&couplings.varying) {
                values[s] = if velocity { slopes.jacobian.v[(i, j)] } else { slopes.jacobian.q[(i, j)] };
            }
        }
    }

    /// Transforms the accelerations to coefficients at the kept orders.
    pub(crate) fn transform_accelerations(&mut self, grid: &mut Grid<'_>, out: &mut Spectra) {
        let width = out.accelerations.len();
        for pair in (0..width).step_by(2) {
            let second = if pair + 1 < width { Some(&self.accelerations[pair + 1]) } else { None };
            pack(&mut self.buffer, &self.accelerations[pair], second.map(|s| &s[..]));
            grid.transform.analyse(&mut self.buffer);
            let harmonics = grid.harmonics();
            for (i, &order) in harmonics.orders().iter().enumerate() {
                let ((x, y), at) = (unpack(&self.buffer, order), harmonics.place(i));
                write(&mut out.accelerations[pair][at..], order, x);
                if pair + 1 < width {
                    write(&mut out.accelerations[pair + 1][at..], order, y);
                }
            }
        }
    }

    /// Transforms the slopes to coefficients of the orders 0 ..= 2H.
    pub(crate) fn transform_slopes(&mut self, grid: &mut Grid<'_>, out: &mut Spectra) {
        let width = out.slopes.len();
        for pair in (0..width).step_by(2) {
            let second = if pair + 1 < width { Some(&self.slopes[pair + 1]) } else { None };
            pack(&mut self.buffer, &self.slopes[pair], second.map(|s| &s[..]));
            grid.transform.analyse(&mut self.buffer);
            // A slope that is zero gets no rounding errors of its companion.
            let largest = self.buffer.iter().fold(0.0, |m: f64, z| m.max(z.norm_sqr()))
                / (self.buffer.len() as f64).powi(2);
            let clean = |z: Complex64| if z.norm_sqr() <= 1e-30 * largest { Complex64::ZERO } else { z };
            for k in 0..=out.slopes[pair].reach() {
                let (x, y) = unpack(&self.buffer, k);
                let (x, y) = (clean(x), clean(y));
                out.slopes[pair].set(k, x);
                if pair + 1 < width {
                    out.slopes[pair + 1].set(k, y);
                }
            }
        }
    }
}

/// buffer ← x + i y, two real signals for one transform.
pub(crate) fn pack(buffer: &mut [Complex64], x: &[f64], y: Option<&[f64]>) {
    match y {
        Some(y) => buffer.iter_mut().zip(x.iter().zip(y)).for_each(|(z, (x, y))| *z = Complex64::new(*x, *y)),
        None => buffer.iter_mut().zip(x).for_each(|(z, x)| *z = Complex64::new(*x, 0.0)),
    }
}
