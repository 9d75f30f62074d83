//! Exact switching on uniform samples: the rectangle rule corrected around every kink.
//!
//! Across a switch at t_s an acceleration is f + Δ H(t - t_s) with Δ smooth, since both pieces go on past their edge. The sum over samples
//! errs by a functional of Δ e^{-ikωt} around t_s alone, which weights on sixteen samples give to rounding for every order at once: the
//! samples are corrected first, one transform does the rest.

use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::excitation::side::Side;
use crate::model::equations::Periodic;
use crate::model::slopes::{Slopes, accelerate};
use crate::periodic::balance::series::couplings::Couplings;
use crate::periodic::balance::series::grid::Grid;
use crate::periodic::balance::series::spectra::{Jump, Samples, Spectra};
use crate::periodic::balance::switching::instants::{Event, Switching};
use crate::periodic::balance::switching::stencil::{NODES, Stencil};
use crate::roots::norms::largest;
use std::f64::consts::TAU;

/// Scratch for evaluations on both sides of a switch.
pub(crate) struct Kinks {
    pieces: [Vec<Piece>; 2],
    q: Vec<f64>,
    v: Vec<f64>,
    a: [Vec<f64>; 2],
    u: Vec<f64>,
    contacts: Vec<Contact>,
}

impl Kinks {
    pub(crate) fn new(dof: usize, contacts: usize) -> Self {
        // Without contacts there is no kink, and nothing to hold.
        let dof = if contacts > 0 { dof } else { 0 };
        Kinks {
            pieces: [vec![Piece::Gap; contacts], vec![Piece::Gap; contacts]],
            q: vec![0.0; dof],
            v: vec![0.0; dof],
            a: [vec![0.0; dof], vec![0.0; dof]],
            u: Vec::new(),
            contacts: vec![Contact::default(); contacts],
        }
    }

    /// The pieces before and after a switch, other contacts as they are at that sample.
    fn hold(&mut self, event: &Event, switching: &Switching) {
        for side in &mut self.pieces {
            for (c, piece) in side.iter_mut().enumerate() {
                *piece = switching.piece(c, event.cell);
            }
        }
        self.pieces[0][event.contact] = event.from;
        self.pieces[1][event.contact] = event.to;
    }

    /// Corrects sampled forces.
    pub(crate) fn correct_forces<M: Periodic + ?Sized>(
        &mut self,
        grid: &Grid<'_, M>,
        stencil: &Stencil,
        switching: &Switching,
        samples: &mut Samples,
    ) {
        for event in switching.events() {
            self.hold(event, switching);
            let weights = stencil.weights(event.phi);
            for (i, w) in weights.iter().enumerate().take(NODES) {
                let s = Stencil::index(event.cell, i, grid.samples());
                grid.state(s, &mut self.q, &mut self.v);
                for side in 0..2 {
                    accelerate(
                        grid.model,
                        Some(&self.pieces[side]),
                        grid.drives(s),
                        &self.q,
                        &self.v,
                        &mut self.a[side],
                    );
                }
                for (force, (before, after)) in samples.force.iter_mut().zip(self.a[0].iter().zip(&self.a[1]))
                {
                    force[s] += w * (after - before);
                }
            }
        }
    }

    /// Corrects sampled slopes.
    pub(crate) fn correct_slopes<M: Periodic + ?Sized>(
        &mut self,
        grid: &Grid<'_, M>,
        stencil: &Stencil,
        switching: &Switching,
        slopes: &mut Slopes<'_, M>,
        couplings: &Couplings,
        samples: &mut Samples,
    ) {
        for event in switching.events() {
            self.hold(event, switching);
            let weights = stencil.weights(event.phi);
            for (i, w) in weights.iter().enumerate() {
                let s = Stencil::index(event.cell, i, grid.samples());
                grid.state(s, &mut self.q, &mut self.v);
                for (side, sign) in [(0, -w), (1, *w)] {
                    slopes.at(Some(&self.pieces[side]), grid.drives(s), &self.q, &self.v);
                    for (values, &(i, j, velocity)) in samples.slopes.iter_mut().zip(&couplings.varying) {
                        values[s] += sign
                            * if velocity { slopes.jacobian.v[(i, j)] } else { slopes.jacobian.q[(i, j)] };
                    }
                }
            }
        }
    }

    /// Jumps of the acceleration at switches, for damping that acts only in contact.
    pub(crate) fn jumps<M: Periodic + ?Sized>(
        &mut self,
        grid: &Grid<'_, M>,
        stencil: &Stencil,
        switching: &Switching,
        out: &mut Spectra,
    ) {
        out.jumps.clear();
        let (m, n) = (grid.samples(), grid.dof());
        self.u.resize(grid.model.drives(), 0.0);
        for event in switching.events() {
            self.hold(event, switching);
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
            let most = self.a.iter().flatten().fold(0.0, |m: f64, a| m.max(a.abs()));
            let change = |a: &[Vec<f64>; 2], i: usize| a[0][i] - a[1][i];
            if (0..n).all(|i| change(&self.a, i).abs() <= 1e-9 * most) {
                continue;
            }
            // Deflections are linear in the coordinates.
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
