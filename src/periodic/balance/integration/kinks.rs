//! Exact crossings on uniform samples: the rectangle rule with a correction around every kink.
//!
//! Near a crossing at t_s an acceleration is f + Δ H(t - t_s), with the unit step H. Δ is smooth, because
//! both pieces continue smoothly past their edge. The error of the sum over the samples is a functional of
//! Δ e^{-ikωt} near t_s. The weights of the Euler-Maclaurin formula on sixteen samples around the crossing
//! ([`Stencil::weights`]) give this functional to rounding for every order at once. The samples are corrected
//! first; one transform then gives all orders.

use crate::model::structure::slopes::{Slopes, accelerate};
use crate::periodic::balance::crossings::stencil::{NODES, Stencil};
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::integration::integration_trait::{Check, Integration, Motion};
use crate::periodic::balance::integration::jumps::BothSides;
use crate::periodic::balance::series::spectra::{Samples, Spectra};

/// Integration on uniform samples that are corrected around every crossing.
pub(crate) struct Kinks {
    samples: Samples,
    sides: BothSides,
    stencil: &'static Stencil,
}

impl Kinks {
    pub(crate) fn new(samples: Samples, contacts: usize) -> Self {
        let sides = BothSides::new(samples.accelerations.len(), contacts);
        Kinks { samples, sides, stencil: Stencil::get() }
    }

    /// Adds w_i Δ_i to the sixteen samples around every crossing.
    fn correct_accelerations(&mut self, motion: &Motion<'_, '_>) {
        let (grid, crossings, stencil) = (&*motion.grid, motion.crossings, self.stencil);
        for crossing in crossings.list() {
            self.sides.stand_on(crossing, crossings);
            let weights = stencil.weights(crossing.phi);
            for (i, w) in weights.iter().enumerate().take(NODES) {
                let s = Stencil::index(crossing.cell, i, grid.samples());
                grid.state(s, &mut self.sides.q, &mut self.sides.v);
                for side in 0..2 {
                    accelerate(
                        grid.model,
                        Some(&self.sides.pieces[side]),
                        grid.drives(s),
                        &self.sides.q,
                        &self.sides.v,
                        &mut self.sides.a[side],
                    );
                }
                for (values, (before, after)) in
                    self.samples.accelerations.iter_mut().zip(self.sides.a[0].iter().zip(&self.sides.a[1]))
                {
                    values[s] += w * (after - before);
                }
            }
        }
    }

    /// Adds the same correction to the samples of the periodic slopes.
    fn correct_slopes(&mut self, motion: &Motion<'_, '_>, slopes: &mut Slopes<'_>) {
        let (grid, crossings, stencil) = (&*motion.grid, motion.crossings, self.stencil);
        for crossing in crossings.list() {
            self.sides.stand_on(crossing, crossings);
            let weights = stencil.weights(crossing.phi);
            for (i, w) in weights.iter().enumerate() {
                let s = Stencil::index(crossing.cell, i, grid.samples());
                grid.state(s, &mut self.sides.q, &mut self.sides.v);
                for (side, sign) in [(0, -w), (1, *w)] {
                    slopes.at(Some(&self.sides.pieces[side]), grid.drives(s), &self.sides.q, &self.sides.v);
                    for (values, &(i, j, velocity)) in
                        self.samples.slopes.iter_mut().zip(&motion.couplings.varying)
                    {
                        values[s] += sign
                            * if velocity { slopes.jacobian.v[(i, j)] } else { slopes.jacobian.q[(i, j)] };
                    }
                }
            }
        }
    }
}

impl Integration for Kinks {
    fn integrals(&self, _: usize) -> Integrals {
        Integrals::Kinks
    }
    fn check(&self) -> Check {
        Check::Finer
    }
    fn accelerations(&mut self, motion: &mut Motion<'_, '_>, out: &mut Spectra) {
        self.samples.accelerate(motion.grid, None);
        self.correct_accelerations(motion);
        self.samples.transform_accelerations(motion.grid, out);
    }
    fn slopes(&mut self, motion: &mut Motion<'_, '_>, slopes: &mut Slopes<'_>, out: &mut Spectra) {
        self.samples.differentiate(motion.grid, None, slopes, motion.couplings);
        self.correct_slopes(motion, slopes);
        self.samples.transform_slopes(motion.grid, out);
        self.sides.jumps(motion.grid, motion.crossings, out);
    }
}
