//! Stages, norms and dense output of one explicit step: the arithmetic that all tableaux share.

use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::excitation::side::Side;
use crate::model::equations::{Model, State};
use crate::ode::stepping::row::{Row, SLOTS};
use crate::ode::stepping::vector::Vector;

/// An explicit Runge-Kutta method, written stage by stage as in the book.
pub trait Tableau {
    /// Whether steps follow an error estimate.
    const ADAPTIVE: bool;
    /// Derivatives that are kept, those of the dense output included.
    const SLOTS: usize;
    /// Evaluations in one attempt.
    const EVALUATIONS: u64;
    /// The slot of f(t + h, y1).
    const END: usize;
    /// Coefficients of the dense output.
    const DENSE: usize;
    /// Evaluations that they take, slot `END` not counted.
    const DENSE_EVALUATIONS: u64;
    /// 1/order of the error estimate.
    const EXPONENT: f64;
    /// Least and largest change of the step.
    const FACTORS: [f64; 2];
    /// β of the PI controller.
    const BETA: f64;
    /// The node, near the middle, whose drives [`attempt`](Tableau::attempt) keeps for a look at the gaps inside the step.
    const PROBE: f64;

    /// Stages and y1 of a step from `e.t` to `e.t1`; slot 0 is there already.
    ///
    /// `HELD`: the contacts stay on `e.pieces`.
    fn attempt<M: Model + ?Sized, V: Vector, const HELD: bool>(e: &mut Engine<'_, M, V>);
    /// The error estimate in units of the tolerance.
    fn error<M: Model + ?Sized, V: Vector>(e: &Engine<'_, M, V>) -> f64;
    /// The dense coefficients past the third; slot `END` is there already.
    fn dense<M: Model + ?Sized, V: Vector, const HELD: bool>(e: &mut Engine<'_, M, V>);
}

/// Dense coefficients that any tableau may use, y0 included.
const DENSE: usize = 8;

/// Motions are given up beyond this size: their squares and products would overflow.
pub(crate) const LARGEST: f64 = 1e100;

/// The working arrays of one run, all made before its first step.
pub struct Engine<'m, M: Model + ?Sized, V: Vector> {
    pub(crate) model: &'m M,
    /// Start and end of the step.
    pub(crate) t: f64,
    pub(crate) t1: f64,
    pub(crate) h: f64,
    /// Coordinates, then velocities, at the start and at the end.
    pub(crate) y: V,
    pub(crate) y1: V,
    /// The derivatives k_1, k_2, ...
    pub(crate) k: [V; SLOTS],
    /// Drives at a stage and at the end.
    pub(crate) u_stage: Vec<f64>,
    pub(crate) u1: Vec<f64>,
    /// Drives at node `PROBE` of the step.
    pub(crate) u_probe: Vec<f64>,
    /// The pieces on which the contacts are held, if they are.
    pub(crate) pieces: Vec<Piece>,
    pub(crate) frozen: bool,
    pub(crate) rtol: f64,
    pub(crate) atol: V,
    /// Dense output: y0, then its coefficients.
    pub(crate) dense: [V; DENSE],
    pub(crate) ready: Ready,
    /// Scratch for looking inside a step.
    pub(crate) look: V,
    pub(crate) contacts: Vec<Contact>,
    pub(crate) shaken: Vec<Contact>,
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

impl<'m, M: Model + ?Sized, V: Vector> Engine<'m, M, V> {
    pub(crate) fn new<T: Tableau>(model: &'m M, start: &State, locate: bool) -> Self {
        let (drives, contacts, m) = (model.drives(), model.contacts(), 2 * model.dof());
        let mut y = V::zeros(m);
        let (q, v) = y.slice_mut().split_at_mut(m / 2);
        q.copy_from_slice(&start.q);
        v.copy_from_slice(&start.v);
        // Once in full; at every stage what changes.
        let mut u = vec![0.0; drives];
        model.drive(start.t, Side::After, &mut u);
        Engine {
            model,
            t: start.t,
            t1: start.t,
            h: 0.0,
            y1: y.clone(),
            k: std::array::from_fn(|s| V::slot(if s < T::SLOTS { m } else { 0 })),
            u_probe: if locate { u.clone() } else { Vec::new() },
            u_stage: u.clone(),
            u1: u,
            pieces: vec![Piece::Gap; contacts],
            frozen: false,
            rtol: 0.0,
            atol: V::zeros(m),
            dense: std::array::from_fn(|c| V::zeros(if c <= T::DENSE { m } else { 0 })),
            ready: Ready { end: false, dense: false },
            look: V::zeros(m),
            contacts: vec![Contact::default(); contacts],
            shaken: vec![Contact::default(); contacts],
            evaluations: 0,
            y,
        }
    }

    /// Sets the end of the step to come.
    #[inline(always)]
    pub(crate) fn aim(&mut self, t1: f64) {
        self.t1 = t1;
        self.h = t1 - self.t;
        self.ready = Ready { end: false, dense: false };
    }

    #[inline(always)]
    pub(crate) fn h(&self) -> f64 {
        self.h
    }

    /// The drives inside the step.
    #[inline(always)]
    pub(crate) fn drive(&mut self, c: f64) {
        let t = self.t + c * self.h();
        self.model.redrive(t, Side::After, &mut self.u_stage);
    }

    /// The drives at node `PROBE`, kept.
    #[inline(always)]
    pub(crate) fn drive_probe<T: Tableau>(&mut self) {
        self.drive(T::PROBE);
        if !self.u_probe.is_empty() {
            self.u_probe.copy_from_slice(&self.u_stage);
        }
    }

    /// The drives at its end, seen from before.
    #[inline(always)]
    pub(crate) fn drive_end(&mut self) {
        self.model.redrive(self.t1, Side::Before, &mut self.u1);
    }

    /// k_s at y0 + h Σ a k with the drives of the last [`drive`](Engine::drive).
    #[inline(always)]
    pub(crate) fn stage<const HELD: bool, const L: usize>(&mut self, s: usize, row: &Row<L>) {
        let (model, pieces, u) = (self.model, &self.pieces, &self.u_stage);
        V::stage(&mut self.k, s, &self.y, self.h, row, |q, v, a| {
            accelerate::<M, HELD>(model, pieces, u, q, v, a)
        });
    }

    /// The same with the drives at the end.
    #[inline(always)]
    pub(crate) fn stage_end<const HELD: bool, const L: usize>(&mut self, s: usize, row: &Row<L>) {
        let (model, pieces, u) = (self.model, &self.pieces, &self.u1);
        V::stage(&mut self.k, s, &self.y, self.h, row, |q, v, a| {
            accelerate::<M, HELD>(model, pieces, u, q, v, a)
        });
    }

    /// y1 = y0 + h Σ b k.
    #[inline(always)]
    pub(crate) fn advance<const L: usize>(&mut self, row: &Row<L>) {
        V::combine(&mut self.y1, &self.y, &self.k, self.h, row);
    }

    /// f(t1, y1) into its slot, once.
    #[inline(always)]
    pub(crate) fn derivative_at_end_of<T: Tableau>(&mut self) {
        if !self.ready.end {
            let k = &mut self.k[T::END];
            if self.frozen {
                derivative::<M, V, true>(self.model, &self.pieces, &self.u1, &self.y1, k);
            } else {
                derivative::<M, V, false>(self.model, &self.pieces, &self.u1, &self.y1, k);
            }
            self.evaluations += 1;
            self.ready.end = true;
        }
    }

    /// One step's stages, not counted here.
    // Without optimisation it is compiled once, not in each loop.
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn attempt<T: Tableau, const LOCATE: bool>(&mut self) {
        if LOCATE && self.frozen { T::attempt::<M, V, true>(self) } else { T::attempt::<M, V, false>(self) }
    }

    /// f(t, y) into slot 0, the drives seen from after.
    #[inline(always)]
    pub(crate) fn derivative_at_start(&mut self) {
        self.model.redrive(self.t, Side::After, &mut self.u_stage);
        if self.frozen {
            derivative::<M, V, true>(self.model, &self.pieces, &self.u_stage, &self.y, &mut self.k[0]);
        } else {
            derivative::<M, V, false>(self.model, &self.pieces, &self.u_stage, &self.y, &mut self.k[0]);
        }
        self.evaluations += 1;
    }

    /// One Euler step, its derivative at the end in slot 1: what the starting step needs.
    pub(crate) fn euler(&mut self) {
        self.drive(1.0);
        self.stage::<false, 1>(1, &[(0, 1.0)]);
        self.evaluations += 1;
    }

    /// Makes the end of the step the start of the next, without its derivative.
    #[inline(always)]
    pub(crate) fn move_on(&mut self) {
        self.t = self.t1;
        V::hand_over(&mut self.y1, &mut self.y);
    }

    /// The same with the derivative: on a smooth trajectory, that at the end.
    #[inline(always)]
    pub(crate) fn accept<T: Tableau, const LOCATE: bool>(&mut self) {
        if self.ready.end {
            let (first, rest) = self.k.split_at_mut(1);
            V::hand_over(&mut rest[T::END - 1], &mut first[0]);
        } else {
            if LOCATE && self.frozen {
                derivative::<M, V, true>(self.model, &self.pieces, &self.u1, &self.y1, &mut self.k[0]);
            } else {
                derivative::<M, V, false>(self.model, &self.pieces, &self.u1, &self.y1, &mut self.k[0]);
            }
            self.evaluations += 1;
        }
        self.move_on();
    }

    /// Whether the end of the step is made of numbers with which dense output, channels and their squares can be computed.
    #[inline(always)]
    pub(crate) fn finite(&self) -> bool {
        self.y1.size() <= LARGEST
    }

    /// h |Σ e k| in units of the tolerances, root mean square over the components, for each row.
    #[inline(always)]
    pub(crate) fn norms<const L: usize, const R: usize>(&self, rows: [&Row<L>; R]) -> [f64; R] {
        let (h, m) = (self.h(), self.y.slice().len() as f64);
        V::squares([&self.y, &self.y1], &self.k, &self.atol, self.rtol, rows).map(|sum| h * (sum / m).sqrt())
    }

    /// Prepares the dense output of the step, once.
    pub(crate) fn prepare_dense<T: Tableau>(&mut self) {
        if self.ready.dense {
            return;
        }
        self.derivative_at_end_of::<T>();
        if self.frozen {
            T::dense::<M, V, true>(self)
        } else {
            T::dense::<M, V, false>(self)
        }
        self.evaluations += T::DENSE_EVALUATIONS;
        let h = self.h();
        let [first, rise, bend, twist, ..] = &mut self.dense;
        let ends = self.y.slice().iter().zip(self.y1.slice());
        let slopes = self.k[0].slice().iter().zip(self.k[T::END].slice());
        for (j, ((y, y1), (k0, k1))) in ends.zip(slopes).enumerate() {
            let dy = y1 - y;
            first.slice_mut()[j] = *y;
            rise.slice_mut()[j] = dy;
            bend.slice_mut()[j] = h * k0 - dy;
            twist.slice_mut()[j] = 2.0 * dy - h * (k0 + k1);
        }
        // Only with a tolerance above the motion itself a step passes whose coefficients overflow. Without them its ends are met still.
        for coefficient in self
            .dense
            .iter_mut()
            .flat_map(|column| column.slice_mut())
            .filter(|x| x.is_nan() || x.abs() > LARGEST)
        {
            *coefficient = 0.0;
        }
        self.ready.dense = true;
    }

    /// Dense coefficient `c` (from 3): h Σ d k.
    pub(crate) fn dense_row<const L: usize>(&mut self, c: usize, row: &Row<L>) {
        V::weigh(&mut self.dense[c + 1], &self.k, self.h, row);
    }

    /// y at t + θ h: y0 + θ (F0 + (1-θ) (F1 + θ (F2 + (1-θ) (F3 + ...)))).
    #[inline]
    pub(crate) fn interpolate<T: Tableau>(&self, theta: f64, out: &mut [f64]) {
        interpolate::<T, V>(&self.dense, theta, out);
    }
}

/// Coordinates and velocities.
#[inline(always)]
pub(crate) fn halves<V: Vector>(y: &V) -> (&[f64], &[f64]) {
    y.slice().split_at(y.slice().len() / 2)
}

pub(crate) fn interpolate<T: Tableau, V: Vector>(dense: &[V; DENSE], theta: f64, out: &mut [f64]) {
    let columns: [&[f64]; DENSE] =
        std::array::from_fn(|c| if c <= T::DENSE { dense[c].slice() } else { &[][..] });
    // Side by side, since the sums of one component wait for each other.
    let whole = out.len() - out.len() % 8;
    for j in (0..whole).step_by(8) {
        horner::<8>(&columns[..=T::DENSE], j, theta, out);
    }
    for j in whole..out.len() {
        horner::<1>(&columns[..=T::DENSE], j, theta, out);
    }
}

/// The same for W components from `j` on.
#[inline(always)]
fn horner<const W: usize>(columns: &[&[f64]], j: usize, theta: f64, out: &mut [f64]) {
    let mut sum = [0.0; W];
    for (c, column) in columns.iter().enumerate().skip(1).rev() {
        let (factor, column) = (if c % 2 == 1 { theta } else { 1.0 - theta }, &column[j..][..W]);
        for i in 0..W {
            sum[i] = (sum[i] + column[i]) * factor;
        }
    }
    let (out, start) = (&mut out[j..][..W], &columns[0][j..][..W]);
    for i in 0..W {
        out[i] = start[i] + sum[i];
    }
}

/// (q', v') = (v, a).
#[inline(always)]
fn derivative<M: Model + ?Sized, V: Vector, const HELD: bool>(
    model: &M,
    pieces: &[Piece],
    u: &[f64],
    y: &V,
    out: &mut V,
) {
    V::derivative(out, y, |q, v, a| accelerate::<M, HELD>(model, pieces, u, q, v, a));
}

#[inline(always)]
fn accelerate<M: Model + ?Sized, const HELD: bool>(
    model: &M,
    pieces: &[Piece],
    u: &[f64],
    q: &[f64],
    v: &[f64],
    a: &mut [f64],
) {
    if HELD {
        model.accel_on_pieces(pieces, u, q, v, a);
    } else {
        model.accel(u, q, v, a);
    }
}
