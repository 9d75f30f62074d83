//! Drives and motion at M uniform instants of one span.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::Periodic;
use crate::periodic::balance::series::harmonics::Harmonics;
use crate::periodic::balance::series::transform::{Transform, spread};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// A model sampled at t_s = s p T/M, s = 0 .. M - 1.
pub(crate) struct Grid<'m> {
    pub(crate) model: &'m dyn Periodic,
    harmonics: Harmonics,
    span: f64,
    /// Drives at all instants: M x drives.
    u: Vec<f64>,
    drives: usize,
    /// q + i v of every coordinate at every instant.
    pub(crate) z: Vec<Vec<Complex64>>,
    pub(crate) transform: Transform,
}

impl<'m> Grid<'m> {
    /// The same grid with another model; drives and motion are kept.
    pub(crate) fn with_model(self, model: &dyn Periodic) -> Grid<'_> {
        let Grid { harmonics, span, u, drives, z, transform, .. } = self;
        Grid { model, harmonics, span, u, drives, z, transform }
    }
}

impl<'m> Grid<'m> {
    pub(crate) fn new(model: &'m dyn Periodic, harmonics: &Harmonics, samples: usize) -> Self {
        let (drives, span) = (model.drives(), model.period() * harmonics.period_multiple() as f64);
        let mut u = vec![0.0; samples * drives];
        // If M is a multiple of p, the drives of one period repeat.
        let distinct = if samples.is_multiple_of(harmonics.period_multiple()) {
            samples / harmonics.period_multiple()
        } else {
            samples
        };
        for s in 0..distinct {
            model.drive(span * s as f64 / samples as f64, Side::After, &mut u[s * drives..(s + 1) * drives]);
        }
        for s in distinct..samples {
            u.copy_within((s - distinct) * drives..(s - distinct + 1) * drives, s * drives);
        }
        Grid {
            model,
            harmonics: harmonics.clone(),
            span,
            u,
            drives,
            z: vec![vec![Complex64::ZERO; samples]; model.dof()],
            transform: Transform::new(samples),
        }
    }

    /// Reads the period and the drives of the model anew. `constants`: only drives that are the same at every
    /// phase have changed; they are read at one instant.
    pub(crate) fn redrive(&mut self, constants: bool) {
        let (model, drives) = (self.model, self.drives);
        self.span = model.period() * self.harmonics.period_multiple() as f64;
        let (samples, step) = (self.samples(), self.step());
        if !constants {
            for (s, u) in self.u.chunks_exact_mut(drives.max(1)).enumerate() {
                model.drive(step * s as f64, Side::After, u);
            }
            return;
        }
        let mut first = vec![0.0; drives];
        model.drive(0.0, Side::After, &mut first);
        for (k, value) in first.iter().enumerate() {
            if self.u[k] != *value {
                (0..samples).for_each(|s| self.u[s * drives + k] = *value);
            }
        }
    }

    pub(crate) fn samples(&self) -> usize {
        self.z.first().map_or(0, Vec::len)
    }
    pub(crate) fn dof(&self) -> usize {
        self.z.len()
    }
    pub(crate) fn harmonics(&self) -> &Harmonics {
        &self.harmonics
    }
    pub(crate) fn span(&self) -> f64 {
        self.span
    }
    pub(crate) fn omega(&self) -> f64 {
        TAU / self.span
    }
    /// Time between two instants.
    pub(crate) fn step(&self) -> f64 {
        self.span / self.samples() as f64
    }

    /// Sets the motion from its coefficients and its mean velocities. Coordinates are without their drift.
    pub(crate) fn set(&mut self, coefficients: &[f64], speeds: &[f64]) {
        let (width, omega) = (self.harmonics.unknowns(), self.omega());
        for ((z, part), speed) in self.z.iter_mut().zip(coefficients.chunks_exact(width)).zip(speeds) {
            spread(part, &self.harmonics, omega, z);
            z[0].im += speed;
            self.transform.synthesise(z);
        }
    }

    /// Whether a contact is in its gap at all of at least 32 instants, or at all instants if there are fewer.
    pub(crate) fn any_floats(&self) -> bool {
        if self.model.contacts() == 0 {
            return false;
        }
        let (n, stride) = (self.dof(), (self.samples() / 32).max(1));
        let mut contacts = vec![Contact::default(); self.model.contacts()];
        let mut touched = vec![false; contacts.len()];
        let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
        for s in (0..self.samples()).step_by(stride) {
            self.state(s, &mut q, &mut v);
            self.model.contact(self.drives(s), &q, &v, &mut contacts);
            touched.iter_mut().zip(&contacts).for_each(|(t, c)| *t |= c.piece() != Piece::Gap);
        }
        touched.contains(&false)
    }

    #[inline]
    pub(crate) fn drives(&self, s: usize) -> &[f64] {
        &self.u[s * self.drives..(s + 1) * self.drives]
    }

    #[inline]
    pub(crate) fn state(&self, s: usize, q: &mut [f64], v: &mut [f64]) {
        for ((q, v), z) in q.iter_mut().zip(v).zip(&self.z) {
            (*q, *v) = (z[s].re, z[s].im);
        }
    }
}
