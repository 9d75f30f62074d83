//! Jumps of the accelerations at crossings, for example of damping that acts only in contact.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::Periodic;
use crate::model::structure::slopes::accelerate;
use crate::numeric::norms::largest;
use crate::periodic::balance::crossings::instants::{Crossings, OrbitCrossing};
use crate::periodic::balance::crossings::stencil::Stencil;
use crate::periodic::balance::series::grid::Grid;
use crate::periodic::balance::series::spectra::{Jump, Spectra};
use std::f64::consts::TAU;

/// Scratch for evaluations on the pieces before and after a crossing.
#[derive(Clone)]
pub(crate) struct BothSides {
    /// Pieces before and after the crossing.
    pub(crate) pieces: [Vec<Piece>; 2],
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    /// Accelerations before and after the crossing.
    pub(crate) a: [Vec<f64>; 2],
    u: Vec<f64>,
    contacts: Vec<Contact>,
}

impl BothSides {
    pub(crate) fn new(dof: usize, contacts: usize) -> Self {
        // A model without contacts has no crossings.
        let dof = if contacts > 0 { dof } else { 0 };
        BothSides {
            pieces: [vec![Piece::Gap; contacts], vec![Piece::Gap; contacts]],
            q: vec![0.0; dof],
            v: vec![0.0; dof],
            a: [vec![0.0; dof], vec![0.0; dof]],
            u: Vec::new(),
            contacts: vec![Contact::default(); contacts],
        }
    }

    /// Sets the pieces before and after a crossing. Every other contact stands on its piece at the sample
    /// before the crossing.
    pub(crate) fn stand_on(&mut self, crossing: &OrbitCrossing, crossings: &Crossings) {
        for side in &mut self.pieces {
            for (c, piece) in side.iter_mut().enumerate() {
                *piece = crossings.piece(c, crossing.cell);
            }
        }
        self.pieces[0][crossing.contact] = crossing.from;
        self.pieces[1][crossing.contact] = crossing.to;
    }

    /// Writes the jumps of the accelerations at all crossings. A jump of at most 1e-9 of the largest
    /// acceleration counts as rounding and is left out.
    pub(crate) fn jumps(&mut self, grid: &Grid<'_>, crossings: &Crossings, out: &mut Spectra) {
        let stencil = Stencil::get();
        out.jumps.clear();
        let (m, n) = (grid.samples(), grid.dof());
        self.u.resize(grid.model.drives(), 0.0);
        for crossing in crossings.list() {
            self.stand_on(crossing, crossings);
            for j in 0..n {
                self.q[j] = stencil.polynomial(crossing.cell, m, |s| grid.z[j][s].re).at(crossing.phi).0;
                self.v[j] = stencil.polynomial(crossing.cell, m, |s| grid.z[j][s].im).at(crossing.phi).0;
            }
            grid.model.drive(crossing.time(grid.step()), Side::After, &mut self.u);
            for side in 0..2 {
                accelerate(
                    grid.model,
                    Some(&self.pieces[side]),
                    &self.u,
                    &self.q,
                    &self.v,
                    &mut self.a[side],
                );
            }
            let largest_a = self.a.iter().flatten().fold(0.0, |m: f64, a| m.max(a.abs()));
            let change = |a: &[Vec<f64>; 2], i: usize| a[0][i] - a[1][i];
            if (0..n).all(|i| change(&self.a, i).abs() <= 1e-9 * largest_a) {
                continue;
            }
            // Deflections are linear in the coordinates, so that a difference of any width is exact.
            let here = self.deflection(grid.model, crossing.contact);
            let mut row = vec![0.0; n];
            for (j, slope) in row.iter_mut().enumerate() {
                let own = self.q[j];
                let h = own.abs().max(1e-3 * largest(&self.q)).max(f64::MIN_POSITIVE.sqrt());
                self.q[j] = own + h;
                *slope = (self.deflection(grid.model, crossing.contact) - here) / h;
                self.q[j] = own;
            }
            let slope = crossing.slope * m as f64 / TAU;
            let size = (0..n).map(|i| -change(&self.a, i) / (TAU * slope)).collect();
            out.jumps.push(Jump { phase: TAU * crossing.time(1.0) / m as f64, size, row });
        }
    }

    fn deflection(&mut self, model: &dyn Periodic, contact: usize) -> f64 {
        model.contact(&self.u, &self.q, &self.v, &mut self.contacts);
        self.contacts[contact].deflection
    }
}
