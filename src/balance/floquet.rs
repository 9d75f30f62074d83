//! Floquet multipliers straight from a balance.

use super::Orbit;
use super::couplings::Slopes;
use super::orbit::samples_for;
use super::panels::drive_edges;
use super::size::sizes;
use super::stencil::Stencil;
use super::switching::Switching;
use super::{grid::Grid, kinks::Kinks, spectra::Spectra};
use crate::model::{Contact, Periodic};
use crate::orbit::{Multipliers, rigid_modes};
use crate::piece::{Piece, Side};
use crate::root::{Factors, Matrix};
use nalgebra::{DMatrix, Matrix4, Matrix4x2};
use std::f64::consts::TAU;

/// Radians of the fastest local oscillation in one step: over ten of them multipliers err by some 1e-9.
const STEP: f64 = 0.6;

impl Orbit {
    /// Floquet multipliers of the equation linearised along this series, Y' = [0 1; ∂a/∂q ∂a/∂v] Y over one span, by Gauss collocation of
    /// order 8 on the smooth stretches between switches (Hairer & Wanner II, Sec. IV.5).
    ///
    /// This is the cheap way. Its error estimate is the change when the top quarter of the orders is dropped and steps are doubled; with
    /// rattle a truncated series switches at slightly wrong instants, and the multipliers of [`polish`](Orbit::polish) are the reference.
    /// Forces that jump at a switch leave them undecided. `None` if the model gives no finite slopes, or has another number of coordinates.
    pub fn multipliers<M: Periodic + ?Sized>(&self, model: &M) -> Option<Multipliers> {
        self.multipliers_any(&model)
    }

    fn multipliers_any(&self, model: &dyn Periodic) -> Option<Multipliers> {
        let n = self.dof();
        if model.dof() != n {
            return None;
        }
        let rigid = if n == 1 { Vec::new() } else { rigid_modes(model, model.period()) };
        let basis = DMatrix::from_fn(2 * n, 2 * rigid.len(), |i, k| {
            let (mode, half) = (&rigid[k / 2], k % 2);
            if i / n == half { mode[i % n] } else { 0.0 }
        });
        let highest = self.harmonics().highest();
        let fewer = self.below(highest - highest.div_ceil(4));
        let multipliers = Multipliers::without(&self.monodromy(model, STEP)?, &basis, 0.0)?;
        let rough = fewer.monodromy(model, 2.0 * STEP).and_then(|m| Multipliers::without(&m, &basis, 0.0));
        let error = rough.map_or(f64::INFINITY, |rough| multipliers.distance(&rough));
        Some(multipliers.with_error(if self.jumps(model) { f64::INFINITY } else { error }))
    }

    /// The motion on a grid, and its switches.
    fn switching<'m, M: Periodic + ?Sized>(&self, model: &'m M) -> (Grid<'m, M>, Switching) {
        let mut grid = Grid::new(model, self.harmonics(), samples_for(self.harmonics().highest()));
        grid.set(self.all_coefficients());
        let mut switching = Switching::new(model.contacts(), grid.samples());
        switching.locate(&mut grid, Stencil::get());
        (grid, switching)
    }

    /// Whether a force jumps at a switch: then the flow does too, and a series cannot tell how.
    fn jumps<M: Periodic + ?Sized>(&self, model: &M) -> bool {
        if model.contacts() == 0 {
            return false;
        }
        let (grid, switching) = self.switching(model);
        let mut spectra = Spectra::new(self.dof(), 0, self.harmonics());
        Kinks::new(self.dof(), model.contacts()).jumps(&grid, Stencil::get(), &switching, &mut spectra);
        !spectra.jumps.is_empty()
    }

    /// ∂x(span)/∂x(0) along the series.
    fn monodromy<M: Periodic + ?Sized>(&self, model: &M, step: f64) -> Option<DMatrix<f64>> {
        let (n, span) = (self.dof(), self.span());
        let mut breaks = drive_edges(model, span);
        if model.contacts() > 0 {
            let (grid, switching) = self.switching(model);
            breaks.extend(switching.events().iter().map(|e| e.time(grid.step())));
        }
        breaks.extend([0.0, span]);
        breaks.sort_by(f64::total_cmp);
        let mut flow = Flow::new(self, model);
        for stretch in breaks.windows(2) {
            flow.advance(stretch[0], stretch[1], step)?;
        }
        Some(DMatrix::from_column_slice(2 * n, 2 * n, &flow.y))
    }
}

/// Stages of the collocation.
const STAGES: usize = 4;
/// Nodes and weights on 0 .. 1: Gauss, four points.   Abramowitz & Stegun, Table 25.4.
const NODES: [f64; STAGES] = [0.069_431_844_202_973_71, 0.330_009_478_207_571_87, 0.669_990_521_792_428_1, 0.930_568_155_797_026_3];
const WEIGHTS: [f64; STAGES] = [0.173_927_422_568_726_93, 0.326_072_577_431_273_07, 0.326_072_577_431_273_07, 0.173_927_422_568_726_93];

/// a_ij = ∫_0^{c_i} of the j-th Lagrange polynomial of the nodes.
fn coefficients() -> [[f64; STAGES]; STAGES] {
    let mut a = [[0.0; STAGES]; STAGES];
    for j in 0..STAGES {
        let mut p = [1.0, 0.0, 0.0, 0.0];
        for (degree, k) in (0..STAGES).filter(|&k| k != j).enumerate() {
            let scale = 1.0 / (NODES[j] - NODES[k]);
            for m in (0..=degree + 1).rev() {
                p[m] = scale * (if m > 0 { p[m - 1] } else { 0.0 } - NODES[k] * p[m]);
            }
        }
        for (i, c) in NODES.iter().enumerate() {
            a[i][j] = c * (p[0] + c * (p[1] / 2.0 + c * (p[2] / 3.0 + c * p[3] / 4.0)));
        }
    }
    a
}

/// Y carried along a series.
struct Flow<'m, M: ?Sized> {
    orbit: &'m Orbit,
    model: &'m M,
    slopes: Slopes<'m, M>,
    /// 2n x 2n by columns.
    y: Vec<f64>,
    /// a, a², and bᵀa.
    a: [[f64; STAGES]; STAGES],
    square: [[f64; STAGES]; STAGES],
    weights: [f64; STAGES],
    q: Vec<f64>,
    v: Vec<f64>,
    u: Vec<f64>,
    contacts: Vec<Contact>,
    pieces: Vec<Piece>,
    system: Matrix,
    right: Vec<f64>,
}

impl<'m, M: Periodic + ?Sized> Flow<'m, M> {
    fn new(orbit: &'m Orbit, model: &'m M) -> Self {
        let n = orbit.dof();
        let mut y = vec![0.0; 4 * n * n];
        (0..2 * n).for_each(|i| y[i * (2 * n + 1)] = 1.0);
        let (a, size) = (coefficients(), sizes(orbit));
        let rates = size.iter().map(|s| s * orbit.frequency() * orbit.harmonics().highest().max(1) as f64).collect();
        let product = |i: usize, j: usize| (0..STAGES).map(|k| a[i][k] * a[k][j]).sum();
        Flow {
            slopes: Slopes::new(model, [size, rates]),
            square: std::array::from_fn(|i| std::array::from_fn(|j| product(i, j))),
            weights: std::array::from_fn(|j| (0..STAGES).map(|i| WEIGHTS[i] * a[i][j]).sum()),
            q: vec![0.0; n],
            v: vec![0.0; n],
            u: vec![0.0; model.drives()],
            contacts: vec![Contact::default(); model.contacts()],
            pieces: vec![Piece::Gap; model.contacts()],
            system: Matrix::dense(STAGES * n),
            right: vec![0.0; STAGES * n * 2 * n],
            orbit,
            model,
            y,
            a,
        }
    }

    /// Over a smooth stretch.
    fn advance(&mut self, start: f64, end: f64, step: f64) -> Option<()> {
        let mut t = start;
        if end <= start {
            return Some(());
        }
        self.orbit.motion(0.5 * (start + end), &mut self.q, &mut self.v);
        self.model.drive(0.5 * (start + end), Side::After, &mut self.u);
        self.model.contact(&self.u, &self.q, &self.v, &mut self.contacts);
        self.pieces.iter_mut().zip(&self.contacts).for_each(|(p, c)| *p = c.piece());
        let mut fastest = self.read(0.5 * (start + end));
        while t < end {
            if !fastest.is_finite() {
                return None;
            }
            // Whole steps of equal length to the end, as long as the frequency allows here; the slowest allowed is one order.
            let longest = step / fastest.max(TAU / self.orbit.span());
            let h = (end - t) / ((end - t) / longest).ceil().max(1.0);
            fastest = self.step(t, h)?;
            t = if (end - t) <= 1.5 * h { end } else { t + h };
        }
        Some(())
    }

    /// Slopes at an instant; √ of their largest row sum.
    fn read(&mut self, t: f64) -> f64 {
        self.orbit.motion(t, &mut self.q, &mut self.v);
        self.model.drive(t, Side::After, &mut self.u);
        let held = (!self.pieces.is_empty()).then_some(&self.pieces[..]);
        self.slopes.at(held, &self.u, &self.q, &self.v);
        let (of_q, of_v) = (&self.slopes.jacobian.q, &self.slopes.jacobian.v);
        let n = self.q.len();
        let sum = |i: usize, m: &DMatrix<f64>| (0..n).map(|j| m[(i, j)].abs()).sum::<f64>();
        (0..n).fold(0.0, |m: f64, i| m.max(sum(i, of_q).sqrt()).max(sum(i, of_v)))
    }

    /// One step: the accelerations k of all stages solve k_i = A_i (q + c_i h v + h² Σ a²_ij k_j) + B_i (v + h Σ a_ij k_j).
    fn step(&mut self, t: f64, h: f64) -> Option<f64> {
        let (n, rows) = (self.orbit.dof(), STAGES * self.orbit.dof());
        let mut fastest = 0.0f64;
        for (stage, c) in NODES.iter().enumerate() {
            fastest = fastest.max(self.read(t + c * h));
            let (of_q, of_v) = (&self.slopes.jacobian.q, &self.slopes.jacobian.v);
            for other in 0..STAGES {
                let (by_q, by_v) = (-h * h * self.square[stage][other], -h * self.a[stage][other]);
                for j in 0..n {
                    let column = &mut self.system.column_mut(other * n + j)[stage * n..(stage + 1) * n];
                    for (i, entry) in column.iter_mut().enumerate() {
                        let unit = if stage == other && i == j { 1.0 } else { 0.0 };
                        *entry = unit + by_q * of_q[(i, j)] + by_v * of_v[(i, j)];
                    }
                }
            }
            for (y, right) in self.y.chunks_exact(2 * n).zip(self.right.chunks_exact_mut(rows)) {
                for i in 0..n {
                    let along = |j: usize| of_q[(i, j)] * (y[j] + c * h * y[n + j]) + of_v[(i, j)] * y[n + j];
                    right[stage * n + i] = (0..n).map(along).sum();
                }
            }
        }
        if n == 1 {
            // Fixed sizes need no heap.
            let system = Matrix4::from_fn(|i, j| self.system.column(j)[i]);
            let k = system.try_inverse()? * Matrix4x2::from_column_slice(&self.right);
            self.right.copy_from_slice(k.as_slice());
        } else {
            let factors = Factors::new(&self.system).ok()?;
            self.right.chunks_exact_mut(rows).for_each(|k| factors.solve(k));
        }
        for (y, k) in self.y.chunks_exact_mut(2 * n).zip(self.right.chunks_exact(rows)) {
            for i in 0..n {
                let sum = |weights: &[f64; STAGES]| (0..STAGES).map(|s| weights[s] * k[s * n + i]).sum::<f64>();
                y[i] += h * y[n + i] + h * h * sum(&self.weights);
                y[n + i] += h * sum(&WEIGHTS);
            }
        }
        Some(fastest)
    }
}
