//! Truncated contact forces: the value of each contact law is truncated to the kept orders before it is
//! multiplied by the stiffness.   Source: Liu 2021.
//!
//! Integration on uniform samples, as in Liu 2021, or with exact crossings: every sum over the samples is
//! then corrected around the crossings as in [`kinks`](crate::periodic::balance::integration::kinks).

use crate::contact::Piece;
use crate::dual::Dual;
use crate::model::recording::Laws;
use crate::model::structure::couplings::Couplings;
use crate::model::structure::slopes::Slopes;
use crate::periodic::balance::crossings::instants::Crossings;
use crate::periodic::balance::crossings::stencil::Stencil;
use crate::periodic::balance::integrals::Integrals;
use crate::periodic::balance::integration::integration_trait::{Check, Integration, Motion};
use crate::periodic::balance::integration::jumps::BothSides;
use crate::periodic::balance::series::assembly::JacobianLayout;
use crate::periodic::balance::series::grid::Grid;
use crate::periodic::balance::series::harmonics::Harmonics;
use crate::periodic::balance::series::slope_series::SlopeTable;
use crate::periodic::balance::series::spectra::{Samples, Spectra, pack};
use crate::periodic::balance::series::transform::{spread, unpack, write};
use crate::roots::Matrix;
use nalgebra::DMatrix;
use num_complex::Complex64;

/// Number of directions that one evaluation with dual numbers differentiates along. The directions are the
/// coordinates, the velocities and the truncated values.
const DIRECTIONS: usize = 4;

type DualNumber = Dual<DIRECTIONS>;

/// Integration with the truncated values f_c of the contact laws, and the derivatives for the Jacobian.
pub(crate) struct Truncated {
    accelerations: Samples,
    /// f_c at all samples: contact x sample.
    forces: Vec<Vec<f64>>,
    /// The slopes at their places.
    tables: Vec<SlopeTable>,
    places: Places,
    /// The samples of each table.
    samples: Vec<Vec<f64>>,
    buffer: Vec<Complex64>,
    /// Coefficients of one f_c.
    part: Vec<f64>,
    /// q, v, a and f_c at one sample.
    values: Vec<f64>,
    /// Values of the contact laws in the last evaluation, before truncation.
    seen: Vec<f64>,
    /// Drives, q, v, f_c and a at one sample.
    duals: Vec<DualNumber>,
    seen_duals: Vec<DualNumber>,
    /// Pieces before and after a crossing, for exact crossings; `None`: uniform samples alone.
    sides: Option<BothSides>,
}

/// Places of the slopes of n accelerations and of c contact laws in one list. The variables are the n
/// coordinates, the n velocities and, for the accelerations, the c truncated values.
#[derive(Clone, Copy)]
struct Places {
    dof: usize,
    contacts: usize,
}

impl Places {
    fn count(self) -> usize {
        self.of_law(self.contacts, 0)
    }
    /// ∂a_i/∂x_k at constant truncated values, or ∂a_i/∂f_c for k = 2n + c.
    fn of_acceleration(self, i: usize, k: usize) -> usize {
        let (n, states) = (self.dof, 2 * self.dof);
        if k < states { i * states + k } else { n * states + i * self.contacts + k - states }
    }
    /// The derivative of the law c before truncation with respect to x_k.
    fn of_law(self, c: usize, k: usize) -> usize {
        let (n, states) = (self.dof, 2 * self.dof);
        n * (states + self.contacts) + c * states + k
    }
}

impl Truncated {
    pub(crate) fn new(
        dof: usize,
        drives: usize,
        contacts: usize,
        harmonics: &Harmonics,
        samples: usize,
        exact: bool,
    ) -> Self {
        let (places, zero) = (Places { dof, contacts }, DualNumber::from(0.0));
        Truncated {
            accelerations: Samples::new(dof, 0, samples),
            forces: vec![vec![0.0; samples]; contacts],
            tables: (0..places.count()).map(|_| SlopeTable::new(harmonics.highest())).collect(),
            places,
            samples: vec![vec![0.0; samples]; places.count()],
            buffer: vec![Complex64::ZERO; samples],
            part: vec![0.0; harmonics.unknowns()],
            values: vec![0.0; 3 * dof + contacts],
            seen: vec![0.0; contacts],
            duals: vec![zero; drives + 3 * dof + contacts],
            seen_duals: vec![zero; contacts],
            sides: exact.then(|| BothSides::new(dof, contacts)),
        }
    }

    /// Calls `add(self, laws, sample, None, 1)` for every sample, with the laws of the model. With exact
    /// crossings also `add(self, laws, sample, pieces, weight)` for the samples around every crossing, on the
    /// pieces before and after it.
    fn on_all<F>(&mut self, grid: &Grid<'_>, crossings: &Crossings, add: F)
    where
        F: Fn(&mut Self, &dyn Laws, usize, Option<&[Piece]>, f64),
    {
        let Some(laws) = grid.model.offers().laws else { return };
        (0..grid.samples()).for_each(|s| add(self, laws, s, None, 1.0));
        let Some(mut sides) = self.sides.take() else { return };
        let stencil = Stencil::get();
        for crossing in crossings.list() {
            sides.stand_on(crossing, crossings);
            for (i, w) in stencil.weights(crossing.phi).into_iter().enumerate() {
                let s = Stencil::index(crossing.cell, i, grid.samples());
                add(self, laws, s, Some(&sides.pieces[0]), -w);
                add(self, laws, s, Some(&sides.pieces[1]), w);
            }
        }
        self.sides = Some(sides);
    }

    /// Adds `weight` times the values of the laws to their samples.
    fn add_forces(
        &mut self,
        grid: &Grid<'_>,
        laws: &dyn Laws,
        s: usize,
        pieces: Option<&[Piece]>,
        weight: f64,
    ) {
        let (q, v, a, _) = split(&mut self.values, self.places.dof);
        grid.state(s, q, v);
        laws.accel_by_laws(None, pieces, grid.drives(s), q, v, a, &mut self.seen);
        self.forces.iter_mut().zip(&self.seen).for_each(|(f, seen)| f[s] += weight * seen);
    }

    /// Adds `weight` times the accelerations with the truncated values to their samples.
    fn add_accelerations(
        &mut self,
        grid: &Grid<'_>,
        laws: &dyn Laws,
        s: usize,
        pieces: Option<&[Piece]>,
        weight: f64,
    ) {
        let (q, v, a, given) = split(&mut self.values, self.places.dof);
        grid.state(s, q, v);
        given.iter_mut().zip(&self.forces).for_each(|(g, f)| *g = f[s]);
        laws.accel_by_laws(Some(given), pieces, grid.drives(s), q, v, a, &mut self.seen);
        self.accelerations.accelerations.iter_mut().zip(a).for_each(|(values, a)| values[s] += weight * *a);
    }

    /// Adds `weight` times the derivatives to their samples.
    fn add_slopes(
        &mut self,
        grid: &Grid<'_>,
        laws: &dyn Laws,
        s: usize,
        pieces: Option<&[Piece]>,
        weight: f64,
    ) {
        let (places, drives) = (self.places, grid.model.drives());
        let Places { dof: n, contacts: c } = places;
        let (q, v, _, forces) = split(&mut self.values, n);
        grid.state(s, q, v);
        forces.iter_mut().zip(&self.forces).for_each(|(f, samples)| *f = samples[s]);
        let (u, rest) = self.duals.split_at_mut(drives);
        let (variables, a) = rest.split_at_mut(2 * n + c);
        let set = |to: &mut [DualNumber], from: &[f64]| {
            to.iter_mut().zip(from).for_each(|(to, x)| *to = Dual::from(*x))
        };
        set(u, grid.drives(s));
        set(&mut variables[..n], q);
        set(&mut variables[n..2 * n], v);
        set(&mut variables[2 * n..], forces);
        for first in (0..2 * n + c).step_by(DIRECTIONS) {
            let directions = first..(first + DIRECTIONS).min(2 * n + c);
            directions.clone().for_each(|j| variables[j] = Dual::along(variables[j].value, j - first));
            let (y, forces) = variables.split_at(2 * n);
            laws.slopes_by_laws(forces, pieces, u, &y[..n], &y[n..], a, &mut self.seen_duals);
            for j in directions {
                variables[j] = variables[j].value.into();
                for (i, a) in a.iter().enumerate() {
                    self.samples[places.of_acceleration(i, j)][s] += weight * a.slope[j - first];
                }
                if j < 2 * n {
                    for (law, seen) in self.seen_duals.iter().enumerate() {
                        self.samples[places.of_law(law, j)][s] += weight * seen.slope[j - first];
                    }
                }
            }
        }
    }

    /// Truncates every f_c: computes its coefficients at the kept orders, then its samples from these.
    fn truncate(&mut self, grid: &mut Grid<'_>) {
        for force in &mut self.forces {
            self.buffer.iter_mut().zip(&*force).for_each(|(z, f)| *z = (*f).into());
            grid.transform.analyse(&mut self.buffer);
            let harmonics = grid.harmonics();
            for (i, &order) in harmonics.orders().iter().enumerate() {
                write(&mut self.part[harmonics.place(i)..], order, unpack(&self.buffer, order).0);
            }
            spread(&self.part, harmonics, 0.0, &mut self.buffer);
            grid.transform.synthesise(&mut self.buffer);
            force.iter_mut().zip(&self.buffer).for_each(|(f, z)| *f = z.re);
        }
    }

    /// Computes the tables from the samples of the derivatives, two lists in one transform.
    fn transform(&mut self, grid: &mut Grid<'_>) {
        for (tables, pair) in self.tables.chunks_mut(2).zip(self.samples.chunks(2)) {
            pack(&mut self.buffer, &pair[0], pair.get(1).map(|y| &y[..]));
            grid.transform.analyse(&mut self.buffer);
            for k in 0..=tables[0].reach() {
                let (x, y) = unpack(&self.buffer, k);
                tables.iter_mut().zip([x, y]).for_each(|(table, value)| table.set(k, value));
            }
        }
    }
}

impl Integration for Truncated {
    fn integrals(&self, samples: usize) -> Integrals {
        if self.sides.is_some() { Integrals::Kinks } else { Integrals::Sampled { samples } }
    }
    fn follows_crossings(&self) -> bool {
        self.sides.is_some()
    }
    fn needs_slopes(&self) -> bool {
        false
    }
    fn check(&self) -> Check {
        if self.sides.is_some() { Check::Finer } else { Check::BetweenSamples }
    }
    fn adapt<'m>(&mut self, grid: &Grid<'m>, _: &Couplings, _: &mut Slopes<'m>) -> bool {
        grid.model.offers().laws.is_some()
    }
    fn accelerations(&mut self, motion: &mut Motion<'_, '_>, out: &mut Spectra) {
        let grid = &mut *motion.grid;
        self.forces.iter_mut().for_each(|list| list.fill(0.0));
        self.on_all(grid, motion.crossings, |this, laws, s, pieces, w| {
            this.add_forces(grid, laws, s, pieces, w);
        });
        self.truncate(grid);
        self.accelerations.accelerations.iter_mut().for_each(|list| list.fill(0.0));
        self.on_all(grid, motion.crossings, |this, laws, s, pieces, w| {
            this.add_accelerations(grid, laws, s, pieces, w);
        });
        self.accelerations.transform_accelerations(grid, out);
    }

    fn slopes(&mut self, motion: &mut Motion<'_, '_>, _: &mut Slopes<'_>, _: &mut Spectra) {
        let grid = &mut *motion.grid;
        self.samples.iter_mut().for_each(|list| list.fill(0.0));
        self.on_all(grid, motion.crossings, |this, laws, s, pieces, w| {
            this.add_slopes(grid, laws, s, pieces, w);
        });
        self.transform(grid);
    }

    fn add_jacobian(&self, layout: &JacobianLayout, out: &mut Matrix) {
        let (Places { dof: n, contacts }, harmonics) = (self.places, &layout.harmonics);
        let width = harmonics.unknowns();
        let of_acceleration = |i, k| operator(&self.tables[self.places.of_acceleration(i, k)], harmonics);
        let of_law = |c, k| operator(&self.tables[self.places.of_law(c, k)], harmonics);
        let levers: Vec<Vec<DMatrix<f64>>> =
            (0..n).map(|i| (0..contacts).map(|c| of_acceleration(i, 2 * n + c)).collect()).collect();
        for j in 0..n {
            for half in 0..2 {
                let k = half * n + j;
                let slopes: Vec<DMatrix<f64>> = (0..contacts).map(|c| of_law(c, k)).collect();
                for (i, levers) in levers.iter().enumerate() {
                    let mut block = of_acceleration(i, k);
                    levers.iter().zip(&slopes).for_each(|(lever, slope)| block += lever * slope);
                    let scale = -layout.scales[j] / layout.scales[i];
                    for (index, &order) in harmonics.orders().iter().enumerate() {
                        let (at, rate) = (harmonics.place(index), order as f64 * layout.omega);
                        for parity in 0..if order == 0 { 1 } else { 2 } {
                            // The velocity of c cos kωt is -kω c sin kωt; the velocity of s sin kωt is
                            // kω s cos kωt.
                            let (column, share) = match (half, parity) {
                                (0, _) => (at + parity, 1.0),
                                _ if order == 0 => continue,
                                (_, 0) => (at + 1, -rate),
                                _ => (at, rate),
                            };
                            let target =
                                &mut out.column_mut(j * width + at + parity)[i * width..(i + 1) * width];
                            target
                                .iter_mut()
                                .zip(&block.column(column))
                                .for_each(|(t, b)| *t += scale * share * b);
                        }
                    }
                }
            }
        }
    }
}

/// Matrix of the product with a periodic factor, for coefficients at the kept orders.
fn operator(table: &SlopeTable, harmonics: &Harmonics) -> DMatrix<f64> {
    let width = harmonics.unknowns();
    let mut matrix = DMatrix::zeros(width, width);
    for (index, &order) in harmonics.orders().iter().enumerate() {
        for parity in 0..if order == 0 { 1 } else { 2 } {
            let mut column = matrix.column_mut(harmonics.place(index) + parity);
            table.add(column.as_mut_slice(), harmonics, order, parity == 1, 1.0);
        }
    }
    matrix
}

/// Splits into q, v, a and the rest.
#[inline(always)]
fn split(values: &mut [f64], n: usize) -> (&mut [f64], &mut [f64], &mut [f64], &mut [f64]) {
    let (q, rest) = values.split_at_mut(n);
    let (v, rest) = rest.split_at_mut(n);
    let (a, rest) = rest.split_at_mut(n);
    (q, v, a, rest)
}
