//! Exact switching by Gauss quadrature on the smooth stretches between switches and jumps of the drives.

use crate::excitation::side::Side;
use crate::model::equations::Periodic;
use crate::model::slopes::Slopes;
use crate::periodic::balance::quadrature::gauss::{drive_edges, quadrature};
use crate::periodic::balance::quadrature::resolution::Drives;
use crate::periodic::balance::series::couplings::Couplings;
use crate::periodic::balance::series::grid::Grid;
use crate::periodic::balance::series::spectra::Spectra;
use crate::periodic::balance::series::transform::write;
use crate::periodic::balance::switching::instants::Switching;
use crate::periodic::balance::switching::stencil::Phasors;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Scratch of a quadrature.
pub(crate) struct Panels {
    /// Jumps of the drives inside the span.
    edges: Vec<f64>,
    /// The order that panels resolve.
    order: usize,
    breaks: Vec<f64>,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    u: Vec<f64>,
    phasors: Vec<Complex64>,
    force: Vec<Vec<Complex64>>,
    slopes: Vec<Vec<Complex64>>,
}

impl Panels {
    /// Panels of the width that the kept orders and the drives ask for, or this many times finer; those of pulses end where these say.
    pub(crate) fn new<M: Periodic + ?Sized>(
        grid: &Grid<'_, M>,
        varying: usize,
        drives: &mut Drives<'_, M>,
        finer: usize,
        pulses: &[f64],
    ) -> Self {
        let (n, highest) = (grid.dof(), grid.harmonics().highest());
        let mut edges = drive_edges(grid.model, grid.span());
        edges.extend(pulses);
        let mut breaks = edges.clone();
        breaks.extend([0.0, grid.span()]);
        breaks.sort_by(f64::total_cmp);
        Panels {
            order: finer * drives.panel_order(&breaks, grid.span(), highest.max(8)),
            edges,
            breaks,
            q: vec![0.0; n],
            v: vec![0.0; n],
            a: vec![0.0; n],
            u: vec![0.0; grid.model.drives()],
            phasors: vec![Complex64::ZERO; 2 * highest + 1],
            force: vec![vec![Complex64::ZERO; grid.harmonics().orders().len()]; n],
            slopes: vec![vec![Complex64::ZERO; 2 * highest + 1]; varying],
        }
    }

    /// Forces, and slopes if asked for.
    pub(crate) fn evaluate<M: Periodic + ?Sized>(
        &mut self,
        grid: &Grid<'_, M>,
        switching: &Switching,
        coefficients: &[f64],
        wanted: Option<(&mut Slopes<'_, M>, &Couplings)>,
        out: &mut Spectra,
    ) {
        let (harmonics, span, step) = (grid.harmonics(), grid.span(), grid.step());
        let mut breaks = std::mem::take(&mut self.breaks);
        breaks.clear();
        breaks.extend(self.edges.iter().copied().chain(switching.events().iter().map(|e| e.time(step))));
        breaks.extend([0.0, span]);
        breaks.sort_unstable_by(f64::total_cmp);
        self.force.iter_mut().chain(&mut self.slopes).for_each(|f| f.fill(Complex64::ZERO));
        let mut wanted = wanted;
        quadrature(&breaks, span, self.order, |t, share| {
            self.phasors.iter_mut().zip(Phasors::new(TAU * (t / span))).for_each(|(p, z)| *p = z);
            self.move_to(grid, coefficients);
            grid.model.drive(t, Side::After, &mut self.u);
            grid.model.accel(&self.u, &self.q, &self.v, &mut self.a);
            for (force, a) in self.force.iter_mut().zip(&self.a) {
                for (f, &order) in force.iter_mut().zip(harmonics.orders()) {
                    *f += self.phasors[order] * (share * a);
                }
            }
            if let Some((slopes, couplings)) = &mut wanted {
                slopes.at(None, &self.u, &self.q, &self.v);
                for (sum, &(i, j, velocity)) in self.slopes.iter_mut().zip(&couplings.varying) {
                    let d =
                        share * if velocity { slopes.jacobian.v[(i, j)] } else { slopes.jacobian.q[(i, j)] };
                    sum.iter_mut().zip(&self.phasors).for_each(|(sum, z)| *sum += z * d);
                }
            }
        });
        self.breaks = breaks;
        for (force, values) in out.force.iter_mut().zip(&self.force) {
            for ((i, &order), value) in harmonics.orders().iter().enumerate().zip(values) {
                write(&mut force[harmonics.place(i)..], order, *value);
            }
        }
        if wanted.is_some() {
            for (table, values) in out.slopes.iter_mut().zip(&self.slopes) {
                values.iter().enumerate().for_each(|(k, d)| table.set(k, *d));
            }
        }
    }

    /// Coordinates and velocities at the instant of the phasors.
    fn move_to<M: Periodic + ?Sized>(&mut self, grid: &Grid<'_, M>, coefficients: &[f64]) {
        let harmonics = grid.harmonics();
        for (j, part) in coefficients.chunks_exact(harmonics.unknowns()).enumerate() {
            let (mut q, mut v) = (0.0, 0.0);
            for (i, &order) in harmonics.orders().iter().enumerate() {
                let at = harmonics.place(i);
                if order == 0 {
                    q += part[at];
                } else {
                    let (cos, sin) = (self.phasors[order].re, -self.phasors[order].im);
                    q += part[at] * cos + part[at + 1] * sin;
                    v += order as f64 * (part[at + 1] * cos - part[at] * sin);
                }
            }
            (self.q[j], self.v[j]) = (q, v * grid.omega());
        }
    }
}
