//! Stages, norms and dense output of one explicit step: the arithmetic that all tableaux share.

use crate::model::{Contact, Model, Piece, Side};

/// A row of a tableau: (column from 0, coefficient), zeros left out.
pub type Row<const L: usize> = [(usize, f64); L];

/// An explicit Runge-Kutta method, written stage by stage as in the book.
pub trait Tableau {
    /// Derivatives that are kept, those of the dense output included.
    const SLOTS: usize;
    /// The slot of f(t + h, y1).
    const END: usize;
    /// Coefficients of the dense output.
    const DENSE: usize;
    /// 1/order of the error estimate.
    const EXPONENT: f64;
    /// Least and largest change of the step.
    const FACTORS: [f64; 2];
    /// β of the PI controller.
    const BETA: f64;

    /// Stages and y1 of a step from `e.t` to `e.t1`; slot 0 is there already.
    fn attempt<M: Model + ?Sized, const N: usize>(e: &mut Engine<'_, M, N>);
    /// The error estimate in units of the tolerance.
    fn error<M: Model + ?Sized, const N: usize>(e: &Engine<'_, M, N>) -> f64;
    /// The dense coefficients past the third; slot `END` is there already.
    fn dense<M: Model + ?Sized, const N: usize>(e: &mut Engine<'_, M, N>);
}

/// The working arrays of one run, all allocated before its first step. `N` is the number of degrees of freedom where it is known to
/// the compiler, 0 where not.
pub struct Engine<'m, M: Model + ?Sized, const N: usize> {
    pub(crate) model: &'m M,
    dof: usize,
    /// Start and end of the step.
    pub(crate) t: f64,
    pub(crate) t1: f64,
    /// Coordinates, then velocities, at the start, at a stage and at the end.
    pub(crate) y: Vec<f64>,
    stage: Vec<f64>,
    pub(crate) y1: Vec<f64>,
    /// The derivatives k_1, k_2, ... one after the other.
    k: Vec<f64>,
    /// Drives at the start, at a stage and at the end.
    pub(crate) u: Vec<f64>,
    u_stage: Vec<f64>,
    pub(crate) u1: Vec<f64>,
    /// The pieces on which the contacts are held, if they are.
    pub(crate) pieces: Vec<Piece>,
    pub(crate) frozen: bool,
    pub(crate) rtol: f64,
    pub(crate) atol: Vec<f64>,
    /// Dense output: y0, then its coefficients.
    dense: Vec<f64>,
    pub(crate) ready: Ready,
    /// Scratch for looking inside a step.
    pub(crate) look: Vec<f64>,
    pub(crate) contacts: Vec<Contact>,
    pub(crate) evaluations: u64,
}

/// What is known of the step just made.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Ready {
    /// Slot `END`.
    pub(crate) end: bool,
    /// Dense coefficients.
    pub(crate) dense: bool,
}

impl<'m, M: Model + ?Sized, const N: usize> Engine<'m, M, N> {
    pub(crate) fn new<T: Tableau>(model: &'m M, y: Vec<f64>, t: f64) -> Self {
        let m = y.len();
        let (drives, contacts) = (model.drives(), model.contacts());
        Engine {
            model,
            dof: m / 2,
            t,
            t1: t,
            stage: vec![0.0; m],
            y1: y.clone(),
            k: vec![0.0; T::SLOTS * m],
            u: vec![0.0; drives],
            u_stage: vec![0.0; drives],
            u1: vec![0.0; drives],
            pieces: vec![Piece::Gap; contacts],
            frozen: false,
            rtol: 0.0,
            atol: vec![0.0; m],
            dense: vec![0.0; (T::DENSE + 1) * m],
            ready: Ready { end: false, dense: false },
            look: vec![0.0; m],
            contacts: vec![Contact::default(); contacts],
            evaluations: 0,
            y,
        }
    }

    /// Degrees of freedom, a constant wherever possible.
    #[inline(always)]
    fn n(&self) -> usize {
        if N > 0 { N } else { self.dof }
    }

    pub(crate) fn slot(&self, s: usize) -> &[f64] {
        let m = 2 * self.n();
        &self.k[s * m..(s + 1) * m]
    }

    /// Sets the end of the step to come.
    #[inline(always)]
    pub(crate) fn aim(&mut self, t1: f64) {
        self.t1 = t1;
        self.ready = Ready { end: false, dense: false };
    }

    #[inline(always)]
    pub(crate) fn h(&self) -> f64 {
        self.t1 - self.t
    }

    /// The drives inside the step.
    #[inline(always)]
    pub(crate) fn drive(&mut self, c: f64) {
        let t = self.t + c * self.h();
        self.model.drive(t, Side::After, &mut self.u_stage);
    }

    /// The drives at its end, seen from before.
    #[inline(always)]
    pub(crate) fn drive_end(&mut self) {
        self.model.drive(self.t1, Side::Before, &mut self.u1);
    }

    /// k_s at y0 + h Σ a k with the drives of the last [`drive`](Engine::drive).
    #[inline(always)]
    pub(crate) fn stage<const L: usize>(&mut self, s: usize, row: &Row<L>) {
        combine::<N, L>(&mut self.stage, &self.y, &self.k, self.t1 - self.t, row);
        let m = 2 * self.n();
        derivative(self.model, self.frozen.then_some(&self.pieces), &self.u_stage, &self.stage, &mut self.k[s * m..(s + 1) * m], m / 2);
        self.evaluations += 1;
    }

    /// The same with the drives at the end.
    #[inline(always)]
    pub(crate) fn stage_end<const L: usize>(&mut self, s: usize, row: &Row<L>) {
        combine::<N, L>(&mut self.stage, &self.y, &self.k, self.t1 - self.t, row);
        let m = 2 * self.n();
        derivative(self.model, self.frozen.then_some(&self.pieces), &self.u1, &self.stage, &mut self.k[s * m..(s + 1) * m], m / 2);
        self.evaluations += 1;
    }

    /// y1 = y0 + h Σ b k.
    #[inline(always)]
    pub(crate) fn advance<const L: usize>(&mut self, row: &Row<L>) {
        combine::<N, L>(&mut self.y1, &self.y, &self.k, self.t1 - self.t, row);
    }

    /// f(t1, y1) into its slot, once.
    #[inline(always)]
    pub(crate) fn derivative_at_end_of<T: Tableau>(&mut self) {
        if !self.ready.end {
            let m = 2 * self.n();
            let k = &mut self.k[T::END * m..(T::END + 1) * m];
            derivative(self.model, self.frozen.then_some(&self.pieces), &self.u1, &self.y1, k, m / 2);
            self.evaluations += 1;
            self.ready.end = true;
        }
    }

    /// f(t, y) into slot 0, with the drives as they stand in `u`.
    #[inline(always)]
    pub(crate) fn derivative_at_start(&mut self) {
        let m = 2 * self.n();
        derivative(self.model, self.frozen.then_some(&self.pieces), &self.u, &self.y, &mut self.k[..m], m / 2);
        self.evaluations += 1;
    }

    /// One Euler step, its derivative at the end in slot 1: what the starting step needs.
    pub(crate) fn euler(&mut self) {
        self.drive(1.0);
        self.stage(1, &[(0, 1.0)]);
    }

    /// Makes the end of the step the start of the next.
    #[inline(always)]
    pub(crate) fn accept<T: Tableau>(&mut self) {
        self.t = self.t1;
        std::mem::swap(&mut self.y, &mut self.y1);
        std::mem::swap(&mut self.u, &mut self.u1);
        let m = 2 * self.n();
        let (first, rest) = self.k.split_at_mut(m);
        first.copy_from_slice(&rest[(T::END - 1) * m..][..m]);
    }

    /// Whether the end of the step is made of numbers.
    #[inline(always)]
    pub(crate) fn finite(&self) -> bool {
        let m = 2 * self.n();
        self.y1[..m].iter().fold(0.0, |sum, y| sum + 0.0 * y) == 0.0
    }

    /// h |Σ e k| in units of the tolerances, root mean square over the components.
    #[inline(always)]
    pub(crate) fn norm<const L: usize>(&self, row: &Row<L>) -> f64 {
        let m = 2 * self.n();
        let (y, y1, atol) = (&self.y[..m], &self.y1[..m], &self.atol[..m]);
        let k: [&[f64]; L] = std::array::from_fn(|l| &self.k[row[l].0 * m..][..m]);
        let mut sum = 0.0;
        for j in 0..m {
            let mut e = row[0].1 * k[0][j];
            for l in 1..L {
                e += row[l].1 * k[l][j];
            }
            let size = atol[j] + self.rtol * y[j].abs().max(y1[j].abs());
            sum += (e / size) * (e / size);
        }
        self.h() * (sum / m as f64).sqrt()
    }

    /// Prepares the dense output of the step, once.
    pub(crate) fn prepare_dense<T: Tableau>(&mut self) {
        if self.ready.dense {
            return;
        }
        self.derivative_at_end_of::<T>();
        T::dense(self);
        let (m, h) = (2 * self.n(), self.h());
        for j in 0..m {
            let dy = self.y1[j] - self.y[j];
            let (k0, k1) = (self.k[j], self.k[T::END * m + j]);
            self.dense[j] = self.y[j];
            self.dense[m + j] = dy;
            self.dense[2 * m + j] = h * k0 - dy;
            self.dense[3 * m + j] = 2.0 * dy - h * (k0 + k1);
        }
        self.ready.dense = true;
    }

    /// Dense coefficient `c` (from 3): h Σ d k.
    pub(crate) fn dense_row<const L: usize>(&mut self, c: usize, row: &Row<L>) {
        let (m, h) = (2 * self.n(), self.h());
        for j in 0..m {
            self.dense[(c + 1) * m + j] = h * row.iter().map(|&(i, d)| d * self.k[i * m + j]).sum::<f64>();
        }
    }

    /// y at t + θ h: y0 + θ (F0 + (1-θ) (F1 + θ (F2 + (1-θ) (F3 + ...)))).
    #[inline]
    pub(crate) fn interpolate<T: Tableau>(&self, theta: f64, out: &mut [f64]) {
        let m = 2 * self.n();
        for (j, out) in out.iter_mut().enumerate() {
            let mut sum = 0.0;
            for c in (1..=T::DENSE).rev() {
                let factor = if c % 2 == 1 { theta } else { 1.0 - theta };
                sum = (sum + self.dense[c * m + j]) * factor;
            }
            *out = self.dense[j] + sum;
        }
    }

    /// The contacts at θ of the step, into `self.contacts`.
    pub(crate) fn contacts_inside<T: Tableau>(&mut self, theta: f64) {
        let mut look = std::mem::take(&mut self.look);
        self.interpolate::<T>(theta, &mut look);
        self.drive(theta);
        let (q, v) = look.split_at(self.n());
        self.model.contact(&self.u_stage, q, v, &mut self.contacts);
        self.look = look;
    }

    /// The contacts at the end of the step.
    #[inline(always)]
    pub(crate) fn contacts_at_end(&mut self) {
        let (q, v) = self.y1.split_at(self.n());
        self.model.contact(&self.u1, q, v, &mut self.contacts);
    }

    /// The contacts at its start.
    pub(crate) fn contacts_at_start(&mut self) {
        let (q, v) = self.y.split_at(self.n());
        self.model.contact(&self.u, q, v, &mut self.contacts);
    }
}

/// out = y + h Σ a_l k_l.
#[inline(always)]
fn combine<const N: usize, const L: usize>(out: &mut [f64], y: &[f64], k: &[f64], h: f64, row: &Row<L>) {
    let m = if N > 0 { 2 * N } else { y.len() };
    let (out, y) = (&mut out[..m], &y[..m]);
    let k: [&[f64]; L] = std::array::from_fn(|l| &k[row[l].0 * m..][..m]);
    for j in 0..m {
        let mut sum = row[0].1 * k[0][j];
        for l in 1..L {
            sum += row[l].1 * k[l][j];
        }
        out[j] = y[j] + h * sum;
    }
}

/// (q', v') = (v, a).
#[inline(always)]
fn derivative<M: Model + ?Sized>(model: &M, pieces: Option<&Vec<Piece>>, u: &[f64], y: &[f64], out: &mut [f64], n: usize) {
    let (q, v) = y.split_at(n);
    let (velocity, a) = out.split_at_mut(n);
    velocity.copy_from_slice(v);
    match pieces {
        Some(pieces) => {
            model.accel_on_pieces(pieces, u, q, v, a);
        }
        None => model.accel(u, q, v, a),
    }
}
