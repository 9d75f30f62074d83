//! Exact crossings by Gauss quadrature on the smooth intervals between crossings and drive edges.

use crate::excitation::Side;
use crate::model::structure::couplings::Couplings;
use crate::model::structure::slopes::Slopes;
use crate::periodic::balance::crossings::stencil::Phasors;
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::integration::integration_trait::{Check, Integration, Motion};
use crate::periodic::balance::integration::jumps::BothSides;
use crate::periodic::balance::quadrature::panel_points::{MAX_EDGES, drive_edges, quadrature};
use crate::periodic::balance::quadrature::resolution::DriveSampler;
use crate::periodic::balance::series::grid::Grid;
use crate::periodic::balance::series::spectra::Spectra;
use crate::periodic::balance::series::transform::write;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Integration by panels: their ends and their number, and scratch.
pub(crate) struct Panels {
    /// Drive edges inside the span, and ends of the panels of pulses.
    edges: Vec<f64>,
    /// Ends of the panels of pulses, over the span.
    pulses: Vec<f64>,
    /// The order that the panels resolve. It determines their width.
    order: usize,
    breaks: Vec<f64>,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    u: Vec<f64>,
    phasors: Vec<Complex64>,
    accelerations: Vec<Vec<Complex64>>,
    slopes: Vec<Vec<Complex64>>,
    sides: BothSides,
}

impl Panels {
    /// Panels as narrow as the kept orders and the drives require, divided by `finer`. `pulses`: further ends
    /// of panels.
    pub(crate) fn new(
        grid: &Grid<'_>,
        varying: usize,
        drives: &mut DriveSampler<'_>,
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
            pulses: pulses.iter().map(|t| t / grid.span()).collect(),
            breaks,
            q: vec![0.0; n],
            v: vec![0.0; n],
            a: vec![0.0; n],
            u: vec![0.0; grid.model.drives()],
            phasors: vec![Complex64::ZERO; 2 * highest + 1],
            accelerations: vec![vec![Complex64::ZERO; grid.harmonics().orders().len()]; n],
            slopes: vec![vec![Complex64::ZERO; 2 * highest + 1]; varying],
            sides: BothSides::new(n, grid.model.contacts()),
        }
    }

    /// Integrates the accelerations, and the periodic slopes if `slopes` is given.
    fn integrate(&mut self, motion: &Motion<'_, '_>, mut slopes: Option<&mut Slopes<'_>>, out: &mut Spectra) {
        let Motion { grid, crossings, couplings, coefficients, speeds } = motion;
        let (harmonics, span, step) = (grid.harmonics(), grid.span(), grid.step());
        let mut breaks = std::mem::take(&mut self.breaks);
        breaks.clear();
        breaks.extend(self.edges.iter().copied().chain(crossings.list().iter().map(|e| e.time(step))));
        breaks.extend([0.0, span]);
        breaks.sort_unstable_by(f64::total_cmp);
        self.accelerations.iter_mut().chain(&mut self.slopes).for_each(|sums| sums.fill(Complex64::ZERO));
        quadrature(&breaks, span, self.order, |t, share| {
            self.phasors.iter_mut().zip(Phasors::new(TAU * (t / span))).for_each(|(p, z)| *p = z);
            self.move_to(grid, coefficients, speeds);
            grid.model.drive(t, Side::After, &mut self.u);
            grid.model.accel(&self.u, &self.q, &self.v, &mut self.a);
            for (sums, a) in self.accelerations.iter_mut().zip(&self.a) {
                for (sum, &order) in sums.iter_mut().zip(harmonics.orders()) {
                    *sum += self.phasors[order] * (share * a);
                }
            }
            if let Some(slopes) = &mut slopes {
                slopes.at(None, &self.u, &self.q, &self.v);
                for (sum, &(i, j, velocity)) in self.slopes.iter_mut().zip(&couplings.varying) {
                    let d =
                        share * if velocity { slopes.jacobian.v[(i, j)] } else { slopes.jacobian.q[(i, j)] };
                    sum.iter_mut().zip(&self.phasors).for_each(|(sum, z)| *sum += z * d);
                }
            }
        });
        self.breaks = breaks;
        for (part, values) in out.accelerations.iter_mut().zip(&self.accelerations) {
            for ((i, &order), value) in harmonics.orders().iter().enumerate().zip(values) {
                write(&mut part[harmonics.place(i)..], order, *value);
            }
        }
        if slopes.is_some() {
            for (table, values) in out.slopes.iter_mut().zip(&self.slopes) {
                values.iter().enumerate().for_each(|(k, d)| table.set(k, *d));
            }
        }
    }

    /// Computes coordinates and velocities at the instant of the phasors.
    fn move_to(&mut self, grid: &Grid<'_>, coefficients: &[f64], speeds: &[f64]) {
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
            (self.q[j], self.v[j]) = (q, v * grid.omega() + speeds[j]);
        }
    }
}

impl Integration for Panels {
    fn integrals(&self, _: usize) -> Integrals {
        Integrals::Panels
    }
    fn check(&self) -> Check {
        Check::Finer
    }
    fn adapt<'m>(&mut self, grid: &Grid<'m>, _: &Couplings, _: &mut Slopes<'m>) -> bool {
        self.edges = drive_edges(grid.model, grid.span());
        self.edges.extend(self.pulses.iter().map(|share| share * grid.span()));
        self.edges.len() <= MAX_EDGES
    }
    fn accelerations(&mut self, motion: &mut Motion<'_, '_>, out: &mut Spectra) {
        self.integrate(motion, None, out);
    }
    fn slopes(&mut self, motion: &mut Motion<'_, '_>, slopes: &mut Slopes<'_>, out: &mut Spectra) {
        self.integrate(motion, Some(slopes), out);
        self.sides.jumps(motion.grid, motion.crossings, out);
    }
}
