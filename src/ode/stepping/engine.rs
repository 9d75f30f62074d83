//! Stages and norms of one explicit Runge-Kutta step, common to all tableaux.

use crate::model::equations::each_row;
use crate::model::{Model, State};
use crate::ode::shifted::Shifted;
use crate::ode::stepping::ends::{Ends, side_of};
use crate::ode::stepping::one_step::OwnStep;
use crate::ode::stepping::tableau_row::{SLOTS, TableauRow};
use crate::ode::stepping::vector::{Algebra, Vector};
use std::fmt;

/// A Runge-Kutta or Rosenbrock method, written stage by stage as in Hairer, Nørsett & Wanner I and II.
pub trait Tableau: Default {
    /// Whether an error estimate controls the step size.
    const ADAPTIVE: bool;
    /// γ of a Rosenbrock method; `None` for an explicit method.
    const IMPLICIT: Option<f64> = None;
    /// Whether the dense output contains the cubic through the states and derivatives at both ends (Hermite).
    const HERMITE: bool = true;
    /// Number of slots: derivatives k that are kept, those of the dense output included.
    const SLOTS: usize;
    /// Number of evaluations in one attempt, slots 0 and `END` not counted.
    const EVALUATIONS: u64;
    /// The slot of f(t + h, y1).
    const END: usize;
    /// Number of coefficients of the dense output, y0 not counted.
    const DENSE: usize;
    /// Number of evaluations for the dense output, slot `END` not counted.
    const DENSE_EVALUATIONS: u64;
    /// 1/k, the exponent of the step size control: k = 5 for order 5(4), k = 8 for order 8.
    const EXPONENT: f64;
    /// Minimum and maximum ratio of a step to the step before.
    const FACTORS: [f64; 2];
    /// β of the PI controller.
    const BETA: f64;
    /// The nodes c > 0, each once; the last one is 1.
    const NODES: &'static [f64];
    /// Index of a node near the middle of the step, for the check of the gaps.
    const PROBE: usize;

    /// Computes the stages and y1 of a step from `e.t` to `e.t1`. Slot 0 must be filled.
    ///
    /// `FIXED`: the model is evaluated on the fixed pieces `e.pieces`.
    fn attempt<V: Vector, const FIXED: bool>(e: &mut Engine<'_, V>);
    /// Error estimate in units of the tolerance; a step with an error of at most 1 is accepted.
    fn error<V: Vector>(e: &mut Engine<'_, V>) -> f64;
    /// Computes the dense coefficients F3, F4, ... (see [`Engine::interpolate`]). Slot `END` must be filled.
    fn dense<V: Vector, const FIXED: bool>(e: &mut Engine<'_, V>);
}

/// Maximum number of dense coefficients of a tableau, y0 included.
pub(super) const DENSE: usize = 8;

/// Working arrays of one run, allocated before its first step.
pub struct Engine<'m, V: Vector> {
    pub(crate) ends: Ends<'m, V>,
    /// The derivatives k_0, k_1, ..., one in each slot.
    pub(crate) k: [V; SLOTS],
    /// Whether the model is evaluated on the fixed pieces of `ends`.
    pub(crate) on_fixed_pieces: bool,
    /// Relative tolerance.
    pub(crate) rtol: f64,
    /// The error estimates of the current step, if the tableau compares them with those of the step before.
    pub(crate) estimates: Estimates,
    /// The estimates of the step before; `None` for the first step and behind an edge.
    pub(crate) before: Option<Estimates>,
    /// Dense output: y0, then its coefficients.
    pub(super) dense: [V; DENSE],
    pub(super) ready: Ready,
    /// Number of evaluations outside of attempts.
    pub(crate) evaluations: u64,
    /// The linear equations of a Rosenbrock method.
    pub(crate) shifted: Option<Shifted<'m>>,
    /// The steps of a method of one's own.
    pub(crate) own: Option<OwnStep<'m>>,
}

impl<V: Vector> fmt::Debug for Engine<'_, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Engine").finish_non_exhaustive()
    }
}

/// The length of a step and its two error estimates.
#[derive(Clone, Copy, Default)]
pub(crate) struct Estimates {
    /// Length of the step.
    pub(crate) h: f64,
    /// Norms of the estimates, in units of the tolerance `[1]`.
    pub(crate) norms: [f64; 2],
}

/// Largest change of the velocities within the time from a crossing to where it is certainly behind its edge,
/// as a share of them `[1]`.
const BESIDE: f64 = 1e-6;

/// Which results of the current step are computed.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Ready {
    /// The derivative in slot `END`.
    pub(crate) end: bool,
    /// The dense coefficients.
    pub(super) dense: bool,
}

impl<'m, V: Vector> Engine<'m, V> {
    pub(crate) fn new<T: Tableau>(model: &'m dyn Model, start: &State) -> Self {
        let m = 2 * model.dof();
        Engine {
            ends: Ends::new(model, start, T::NODES.len(), if T::ADAPTIVE { 1 } else { V::AHEAD }),
            k: std::array::from_fn(|s| V::slot(if s < T::SLOTS { m } else { 0 })),
            on_fixed_pieces: false,
            rtol: 0.0,
            estimates: Estimates::default(),
            before: None,
            dense: std::array::from_fn(|c| V::zeros(if c <= T::DENSE { m } else { 0 })),
            ready: Ready { end: false, dense: false },
            evaluations: 0,
            shifted: T::IMPLICIT.map(|gamma| Shifted::new(model, gamma, T::NODES)),
            own: None,
        }
    }

    /// Sets the end of the current step.
    #[inline(always)]
    pub(crate) fn aim(&mut self, t1: f64) {
        self.ends.aim(t1);
        self.ready = Ready { end: false, dense: false };
    }

    /// Evaluates the drives at all nodes of the step, unless they are known.
    #[inline(always)]
    pub(crate) fn drive_nodes<T: Tableau>(&mut self) {
        let Ends { model, nodes, t, t1, edges, .. } = &mut self.ends;
        let (mut times, n) = ([*t1; SLOTS], T::NODES.len());
        nodes_of::<T>(*t, *t1, &mut times);
        let times = &times[..n];
        let rows = if T::ADAPTIVE || V::AHEAD == 1 {
            nodes.rows_mut()
        } else if !nodes.select(times) {
            nodes.fill(times)
        } else {
            return;
        };
        redrive_between(*model, [*t, *t1], times, *edges, rows);
    }

    /// Evaluates the drives of this step and of the fixed steps after it at once, unless they are known. Step
    /// i of them ends at `end(i)`. `stop`: the next drive edge or the end of the run. No drive is evaluated
    /// there or later.
    #[inline(always)]
    pub(crate) fn drive_ahead<T: Tableau>(&mut self, end: impl Fn(usize) -> f64, stop: f64) {
        let Ends { model, nodes, t, t1, edges, .. } = &mut self.ends;
        if V::AHEAD == 1 || nodes.has_next() || *t1 != end(0) || end(V::AHEAD - 1) >= stop {
            return;
        }
        let (mut times, n) = ([0.0; 4 * SLOTS], T::NODES.len());
        let times = &mut times[..V::AHEAD * n];
        let mut start = *t;
        for (step, times) in times.chunks_exact_mut(n).enumerate() {
            nodes_of::<T>(start, end(step), times);
            start = end(step);
        }
        redrive_between(*model, [*t, start], times, *edges, nodes.fill(times));
    }

    /// k_s = f(y + h Σ a_l k_l), with the drives `u_stage`.
    #[inline(always)]
    pub(crate) fn stage<const FIXED: bool, const L: usize>(&mut self, s: usize, row: &TableauRow<L>) {
        // A reference to the model would be a model of its own, which calls this one.
        let Ends { ref pieces, ref u_stage, ref y, model, h, .. } = self.ends;
        V::stage(&mut self.k, s, y, h, row, Algebra::of::<FIXED>(model, pieces, u_stage));
    }

    /// k_s = f(y + h Σ a_l k_l), with the drives at a node.
    #[inline(always)]
    pub(crate) fn stage_at<const FIXED: bool, const L: usize>(
        &mut self,
        node: usize,
        s: usize,
        row: &TableauRow<L>,
    ) {
        let Ends { ref pieces, ref nodes, ref y, model, h, .. } = self.ends;
        V::stage(&mut self.k, s, y, h, row, Algebra::of::<FIXED>(model, pieces, nodes.at(node)));
    }

    /// y1 = y + h Σ b_l k_l.
    #[inline(always)]
    pub(crate) fn advance<const L: usize>(&mut self, row: &TableauRow<L>) {
        V::combine(&mut self.ends.y1, &self.ends.y, &self.k, self.ends.h, row);
    }

    /// Computes f(t1, y1) in slot `END`, unless it is computed already.
    #[inline(always)]
    pub(crate) fn derivative_at_end_of<T: Tableau>(&mut self) {
        if !self.ready.end {
            let k = &mut self.k[T::END];
            if self.on_fixed_pieces {
                derivative_at_end::<V, true>(&self.ends, k);
            } else {
                derivative_at_end::<V, false>(&self.ends, k);
            }
            self.evaluations += 1;
            self.ready.end = true;
        }
    }

    /// Computes the stages and the end of one step. Does not count its evaluations.
    // A build without optimisation compiles it once instead of inlining it, to save build time.
    #[cfg_attr(debug_assertions, inline(never))]
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(crate) fn attempt<T: Tableau, const LOCATE: bool>(&mut self) {
        if LOCATE && self.on_fixed_pieces {
            T::attempt::<V, true>(self)
        } else {
            T::attempt::<V, false>(self)
        }
    }

    /// Computes f(t, y) in slot 0, with the drives after a jump at t.
    #[inline(always)]
    pub(crate) fn derivative_at_start(&mut self) {
        let side = side_of(self.ends.t, self.ends.edges);
        let Ends { model, pieces, u_stage, y, t, .. } = &mut self.ends;
        model.redrive(&[*t], side, u_stage);
        let pieces = self.on_fixed_pieces.then_some(&pieces[..]);
        V::derivative(&mut self.k[0], y, Algebra { model: *model, pieces, u: u_stage });
        self.evaluations += 1;
    }

    /// Computes the [derivative at the start](Engine::derivative_at_start) of a step that begins at a
    /// crossing. `behind`: the time after the crossing at which it is computed; negative: before it. Without
    /// fixed pieces the crossing may have been located a little before its edge. The force there is that of
    /// the old piece.
    pub(crate) fn derivative_behind(&mut self, behind: f64) {
        self.derivative_at_start();
        let largest = |part: &[f64]| part.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let (v, a) = self.k[0].slice().split_at(self.ends.model.dof());
        // At a grazing it would be a time in which the motion changes.
        if behind != 0.0 && behind.abs() * largest(a) <= BESIDE * largest(v) {
            let Ends { model, u_stage, y, look, .. } = &mut self.ends;
            let moved = y.slice().iter().zip(self.k[0].slice()).map(|(y, k)| y + behind * k);
            look.slice_mut().iter_mut().zip(moved).for_each(|(look, y)| *look = y);
            V::derivative(&mut self.k[0], look, Algebra { model: *model, pieces: None, u: u_stage });
            self.evaluations += 1;
        }
    }

    /// Computes in slot 1 the derivative at the end of an Euler step, for the first step size.
    pub(crate) fn euler(&mut self) {
        self.ends.drive(1.0);
        self.stage::<false, 1>(1, &[(0, 1.0)]);
        self.evaluations += 1;
    }

    /// Makes the end of the step the start of the next one, with the derivative there. The trajectory must be
    /// smooth at this instant: slot 0 is the derivative at the end of the step.
    #[inline(always)]
    pub(crate) fn accept<T: Tableau, const LOCATE: bool>(&mut self) {
        if self.ready.end {
            let (first, rest) = self.k.split_at_mut(1);
            V::hand_over(&mut rest[T::END - 1], &mut first[0]);
        } else {
            if LOCATE && self.on_fixed_pieces {
                derivative_at_end::<V, true>(&self.ends, &mut self.k[0]);
            } else {
                derivative_at_end::<V, false>(&self.ends, &mut self.k[0]);
            }
            self.evaluations += 1;
        }
        self.ends.move_on();
    }

    /// h √(Σ_j (Σ_l e_l k_lj/size_j)²/m), size_j = atol_j + rtol max(|y_j|, |y1_j|), for each row e: root
    /// mean square over the m components, in units of the tolerances.
    #[inline(always)]
    pub(crate) fn norms<const L: usize, const R: usize>(&self, rows: [&TableauRow<L>; R]) -> [f64; R] {
        let Ends { h, y, y1, .. } = &self.ends;
        let m = y.slice().len() as f64;
        V::squares([y, y1], &self.k, &self.ends.atol, self.rtol, rows).map(|sum| h * (sum / m).sqrt())
    }
}

/// Updates the drives at instants from `first` to `last`, between two drive edges.
#[inline(always)]
fn redrive_between(
    model: &dyn Model,
    [first, last]: [f64; 2],
    times: &[f64],
    edges: [f64; 2],
    rows: &mut [f64],
) {
    let side = side_of(first, edges);
    if side == side_of(last, edges) {
        model.redrive(times, side, rows);
    } else {
        redrive_each(model, times, edges, rows);
    }
}

#[cold]
fn redrive_each(model: &dyn Model, times: &[f64], edges: [f64; 2], rows: &mut [f64]) {
    each_row(model.drives(), times, rows, |t, u| model.redrive(&[t], side_of(t, edges), u));
}

/// Writes the instants of the nodes of a step.
#[inline(always)]
fn nodes_of<T: Tableau>(start: f64, end: f64, times: &mut [f64]) {
    let h = end - start;
    let inner = T::NODES.len() - 1;
    for (time, c) in times.iter_mut().zip(&T::NODES[..inner]) {
        *time = start + c * h;
    }
    times[inner] = end;
}

/// The derivative at the end of the step, before a jump of the drives there.
#[inline(always)]
fn derivative_at_end<V: Vector, const FIXED: bool>(ends: &Ends<'_, V>, out: &mut V) {
    V::derivative(out, &ends.y1, Algebra::of::<FIXED>(ends.model, &ends.pieces, ends.nodes.end()));
}
