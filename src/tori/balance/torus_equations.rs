//! The equations of a balance in several angles and their Jacobian.

use crate::contact::Piece;
use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::model::structure::slopes::{Slopes, accelerate};
use crate::periodic::balance::fourier_orbit::AT_REST;
use crate::roots::matrix::MAX_ENTRIES;
use crate::roots::{Matrix, Residual};
use crate::tori::balance::angle_grid::AngleGrid;
use crate::tori::balance::torus::{Torus, rate};
use crate::tori::balance::wave_vectors::WaveVectors;
use crate::tori::quasi_periodic::QuasiPeriodic;
use num_complex::Complex64;

/// R(x) = coefficients of (ω·∂_θ)² q - a(u(θ), q, (ω·∂_θ) q) at the kept wave vectors.
///
/// The unknowns are the coefficients of every coordinate over its scale: the mean, then a cosine and a sine
/// for each wave vector. Equation i is divided by the scale of coordinate i. The coefficients of a are sums
/// over a grid of angles.
pub(crate) struct TorusEquations<'m> {
    model: &'m dyn QuasiPeriodic,
    vectors: WaveVectors,
    frequencies: Vec<f64>,
    /// k·ω of every vector.
    rates: Vec<f64>,
    /// Places of k and of -k in a transform.
    places: Vec<[usize; 2]>,
    grid: AngleGrid,
    scales: Vec<f64>,
    slopes: Slopes<'m>,
    /// Pieces on which the contacts are fixed; `None`: by deflection.
    pieces: Option<Vec<Piece>>,
    /// Drives, coordinates, velocities and accelerations at every point, one point after the other.
    drives: Vec<f64>,
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    /// Coefficients of the accelerations, in the order of the unknowns.
    forces: Vec<f64>,
    buffer: Vec<Complex64>,
    /// Unknowns of the last evaluation; empty before the first.
    evaluated: Vec<f64>,
}

/// Maximum number of samples of the slopes: 1 GB.
const MAX_SAMPLES: usize = 1 << 27;

impl<'m> TorusEquations<'m> {
    /// `near`: a torus whose coordinates have the size of the motion. `factor`: points of the grid over those
    /// that the orders require.
    pub(crate) fn new(
        model: &'m dyn QuasiPeriodic,
        vectors: &WaveVectors,
        near: &Torus,
        factor: usize,
    ) -> Result<Self, ParameterError> {
        let (n, frequencies) = (model.dof(), near.frequencies().to_vec());
        let sizes = AngleGrid::sizes(vectors.highest(), factor);
        let unknowns = n.saturating_mul(vectors.unknowns());
        check::count("entries of the Jacobian", &[unknowns, unknowns], MAX_ENTRIES)?;
        let per_point = (2 * n * n).max(model.drives()).max(1);
        check::count("samples on the grid of angles", &[&[per_point], &sizes[..]].concat(), MAX_SAMPLES)?;
        let grid = AngleGrid::new(&sizes);
        let (points, m) = (grid.len(), model.drives());
        let (mut drives, mut angles) = (vec![0.0; points * m], vec![0.0; frequencies.len()]);
        for (point, u) in drives.chunks_exact_mut(m.max(1)).enumerate() {
            grid.angles(point, &mut angles);
            model.drive_at(&angles, Side::After, u);
        }
        let rates: Vec<f64> = vectors.vectors().map(|k| rate(k, &frequencies)).collect();
        let places = vectors
            .vectors()
            .map(|k| [grid.place(k.iter().copied()), grid.place(k.iter().map(|k| -k))])
            .collect();
        let fastest = rates.iter().fold(0.0f64, |m, w| m.max(w.abs()));
        let scales = sizes_near(model, near, &drives, fastest);
        let of_rates: Vec<f64> = scales.iter().map(|s| s * fastest).collect();
        let slopes = Slopes::new(model, [&scales[..], &of_rates].concat(), 0.0);
        Ok(TorusEquations {
            model,
            vectors: vectors.clone(),
            frequencies,
            rates,
            places,
            grid,
            scales,
            slopes,
            pieces: None,
            drives,
            q: vec![0.0; points * n],
            v: vec![0.0; points * n],
            a: vec![0.0; points * n],
            forces: vec![0.0; unknowns],
            buffer: vec![Complex64::new(0.0, 0.0); points],
            evaluated: Vec::new(),
        })
    }

    /// The same equations with every contact on a fixed piece.
    pub(crate) fn on_fixed_pieces(mut self, pieces: &[Piece]) -> Self {
        self.pieces = Some(pieces.to_vec());
        self.evaluated.clear();
        self
    }

    pub(crate) fn dof(&self) -> usize {
        self.scales.len()
    }

    pub(crate) fn unknowns(&self, torus: &Torus) -> Vec<f64> {
        let mut x = torus.on(&self.vectors).all().to_vec();
        let width = self.vectors.unknowns();
        x.chunks_exact_mut(width).zip(&self.scales).for_each(|(x, s)| x.iter_mut().for_each(|x| *x /= s));
        x
    }

    pub(crate) fn torus(&self, x: &[f64]) -> Torus {
        let mut all = x.to_vec();
        let width = self.vectors.unknowns();
        all.chunks_exact_mut(width).zip(&self.scales).for_each(|(x, s)| x.iter_mut().for_each(|x| *x *= s));
        Torus::of(self.vectors.clone(), self.frequencies.clone(), all)
    }

    /// Coordinate and wave vector of an unknown or of an equation.
    pub(crate) fn meaning(&self, unknown: usize) -> (usize, Vec<i32>) {
        let width = self.vectors.unknowns();
        (unknown / width, self.vectors.vector((unknown % width).div_ceil(2)).to_vec())
    }

    /// Coefficients of the accelerations at the unknowns x, in the order of the unknowns and in the units of
    /// the model.
    pub(crate) fn forces(&mut self, x: &[f64]) -> &[f64] {
        self.evaluate(x);
        &self.forces
    }

    /// The kept coefficients, from sums over the grid in `buffer`.
    fn read(&self, out: &mut [f64]) {
        let share = 1.0 / self.grid.len() as f64;
        out[0] = self.buffer[self.places[0][0]].re * share;
        for (pair, [place, _]) in out[1..].chunks_exact_mut(2).zip(&self.places[1..]) {
            let c = self.buffer[*place] * (2.0 * share);
            pair.copy_from_slice(&[c.re, -c.im]);
        }
    }

    fn evaluate(&mut self, x: &[f64]) {
        if self.evaluated == x {
            return;
        }
        let (n, m, width) = (self.model.dof(), self.model.drives(), self.vectors.unknowns());
        // Coordinate and velocity share a transform as q + i v/w. The factor 1/w brings v to the size of q.
        let fastest = self.rates.iter().fold(0.0f64, |m, w| m.max(w.abs()));
        let zero = Complex64::new(0.0, 0.0);
        for (i, (x, scale)) in x.chunks_exact(width).zip(&self.scales).enumerate() {
            self.buffer.fill(zero);
            self.buffer[self.places[0][0]].re += x[0] * scale;
            for ((pair, rate), [place, mirror]) in
                x[1..].chunks_exact(2).zip(&self.rates[1..]).zip(&self.places[1..])
            {
                let c = Complex64::new(0.5 * pair[0], -0.5 * pair[1]) * *scale;
                let share = rate / fastest;
                self.buffer[*place] += c * (1.0 - share);
                self.buffer[*mirror] += c.conj() * (1.0 + share);
            }
            self.grid.synthesise(&mut self.buffer);
            for (point, z) in self.buffer.iter().enumerate() {
                self.q[point * n + i] = z.re;
                self.v[point * n + i] = z.im * fastest;
            }
        }
        for point in 0..self.grid.len() {
            let (u, here) = (&self.drives[point * m..(point + 1) * m], point * n..(point + 1) * n);
            let (q, v) = (&self.q[here.clone()], &self.v[here.clone()]);
            accelerate(self.model, self.pieces.as_deref(), u, q, v, &mut self.a[here]);
        }
        let mut forces = std::mem::take(&mut self.forces);
        for (i, out) in forces.chunks_exact_mut(width).enumerate() {
            for (z, a) in self.buffer.iter_mut().zip(self.a.chunks_exact(n)) {
                *z = Complex64::new(a[i], 0.0);
            }
            self.grid.analyse(&mut self.buffer);
            self.read(out);
        }
        self.forces = forces;
        self.evaluated.clear();
        self.evaluated.extend_from_slice(x);
    }

    /// Adds -(coefficients of F δq_j + B δv_j) of one pair of coordinates to the Jacobian. `by_q` and `by_v`:
    /// transforms of F = ∂a_i/∂q_j and of B = ∂a_i/∂v_j.
    fn add_pair(&self, (i, j): (usize, usize), by_q: &[Complex64], by_v: &[Complex64], out: &mut Matrix) {
        let width = self.vectors.unknowns();
        let ratio = self.scales[j] / self.scales[i] / self.grid.len() as f64;
        for (c, (l, rate)) in self.vectors.vectors().zip(&self.rates).enumerate() {
            for (r, k) in self.vectors.vectors().enumerate() {
                // Coefficients of F cos l·θ and F sin l·θ at k, from F at k - l and k + l.
                let minus = self.grid.place(k.iter().zip(l).map(|(k, l)| k - l));
                let plus = self.grid.place(k.iter().zip(l).map(|(k, l)| k + l));
                let products = |f: &[Complex64]| {
                    let (sum, difference) = (f[minus] + f[plus], f[minus] - f[plus]);
                    [[sum.re, -sum.im], [difference.im, difference.re]]
                };
                let [[cc, sc], [cs, ss]] = products(by_q);
                let [[vcc, vsc], [vcs, vss]] = products(by_v);
                // δv of cos l·θ is -(l·ω) sin l·θ, and that of sin l·θ is (l·ω) cos l·θ.
                let of_cos = [cc - rate * vcs, sc - rate * vss];
                let of_sin = [cs + rate * vcc, ss + rate * vsc];
                let half = if r == 0 { 0.5 } else { 1.0 };
                let row = i * width + (2 * r).saturating_sub(1);
                let column = j * width + (2 * c).saturating_sub(1);
                let parts = if c == 0 { 1 } else { 2 };
                for (at, values) in [of_cos, of_sin].iter().take(parts).enumerate() {
                    let entries = &mut out.column_mut(column + at)[row..];
                    entries[0] -= half * ratio * values[0];
                    if r > 0 {
                        entries[1] -= ratio * values[1];
                    }
                }
            }
        }
    }
}

/// Sizes of the coordinates: the largest coefficient of `near`. A coordinate that is 0 gets its largest
/// acceleration at rest over the square of the highest rate. A coordinate that rests but for rounding, as the
/// difference of equal members does, gets the largest size of the others; if all are 0, the value 1.
fn sizes_near(model: &dyn QuasiPeriodic, near: &Torus, drives: &[f64], fastest: f64) -> Vec<f64> {
    let n = model.dof();
    let mut sizes: Vec<f64> = (0..n).map(|i| near.largest_coefficient(i)).collect();
    if sizes.contains(&0.0) {
        let (rest, mut a) = (vec![0.0; n], vec![0.0; n]);
        let mut largest = vec![0.0f64; n];
        for u in drives.chunks_exact(model.drives().max(1)) {
            model.accel(u, &rest, &rest, &mut a);
            largest.iter_mut().zip(&a).for_each(|(m, a)| *m = m.max(a.abs()));
        }
        for (size, largest) in sizes.iter_mut().zip(&largest) {
            if *size == 0.0 && largest.is_finite() {
                *size = largest / (fastest * fastest);
            }
        }
    }
    let all = sizes.iter().fold(0.0f64, |m, s| m.max(*s));
    let other = if all > 0.0 && all.is_finite() { all } else { 1.0 };
    sizes.iter().map(|s| if *s > AT_REST * other && s.is_finite() { *s } else { other }).collect()
}

impl Residual for TorusEquations<'_> {
    fn size(&self) -> usize {
        self.forces.len()
    }

    fn residual(&mut self, x: &[f64], r: &mut [f64]) {
        self.evaluate(x);
        let width = self.vectors.unknowns();
        for (i, scale) in self.scales.iter().enumerate() {
            let here = i * width..(i + 1) * width;
            let (x, forces) = (&x[here.clone()], &self.forces[here.clone()]);
            for (at, r) in r[here].iter_mut().enumerate() {
                let rate = self.rates[at.div_ceil(2)];
                *r = -rate * rate * x[at] - forces[at] / scale;
            }
        }
    }

    fn jacobian(&mut self, x: &[f64], out: &mut Matrix) {
        self.evaluate(x);
        let (n, m, width) = (self.model.dof(), self.model.drives(), self.vectors.unknowns());
        for column in 0..n * width {
            let rate = self.rates[(column % width).div_ceil(2)];
            let entries = out.column_mut(column);
            entries.fill(0.0);
            entries[column] = -rate * rate;
        }
        let points = self.grid.len();
        let mut samples = vec![Complex64::new(0.0, 0.0); 2 * n * n * points];
        for point in 0..points {
            let (u, here) = (&self.drives[point * m..(point + 1) * m], point * n..(point + 1) * n);
            self.slopes.at(self.pieces.as_deref(), u, &self.q[here.clone()], &self.v[here]);
            let jacobian = &self.slopes.jacobian;
            for pair in 0..n * n {
                samples[2 * pair * points + point].re = jacobian.q[(pair / n, pair % n)];
                samples[(2 * pair + 1) * points + point].re = jacobian.v[(pair / n, pair % n)];
            }
        }
        for (pair, both) in samples.chunks_exact_mut(2 * points).enumerate() {
            if both.iter().all(|z| z.re == 0.0) {
                continue;
            }
            let (by_q, by_v) = both.split_at_mut(points);
            self.grid.analyse(by_q);
            self.grid.analyse(by_v);
            self.add_pair((pair / n, pair % n), by_q, by_v, out);
        }
    }
}
