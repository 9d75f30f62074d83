//! Jumps of the accelerations at switches, for example of damping that acts only in contact.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::Periodic;
use crate::model::structure::slopes::accelerate;
use crate::numeric::norms::largest;
use crate::periodic::balance::series::grid::Grid;
use crate::periodic::balance::series::spectra::{Jump, Spectra};
use crate::periodic::balance::switching::instants::{Event, Switching};
use crate::periodic::balance::switching::stencil::Stencil;
use std::f64::consts::TAU;

/// Scratch for evaluations on the pieces before and after a switch.
#[derive(Clone)]
pub(crate) struct BothSides {
    /// Pieces before and after the switch.
    pub(crate) pieces: [Vec<Piece>; 2],
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    /// Accelerations before and after the switch.
    pub(crate) a: [Vec<f64>; 2],
    u: Vec<f64>,
    contacts: Vec<Contact>,
}

impl BothSides {
    pub(crate) fn new(dof: usize, contacts: usize) -> Self {
        // A model without contacts has no switches.
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

    /// Sets the pieces before and after a switch. Every other contact stands on its piece at the sample
    /// before the switch.
    pub(crate) fn stand_on(&mut self, event: &Event, switching: &Switching) {
        for side in &mut self.pieces {
            for (c, piece) in side.iter_mut().enumerate() {
                *piece = switching.piece(c, event.cell);
            }
        }
        self.pieces[0][event.contact] = event.from;
        self.pieces[1][event.contact] = event.to;
    }

    /// Writes the jumps of the accelerations at all switches. A jump of at most 1e-9 of the largest
    /// acceleration counts as rounding and is left out.
    pub(crate) fn jumps<M: Periodic + ?Sized>(
        &mut self,
        grid: &Grid<'_, M>,
        switching: &Switching,
        out: &mut Spectra,
    ) {
        let stencil = Stencil::get();
        out.jumps.clear();
        let (m, n) = (grid.samples(), grid.dof());
        self.u.resize(grid.model.drives(), 0.0);
        for event in switching.events() {
            self.stand_on(event, switching);
            for j in 0..n {
                self.q[j] = stencil.polynomial(event.cell, m, |s| grid.z[j][s].re).at(event.phi).0;
                self.v[j] = stencil.polynomial(event.cell, m, |s| grid.z[j][s].im).at(event.phi).0;
            }
            grid.model.drive(event.time(grid.step()), Side::After, &mut self.u);
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
            let here = self.deflection(grid.model, event.contact);
            let mut row = vec![0.0; n];
            for (j, slope) in row.iter_mut().enumerate() {
                let own = self.q[j];
                let h = own.abs().max(1e-3 * largest(&self.q)).max(f64::MIN_POSITIVE.sqrt());
                self.q[j] = own + h;
                *slope = (self.deflection(grid.model, event.contact) - here) / h;
                self.q[j] = own;
            }
            let slope = event.slope * m as f64 / TAU;
            let size = (0..n).map(|i| -change(&self.a, i) / (TAU * slope)).collect();
            out.jumps.push(Jump { phase: TAU * event.time(1.0) / m as f64, size, row });
        }
    }

    fn deflection<M: Periodic + ?Sized>(&mut self, model: &M, contact: usize) -> f64 {
        model.contact(&self.u, &self.q, &self.v, &mut self.contacts);
        self.contacts[contact].deflection
    }
}
