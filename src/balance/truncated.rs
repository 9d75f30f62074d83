//! The contact force truncated to the kept orders before it meets the stiffness, as the second paper does.

use super::Harmonics;
use super::assembly::Layout;
use super::grid::Grid;
use super::orbit::{spread, write};
use super::spectra::pack;
use super::table::Table;
use super::transform::unpack;
use crate::model::{AsIs, Generic, Law, Periodic};
use crate::nonlinearity::Nonlinearity;
use crate::root::Matrix;
use crate::scalar::{Dual, Scalar};
use nalgebra::DMatrix;
use num_complex::Complex64;
use std::cell::Cell;

/// What a balance with truncated forces asks of a generic model; a trait so that other models need not be generic.
pub(super) trait Truncated<M: ?Sized> {
    /// Samples of the acceleration with truncated forces; for a Jacobian to come, the slopes as well.
    fn look(&mut self, grid: &mut Grid<'_, M>, slopes_too: bool, force: &mut [Vec<f64>]);
    /// Adds the slopes to a dense Jacobian.
    fn add_jacobian(&self, layout: &Layout, out: &mut Matrix);
}

/// f_c, and what depends on what, of every contact.
pub(super) struct Forces {
    /// Truncated forces per contact x M.
    forces: Vec<Vec<f64>>,
    /// ∂a_i/∂q_j and ∂a_i/∂v_j at given forces: i, j, half.
    direct: Vec<Table>,
    /// ∂a_i/∂f_c.
    levers: Vec<Table>,
    /// ∂f_c/∂q_j and ∂f_c/∂v_j: c, j, half.
    slopes: Vec<Table>,
    contacts: usize,
    dof: usize,
    /// One list of samples for each table, in the order direct, levers, slopes.
    samples: Vec<Vec<f64>>,
    buffer: Vec<Complex64>,
}

impl Forces {
    pub(super) fn new(dof: usize, contacts: usize, harmonics: &Harmonics, samples: usize) -> Self {
        let tables = |count: usize| (0..count).map(|_| Table::new(harmonics.highest())).collect::<Vec<_>>();
        Forces {
            forces: vec![vec![0.0; samples]; contacts],
            direct: tables(2 * dof * dof),
            levers: tables(dof * contacts),
            slopes: tables(2 * contacts * dof),
            contacts,
            dof,
            samples: vec![vec![0.0; samples]; 2 * dof * dof + dof * contacts + 2 * contacts * dof],
            buffer: vec![Complex64::ZERO; samples],
        }
    }

    /// To the kept orders and back.
    fn truncate<M: Periodic + ?Sized>(&mut self, grid: &mut Grid<'_, M>) {
        let harmonics = grid.harmonics().clone();
        let mut part = vec![0.0; harmonics.unknowns()];
        for force in &mut self.forces {
            self.buffer.iter_mut().zip(&*force).for_each(|(z, f)| *z = (*f).into());
            grid.transform.analyse(&mut self.buffer);
            for (i, &order) in harmonics.orders().iter().enumerate() {
                write(&mut part[harmonics.place(i)..], order, unpack(&self.buffer, order).0);
            }
            spread(&part, &harmonics, 0.0, &mut self.buffer);
            grid.transform.synthesise(&mut self.buffer);
            force.iter_mut().zip(&self.buffer).for_each(|(f, z)| *f = z.re);
        }
    }

    fn transform<M: Periodic + ?Sized>(&mut self, grid: &mut Grid<'_, M>) {
        let mut tables = self.direct.iter_mut().chain(&mut self.levers).chain(&mut self.slopes);
        for pair in self.samples.chunks(2) {
            pack(&mut self.buffer, &pair[0], pair.get(1).map(|y| &y[..]));
            grid.transform.analyse(&mut self.buffer);
            let (first, second) = (tables.next(), pair.get(1).and_then(|_| tables.next()));
            for (table, which) in first.into_iter().map(|t| (t, 0)).chain(second.into_iter().map(|t| (t, 1))) {
                for k in 0..=table.reach() {
                    let (x, y) = unpack(&self.buffer, k);
                    table.set(k, if which == 0 { x } else { y });
                }
            }
        }
    }
}

impl<M: Generic + Periodic> Truncated<M> for Forces {
    fn look(&mut self, grid: &mut Grid<'_, M>, slopes_too: bool, force: &mut [Vec<f64>]) {
        let (n, c) = (self.dof, self.contacts);
        let (mut q, mut v, mut a) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let seen = vec![Cell::new(0.0); c];
        for s in 0..grid.samples() {
            grid.state(s, &mut q, &mut v);
            grid.model.accel_on(&Recorded(&seen), grid.drives(s), &q, &v, &mut a);
            self.forces.iter_mut().zip(&seen).for_each(|(f, seen)| f[s] = seen.get());
        }
        self.truncate(grid);
        let mut given = vec![0.0; c];
        for s in 0..grid.samples() {
            grid.state(s, &mut q, &mut v);
            given.iter_mut().zip(&self.forces).for_each(|(g, f)| *g = f[s]);
            grid.model.accel_on(&Given(&given), grid.drives(s), &q, &v, &mut a);
            force.iter_mut().zip(&a).for_each(|(f, a)| f[s] = *a);
        }
        if !slopes_too {
            return;
        }
        let mut a = vec![Dual::from(0.0); n];
        let (mut u, mut y, mut f) = (vec![Dual::from(0.0); grid.model.drives()], vec![Dual::from(0.0); 2 * n], vec![Dual::from(0.0); c]);
        let seen = vec![Cell::new(Dual::from(0.0)); c];
        let (levers, slopes) = (2 * n * n, 2 * n * n + n * c);
        let set = |to: &mut [Dual], from: &[f64]| to.iter_mut().zip(from).for_each(|(d, x)| *d = Dual::from(*x));
        for s in 0..grid.samples() {
            grid.state(s, &mut q, &mut v);
            set(&mut u, grid.drives(s));
            set(&mut y[..n], &q);
            set(&mut y[n..], &v);
            f.iter_mut().zip(&self.forces).for_each(|(f, samples)| *f = Dual::from(samples[s]));
            for column in 0..2 * n {
                y[column].slope = 1.0;
                grid.model.accel_on(&Given(&f), &u, &y[..n], &y[n..], &mut a);
                for (i, a) in a.iter().enumerate() {
                    self.samples[i * 2 * n + column][s] = a.slope;
                }
                grid.model.accel_on(&Recorded(&seen), &u, &y[..n], &y[n..], &mut a);
                for (contact, seen) in seen.iter().enumerate() {
                    self.samples[slopes + contact * 2 * n + column][s] = seen.get().slope;
                }
                y[column].slope = 0.0;
            }
            for contact in 0..c {
                f[contact].slope = 1.0;
                grid.model.accel_on(&Given(&f), &u, &y[..n], &y[n..], &mut a);
                f[contact].slope = 0.0;
                for (i, a) in a.iter().enumerate() {
                    self.samples[levers + i * c + contact][s] = a.slope;
                }
            }
        }
        self.transform(grid);
    }

    fn add_jacobian(&self, layout: &Layout, out: &mut Matrix) {
        let (n, harmonics) = (self.dof, &layout.harmonics);
        let width = harmonics.unknowns();
        let levers: Vec<DMatrix<f64>> = self.levers.iter().map(|table| operator(table, harmonics)).collect();
        for j in 0..n {
            for half in 0..2 {
                let slopes: Vec<DMatrix<f64>> =
                    (0..self.contacts).map(|c| operator(&self.slopes[c * 2 * n + half * n + j], harmonics)).collect();
                for i in 0..n {
                    let mut block = operator(&self.direct[i * 2 * n + half * n + j], harmonics);
                    for (c, slope) in slopes.iter().enumerate() {
                        block += &levers[i * self.contacts + c] * slope;
                    }
                    let scale = -layout.scales[j] / layout.scales[i];
                    for (index, &order) in harmonics.orders().iter().enumerate() {
                        let (at, rate) = (harmonics.place(index), order as f64 * layout.omega);
                        for parity in 0..if order == 0 { 1 } else { 2 } {
                            // Of a velocity: c cos turns to -kω c sin, s sin to +kω s cos.
                            let (column, share) = match (half, parity) {
                                (0, _) => (at + parity, 1.0),
                                _ if order == 0 => continue,
                                (_, 0) => (at + 1, -rate),
                                _ => (at, rate),
                            };
                            let target = &mut out.column_mut(j * width + at + parity)[i * width..(i + 1) * width];
                            target.iter_mut().zip(&block.column(column)).for_each(|(t, b)| *t += scale * share * b);
                        }
                    }
                }
            }
        }
    }
}

/// What a periodic factor does to kept harmonics.
fn operator(table: &Table, harmonics: &Harmonics) -> DMatrix<f64> {
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

/// The laws as they are, their forces written down.
struct Recorded<'a, S>(&'a [Cell<S>]);

impl<S: Scalar> Law<S> for Recorded<'_, S> {
    fn force<N: Nonlinearity>(&self, i: usize, nonlinearity: &N, x: S, rate: S, lower: S, upper: S) -> S {
        let force = nonlinearity.force(x, rate, lower, upper);
        self.0[i].set(force);
        force
    }
    fn touch(&self, i: usize, x: S, lower: S, upper: S) -> S {
        AsIs.touch(i, x, lower, upper)
    }
}

/// Forces as given.
struct Given<'a, S>(&'a [S]);

impl<S: Scalar> Law<S> for Given<'_, S> {
    fn force<N: Nonlinearity>(&self, i: usize, _: &N, _: S, _: S, _: S, _: S) -> S {
        self.0[i]
    }
    fn touch(&self, i: usize, x: S, lower: S, upper: S) -> S {
        AsIs.touch(i, x, lower, upper)
    }
}
