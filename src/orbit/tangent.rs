//! A model together with small differences of its motion: the variational equations as a model of their own.

use crate::budget::Meter;
use crate::model::{Contact, Model, State};
use crate::ode::{Dop853, IntegrateError, Integrator, Observer, Step};
use crate::piece::{Piece, Side};
use crate::slopes::{Slopes, accelerate};
use std::cell::RefCell;
use std::ops::ControlFlow;

/// δq'' = ∂a/∂q δq + ∂a/∂v δv beside q'' = a(u, q, q'), for any number of differences; the contacts are those of the bare model.
///
/// Coordinates (q, δq_1, δq_2, ...), velocities likewise. Jacobians are the model's own, of the pieces held; central differences where it
/// has none.
pub(crate) struct Tangent<'m, M: ?Sized> {
    model: &'m M,
    n: usize,
    columns: usize,
    /// Sizes of coordinates and velocities.
    scale: &'m [f64],
    slopes: RefCell<Slopes<'m, M>>,
}

/// Differences are held to the tolerance of the motion times this.
const COLUMNS: f64 = 10.0;
/// Restarts at jumps of the force before a run is given up.
const RESTARTS: usize = 1_000_000;
/// A relative tolerance that leaves the absolute ones alone.
pub(crate) const NONE: f64 = 1e-300;

/// An absolute tolerance, no finer than the rounding of the value itself.
pub(crate) fn finest(tolerance: f64, value: f64) -> f64 {
    tolerance.max(4.0 * f64::EPSILON * value.abs())
}

/// A jump that changes the differences by less than this share is left out.
const NEGLIGIBLE: f64 = 1e-10;

impl<'m, M: Model + ?Sized> Tangent<'m, M> {
    pub(crate) fn new(model: &'m M, columns: usize, scale: &'m [f64], tolerance: f64) -> Self {
        let n = model.dof();
        Tangent { model, n, columns, scale, slopes: RefCell::new(Slopes::new(model, scale.to_vec(), tolerance)) }
    }

    /// The motion held to `tolerance` of its size, or to rounding; the differences ten times looser.
    pub(crate) fn solver(&self, tolerance: f64, start: &State) -> Dop853 {
        // The norm is a mean over all components: differences must not hide an error of the motion.
        let share = tolerance / (1.0 + self.columns as f64).sqrt();
        let half = |values: &[f64], scale: &[f64]| -> Vec<f64> {
            let motion = values.iter().zip(scale).map(|(y, s)| finest(share * s, *y));
            motion.chain((0..self.columns).flat_map(|_| scale.iter().map(|s| COLUMNS * tolerance * s))).collect()
        };
        let (q, v) = self.scale.split_at(self.n);
        Dop853::new().rtol(NONE).atol_each(&[half(&start.q, q), half(&start.v, v)].concat())
    }

    /// A state with difference k equal to the size of component k, in that component alone.
    pub(crate) fn start(&self, state: &State) -> State {
        let (mut q, mut v) = (state.q.clone(), state.v.clone());
        q.resize(self.n * (1 + self.columns), 0.0);
        v.resize(self.n * (1 + self.columns), 0.0);
        for k in 0..self.columns.min(2 * self.n) {
            let column = self.n * (1 + k);
            let half = if k < self.n { &mut q } else { &mut v };
            half[column + k % self.n] = self.scale[k];
        }
        State { t: state.t, q, v }
    }

    /// Component i of difference k, in units of size.
    pub(crate) fn scaled(&self, state: &State, i: usize, k: usize) -> f64 {
        let half = if i < self.n { &state.q } else { &state.v };
        half[self.n * (1 + k) + i % self.n] / self.scale[i]
    }

    /// The motion alone.
    pub(crate) fn motion(&self, state: &State) -> State {
        State::new(state.t, &state.q[..self.n], &state.v[..self.n])
    }

    /// Runs to `t_end`; where a contact force jumps at an edge the differences jump too. Returns the crossings as well.
    pub(crate) fn run(&self, solver: &Dop853, start: State, t_end: f64) -> Result<(State, u64), IntegrateError> {
        self.run_metered(solver, start, t_end, None)
    }

    /// The same, every step taken from a budget: once that is spent, the state reached.
    pub(crate) fn run_metered(
        &self,
        solver: &Dop853,
        start: State,
        t_end: f64,
        meter: Option<&Meter<'_>>,
    ) -> Result<(State, u64), IntegrateError> {
        let (mut state, mut crossings) = (start, 0);
        let mut saltation = Saltation { meter, ..Saltation::new(self) };
        for _ in 0..RESTARTS {
            let finish = solver.run(self, &state, t_end, &mut saltation).map_err(|error| self.explain(error))?;
            crossings += finish.stats.crossings;
            state = finish.state;
            if meter.is_some_and(|meter| meter.exhausted().is_some()) {
                return Ok((state, crossings));
            }
            if finish.stopped {
                state.v.copy_from_slice(&saltation.v);
            }
            if state.t >= t_end {
                return Ok((state, crossings));
            }
        }
        Err(IntegrateError::TooManySteps { t: state.t, limit: RESTARTS })
    }

    /// Differences that are not finite while the motion is come of slopes that are not.
    fn explain(&self, error: IntegrateError) -> IntegrateError {
        match (error, self.slopes.borrow().jacobian.not_finite()) {
            (IntegrateError::NotFinite { t, component }, Some((acceleration, coordinate, velocity)))
                if component % (self.n * (1 + self.columns)) >= self.n =>
            {
                IntegrateError::Slope { t, acceleration, of: if velocity { "velocity" } else { "coordinate" }, coordinate }
            }
            (error, _) => error,
        }
    }

    fn evaluate(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) -> bool {
        let n = self.n;
        let ((q, dq), (v, dv), (a, da)) = (q.split_at(n), v.split_at(n), a.split_at_mut(n));
        if !accelerate(self.model, pieces, u, q, v, a) {
            return false;
        }
        let mut slopes = self.slopes.borrow_mut();
        slopes.at(pieces, u, q, v);
        let (by_q, by_v) = (slopes.jacobian.q.as_slice(), slopes.jacobian.v.as_slice());
        for ((dq, dv), da) in dq.chunks_exact(n).zip(dv.chunks_exact(n)).zip(da.chunks_exact_mut(n)) {
            da.fill(0.0);
            for j in 0..n {
                let (column_q, column_v) = (&by_q[j * n..][..n], &by_v[j * n..][..n]);
                for i in 0..n {
                    da[i] += column_q[i] * dq[j] + column_v[i] * dv[j];
                }
            }
        }
        true
    }
}

impl<M: Model + ?Sized> Model for Tangent<'_, M> {
    fn dof(&self) -> usize {
        self.n * (1 + self.columns)
    }
    #[inline]
    fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.evaluate(None, u, q, v, a);
    }
    fn drives(&self) -> usize {
        self.model.drives()
    }
    #[inline]
    fn drive(&self, t: f64, side: Side, u: &mut [f64]) {
        self.model.drive(t, side, u);
    }
    fn next_edge(&self, t: f64) -> Option<f64> {
        self.model.next_edge(t)
    }
    fn contacts(&self) -> usize {
        self.model.contacts()
    }
    #[inline]
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        self.model.contact(u, &q[..self.n], &v[..self.n], out);
    }
    #[inline]
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) -> bool {
        self.evaluate(Some(pieces), u, q, v, a)
    }
}

/// δ⁺ = δ + (f⁺ - f⁻) (∇h·δ)/h', h the distance past the edge, h' = ∇h·f⁻ + ∂h/∂t its rate: the jump of the differences where the
/// acceleration jumps by f⁺ - f⁻.   Source: Leine & Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, Sect. 7.4.
///
/// A force without a jump leaves them as they are. So does a model that cannot hold its pieces: its force is taken to be continuous.
struct Saltation<'t, M: ?Sized> {
    model: &'t M,
    n: usize,
    scale: &'t [f64],
    u: Vec<f64>,
    pieces: Vec<Piece>,
    contacts: Vec<Contact>,
    gradient: Vec<f64>,
    on_edge: Vec<f64>,
    before: Vec<f64>,
    jump: Vec<f64>,
    moved: Vec<f64>,
    /// Velocities of the motion and its differences behind the edges.
    v: Vec<f64>,
    meter: Option<&'t Meter<'t>>,
}

impl<'t, M: Model + ?Sized> Saltation<'t, M> {
    fn new(tangent: &'t Tangent<'_, M>) -> Self {
        let (model, n) = (tangent.model, tangent.n);
        Saltation {
            model,
            n,
            scale: tangent.scale,
            u: vec![0.0; model.drives()],
            pieces: vec![Piece::Gap; model.contacts()],
            contacts: vec![Contact::default(); model.contacts()],
            gradient: vec![0.0; n],
            on_edge: vec![0.0; n],
            before: vec![0.0; n],
            jump: vec![0.0; n],
            moved: vec![0.0; n],
            v: vec![0.0; n * (1 + tangent.columns)],
            meter: None,
        }
    }

    /// ∂d/∂q of a contact. d' is linear in the velocities with these very coefficients, so the differences are exact.
    fn gradient(&mut self, contact: usize, q: &[f64]) {
        self.moved.copy_from_slice(&self.v[..self.n]);
        for j in 0..self.n {
            let here = self.moved[j];
            let mut rate = [0.0; 2];
            for (rate, side) in rate.iter_mut().zip([1.0, -1.0]) {
                self.moved[j] = here + side * self.scale[self.n + j];
                self.model.contact(&self.u, q, &self.moved, &mut self.contacts);
                *rate = self.contacts[contact].rate;
            }
            self.moved[j] = here;
            self.gradient[j] = (rate[0] - rate[1]) / (2.0 * self.scale[self.n + j]);
        }
    }

    /// The coordinates moved by the little that the edge was missed by, so that a continuous force shows no jump.
    fn move_onto(&mut self, missed: f64, q: &[f64]) {
        let square: f64 = self.gradient.iter().zip(self.scale).map(|(g, s)| (g * s) * (g * s)).sum();
        let part = if square > 0.0 { missed / square } else { 0.0 };
        for ((on_edge, q), (g, s)) in self.on_edge.iter_mut().zip(q).zip(self.gradient.iter().zip(self.scale)) {
            *on_edge = q - part * g * s * s;
        }
    }

    /// One contact changes its piece. Whether the differences changed.
    fn cross(&mut self, contact: usize, to: Piece, q: &[f64], dq: &[f64]) -> bool {
        let n = self.n;
        self.model.contact(&self.u, q, &self.v[..n], &mut self.contacts);
        let c = self.contacts[contact];
        // Without a gap the far flank is met at the same instant.
        let to = match (self.pieces[contact], to) {
            (Piece::Lower, Piece::Gap) if c.upper <= c.lower => Piece::Upper,
            (Piece::Upper, Piece::Gap) if c.upper <= c.lower => Piece::Lower,
            _ => to,
        };
        let lower = self.pieces[contact] == Piece::Lower || to == Piece::Lower;
        let (edge, edge_rate) = if lower { (c.lower, c.lower_rate) } else { (c.upper, c.upper_rate) };
        let rate = c.rate - edge_rate;
        self.gradient(contact, q);
        self.move_onto(c.deflection - edge, q);
        let known = self.model.accel_on_pieces(&self.pieces, &self.u, &self.on_edge, &self.v[..n], &mut self.before);
        self.pieces[contact] = to;
        let known = known && self.model.accel_on_pieces(&self.pieces, &self.u, &self.on_edge, &self.v[..n], &mut self.jump);
        if !known || rate == 0.0 {
            return false;
        }
        self.jump.iter_mut().zip(&self.before).for_each(|(jump, before)| *jump -= before);
        let (dv, mut changed) = (&mut self.v[n..], false);
        let largest = |x: &[f64], scale: &[f64]| x.iter().zip(scale).fold(0.0, |m: f64, (x, s)| m.max((x / s).abs()));
        let (of_q, of_v) = self.scale.split_at(n);
        let jump = largest(&self.jump, of_v);
        for (dq, dv) in dq.chunks_exact(n).zip(dv.chunks_exact_mut(n)) {
            let share = crate::root::dot(&self.gradient, dq) / rate;
            changed |= (share * jump).abs() > NEGLIGIBLE * largest(dq, of_q).max(largest(dv, of_v));
            dv.iter_mut().zip(&self.jump).for_each(|(dv, jump)| *dv += jump * share);
        }
        changed
    }
}

impl<M: Model + ?Sized> Observer for Saltation<'_, M> {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        if self.meter.is_some_and(|meter| meter.spend().is_err()) {
            return ControlFlow::Break(());
        }
        let Some(pieces) = step.pieces().filter(|_| !step.crossings().is_empty()) else {
            return ControlFlow::Continue(());
        };
        self.pieces.copy_from_slice(pieces);
        self.model.drive(step.t1(), Side::Before, &mut self.u);
        let (q, dq) = step.q1().split_at(self.n);
        self.v.copy_from_slice(step.v1());
        let mut changed = false;
        for crossing in step.crossings() {
            changed |= self.cross(crossing.contact, crossing.to, q, dq);
        }
        if changed { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
