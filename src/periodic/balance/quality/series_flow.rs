//! The linearised flow along a series, by collocation.

use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::Periodic;
use crate::model::structure::resting::rests_on_kink;
use crate::model::structure::slopes::Slopes;
use crate::ode::budget::Meter;
use crate::periodic::balance::amplitudes::sizes;
use crate::periodic::balance::fourier_orbit::{FourierOrbit, turned};
use crate::periodic::balance::quality::collocation::{Collocation, STAGES};
use crate::periodic::multipliers::MultiplierError;
use crate::roots::Matrix;
use crate::roots::factors::Factors;
use nalgebra::DMatrix;
use nalgebra::SMatrix;
use std::f64::consts::TAU;

/// Integration of Y along a series.
pub(crate) struct SeriesFlow<'m> {
    rule: &'static Collocation,
    model: &'m dyn Periodic,
    meter: &'m Meter<'m>,
    slopes: Slopes<'m>,
    /// Y, 2n x 2n, by columns.
    y: Vec<f64>,
    q: Vec<f64>,
    v: Vec<f64>,
    /// Coordinates and velocities at every stage.
    stages: [Vec<[f64; STAGES]>; 2],
    /// Length of the last step, and sin and cos of the phase from its start to every stage.
    ahead: (f64, [[f64; STAGES]; 2]),
    u: Vec<f64>,
    contacts: Vec<Contact>,
    pieces: Vec<Piece>,
    /// ∂a/∂q and ∂a/∂v of every stage, by columns.
    of_q: Vec<f64>,
    of_v: Vec<f64>,
    system: Matrix,
    /// Accelerations k of every stage for every column of Y.
    k: Vec<f64>,
}

impl<'m> SeriesFlow<'m> {
    pub(crate) fn new(orbit: &FourierOrbit, model: &'m dyn Periodic, meter: &'m Meter<'m>) -> Self {
        let n = orbit.dof();
        let size = sizes(orbit);
        let fastest = orbit.frequency() * orbit.harmonics().highest().max(1) as f64;
        let scale = size.iter().copied().chain(size.iter().map(|s| s * fastest)).collect();
        SeriesFlow {
            rule: Collocation::get(),
            slopes: Slopes::new(model, scale, 0.0),
            q: vec![0.0; n],
            v: vec![0.0; n],
            stages: [vec![[0.0; STAGES]; n], vec![[0.0; STAGES]; n]],
            ahead: (0.0, [[0.0; STAGES]; 2]),
            u: vec![0.0; model.drives()],
            contacts: vec![Contact::default(); model.contacts()],
            pieces: vec![Piece::Gap; model.contacts()],
            of_q: vec![0.0; STAGES * n * n],
            of_v: vec![0.0; STAGES * n * n],
            system: Matrix::dense(if n == 1 { 0 } else { STAGES * n }),
            k: vec![0.0; STAGES * n * 2 * n],
            model,
            meter,
            y: vec![0.0; 4 * n * n],
        }
    }

    /// Monodromy matrix ∂x(span)/∂x(0) along a series.
    pub(crate) fn monodromy(
        &mut self,
        orbit: &FourierOrbit,
        breaks: &[f64],
        step: f64,
    ) -> Result<DMatrix<f64>, MultiplierError> {
        let m = 2 * orbit.dof();
        self.ahead.0 = 0.0;
        self.y.fill(0.0);
        (0..m).for_each(|i| self.y[i * (m + 1)] = 1.0);
        for stretch in breaks.windows(2) {
            self.advance(orbit, stretch[0], stretch[1], step)?;
        }
        Ok(DMatrix::from_column_slice(m, m, &self.y))
    }

    /// Integrates Y over a smooth interval.
    ///
    /// Error: a slope is not finite, a step is singular, or the budget is spent.
    fn advance(
        &mut self,
        orbit: &FourierOrbit,
        start: f64,
        end: f64,
        step: f64,
    ) -> Result<(), MultiplierError> {
        let mut t = start;
        if end <= start {
            return Ok(());
        }
        orbit.motion(0.5 * (start + end), &mut self.q, &mut self.v);
        self.model.drive(0.5 * (start + end), Side::After, &mut self.u);
        self.model.contact(&self.u, &self.q, &self.v, &mut self.contacts);
        let (model, slopes) = (self.model, &mut self.slopes);
        if let Some(contact) = rests_on_kink(model, slopes, &self.contacts, &self.u, &self.q, &self.v) {
            return Err(MultiplierError::RestsOnEdge { contact });
        }
        // A gap without width has no inside: at rest in it, a contact is on its upper flank, as in a run.
        self.pieces.iter_mut().zip(&self.contacts).for_each(|(p, c)| {
            *p = if c.lower == c.upper && c.deflection == c.upper { Piece::Upper } else { c.piece() };
        });
        let mut fastest = self.read();
        let mut h = f64::INFINITY;
        while t < end {
            if !fastest.is_finite() {
                return Err(MultiplierError::Slope { t });
            }
            self.meter.spend()?;
            // Equal steps to the end of the interval, at most `step` radians of the highest frequency so far.
            // That frequency counts as at least the base frequency.
            let longest = step / fastest.max(TAU / orbit.period());
            if h > longest {
                h = (end - t) / ((end - t) / longest).ceil().max(1.0);
            }
            fastest = fastest.max(self.step(orbit, t, h).ok_or(MultiplierError::Singular { t })?);
            t = if (end - t) <= 1.5 * h { end } else { t + h };
        }
        if fastest.is_finite() { Ok(()) } else { Err(MultiplierError::Slope { t }) }
    }

    /// Reads the slopes at the current drives and motion. Returns the fastest local frequency: the maximum of
    /// √(Σ_j |∂a_i/∂q_j|) and Σ_j |∂a_i/∂v_j| over the rows i.
    fn read(&mut self) -> f64 {
        let fixed = (!self.pieces.is_empty()).then_some(&self.pieces[..]);
        self.slopes.at(fixed, &self.u, &self.q, &self.v);
        let (of_q, of_v) = (&self.slopes.jacobian.q, &self.slopes.jacobian.v);
        let n = self.q.len();
        let sum = |i: usize, m: &DMatrix<f64>| (0..n).map(|j| m[(i, j)].abs()).sum::<f64>();
        // `f64::max` ignores NaN.
        let all = |m: f64, x: f64| if x.is_nan() { f64::INFINITY } else { m.max(x) };
        (0..n).fold(0.0, |m: f64, i| all(all(m, sum(i, of_q).sqrt()), sum(i, of_v)))
    }

    /// k_i = A_i (q + c_i h v + h² Σ_j a²_ij k_j) + B_i (v + h Σ_j a_ij k_j): one step of length h.
    ///
    /// k_i are the accelerations, A_i = ∂a/∂q and B_i = ∂a/∂v at stage i. Returns the fastest local frequency
    /// at the stages; `None` if the equations of the step are singular.
    fn step(&mut self, orbit: &FourierOrbit, t: f64, h: f64) -> Option<f64> {
        let n = self.q.len();
        let mut fastest = 0.0f64;
        let times = self.rule.nodes.map(|c| t + c * h);
        if self.ahead.0 != h {
            self.ahead = (h, turned(self.rule.nodes.map(|c| c * h / orbit.period())));
        }
        let ([[sin], [cos]], [ahead_sin, ahead_cos]) = (turned([t / orbit.period()]), &self.ahead.1);
        let phases = [
            std::array::from_fn(|stage| sin * ahead_cos[stage] + cos * ahead_sin[stage]),
            std::array::from_fn(|stage| cos * ahead_cos[stage] - sin * ahead_sin[stage]),
        ];
        let [q, v] = &mut self.stages;
        orbit.motions(times, phases, q, v);
        for (stage, &t) in times.iter().enumerate() {
            self.model.drive(t, Side::After, &mut self.u);
            let [q, v] = &self.stages;
            self.q
                .iter_mut()
                .zip(q)
                .chain(self.v.iter_mut().zip(v))
                .for_each(|(x, stages)| *x = stages[stage]);
            fastest = fastest.max(self.read());
            let read = &self.slopes.jacobian;
            for (kept, read) in [(&mut self.of_q, &read.q), (&mut self.of_v, &read.v)] {
                match read.as_slice() {
                    [one] => kept[stage] = *one,
                    all => kept[stage * n * n..][..n * n].copy_from_slice(all),
                }
            }
        }
        if n == 1 {
            self.single(h)?
        } else {
            self.several(h)?
        }
        for (y, k) in self.y.chunks_exact_mut(2 * n).zip(self.k.chunks_exact(STAGES * n)) {
            for i in 0..n {
                let sum = |weights: &[f64; STAGES]| {
                    weights.iter().enumerate().map(|(s, w)| w * k[s * n + i]).sum::<f64>()
                };
                y[i] += h * y[n + i] + h * h * sum(&self.rule.twice);
                y[n + i] += h * sum(&self.rule.weights);
            }
        }
        Some(fastest)
    }

    /// Computes k for one coordinate, with arrays of fixed size and no allocation.
    fn single(&mut self, h: f64) -> Option<()> {
        let (rule, of_q, of_v, y) = (self.rule, &self.of_q[..STAGES], &self.of_v[..STAGES], &self.y);
        let system = SMatrix::<f64, STAGES, STAGES>::from_fn(|i, j| {
            let unit = if i == j { 1.0 } else { 0.0 };
            unit - h * h * rule.square[i][j] * of_q[i] - h * rule.a[i][j] * of_v[i]
        });
        let mut k = SMatrix::<f64, STAGES, 2>::from_fn(|i, column| {
            let (q, v) = (y[2 * column], y[2 * column + 1]);
            of_q[i] * (q + rule.nodes[i] * h * v) + of_v[i] * v
        });
        if !system.lu().solve_mut(&mut k) {
            return None;
        }
        self.k.copy_from_slice(k.as_slice());
        Some(())
    }

    /// Computes k for any number of coordinates.
    fn several(&mut self, h: f64) -> Option<()> {
        let (rule, n) = (self.rule, self.q.len());
        let rows = STAGES * n;
        for (stage, c) in rule.nodes.iter().enumerate() {
            let (of_q, of_v) = (&self.of_q[stage * n * n..][..n * n], &self.of_v[stage * n * n..][..n * n]);
            for other in 0..STAGES {
                let (by_q, by_v) = (-h * h * rule.square[stage][other], -h * rule.a[stage][other]);
                for j in 0..n {
                    let column = &mut self.system.column_mut(other * n + j)[stage * n..(stage + 1) * n];
                    for (i, entry) in column.iter_mut().enumerate() {
                        let unit = if stage == other && i == j { 1.0 } else { 0.0 };
                        *entry = unit + by_q * of_q[j * n + i] + by_v * of_v[j * n + i];
                    }
                }
            }
            for (y, k) in self.y.chunks_exact(2 * n).zip(self.k.chunks_exact_mut(rows)) {
                for i in 0..n {
                    let along =
                        |j: usize| of_q[j * n + i] * (y[j] + c * h * y[n + j]) + of_v[j * n + i] * y[n + j];
                    k[stage * n + i] = (0..n).map(along).sum();
                }
            }
        }
        let factors = Factors::new(&self.system).ok()?;
        self.k.chunks_exact_mut(rows).for_each(|k| factors.solve(k));
        Some(())
    }
}
