//! The variational equations as a model: a model together with small differences of its motion.

use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::model::drive_slope::DriveSlope;
use crate::model::equations::Model;
use crate::model::expansion::expand::{Expand, Recorded};
use crate::model::offers::Offers;
use crate::model::slopes::{Slopes, accelerate};
use crate::model::state::State;
use crate::ode::budget::Meter;
use crate::ode::integrate_error::IntegrateError;
use crate::ode::integrator::Integrator;
use crate::ode::methods::dop853::Dop853;
use crate::ode::outcome::Finish;
use crate::ode::step::Observer;
use crate::ode::taylor::settings::Taylor;
use crate::periodic::flow::continued::Continued;
use crate::periodic::flow::flow_method::Expansion;
use crate::periodic::flow::interrupter::{Interrupter, Stop};
use crate::periodic::flow::saltation::Saltation;
use crate::periodic::flow::tangent_tape::tangent;
use crate::series::Series;
use crate::tape::recording::Recording;
use std::cell::RefCell;

/// q'' = a(u, q, q') together with δq'' = ∂a/∂q δq + ∂a/∂v δv, for any number of differences.
///
/// The last differences are those with respect to parameters, at a fixed phase (see
/// [`tangent`](crate::periodic::flow::tangent_tape::tangent)). The coordinates are (q, δq_1, δq_2, ...); the velocities have
/// the same order. The contacts are those of the model alone. The Jacobian is that of the model on fixed pieces, or central differences if the model
/// has none.
pub(crate) struct Tangent<'m, M: ?Sized> {
    pub(crate) model: Continued<'m, M>,
    pub(crate) n: usize,
    /// Number of all differences.
    pub(crate) columns: usize,
    /// Slopes of the drives with respect to the parameters of the last differences.
    pub(crate) forced: &'m [DriveSlope],
    /// Sizes of coordinates and velocities.
    pub(crate) scale: &'m [f64],
    slopes: RefCell<Slopes<'m, M>>,
    expansion: &'m Expansion,
    /// Order of the Taylor series.
    order: usize,
}

/// Tolerance of the differences over the tolerance of the motion `[1]`. The noise of the slopes replaces it
/// where that is larger.
const COLUMNS: f64 = 10.0;

/// Returns the absolute tolerances for a state, and the sizes of the differences up to which they are valid
/// (empty: all sizes).
type Choose<'c> = dyn FnMut(&State) -> (Vec<f64>, Vec<f64>) + 'c;

/// Growth of a difference after which its tolerance is adapted `[1]`.
const GROWTH: f64 = 10.0;

/// Maximum number of restarts of one run.
const RESTARTS: usize = 1_000_000;

/// Relative tolerance so small that only the absolute tolerances have an effect.
pub(crate) const NONE: f64 = 1e-300;

/// An absolute tolerance, at least four rounding errors of the value.
pub(crate) fn finest(tolerance: f64, value: f64) -> f64 {
    tolerance.max(4.0 * f64::EPSILON * value.abs())
}

impl<'m, M: Model + ?Sized> Tangent<'m, M> {
    pub(crate) fn new(
        model: &'m M,
        columns: usize,
        forced: &'m [DriveSlope],
        scale: &'m [f64],
        tolerance: f64,
        expansion: &'m Expansion,
    ) -> Self {
        let n = model.dof();
        let slopes = RefCell::new(Slopes::new(model, scale.to_vec(), tolerance));
        let order = Taylor::order_for(tolerance);
        let model = Continued::new(model, scale);
        Tangent { model, n, columns, forced, scale, slopes, expansion, order }
    }

    /// Absolute tolerances from the tolerance of the motion, as a share of `scale` but not below rounding.
    /// The tolerance of the differences is ten times larger, relative to their sizes.
    fn tolerances(&self, tolerance: f64, start: &State, sizes: &[f64]) -> Vec<f64> {
        // The error norm is a mean over all components. The factor prevents small errors of the differences
        // from hiding an error of the motion.
        let share = tolerance / (1.0 + self.columns as f64).sqrt();
        // The differences cannot be more accurate than their slopes.
        let columns = (COLUMNS * tolerance).max(self.slopes.borrow().noise());
        let half = |values: &[f64], scale: &[f64]| -> Vec<f64> {
            let motion = values.iter().zip(scale).map(|(y, s)| finest(share * s, *y));
            motion
                .chain(sizes.iter().flat_map(|size| scale.iter().map(move |s| columns * size * s)))
                .collect()
        };
        let (q, v) = self.scale.split_at(self.n);
        [half(&start.q, q), half(&start.v, v)].concat()
    }

    /// Integrates with absolute tolerances. `first`: the first step; 0 if it is free.
    fn integrate(
        &self,
        atol: &[f64],
        first: f64,
        start: &State,
        t_end: f64,
        observer: &mut Interrupter<'_, '_, '_, M>,
    ) -> Result<Finish, IntegrateError> {
        match &self.expansion.0 {
            Some(prepared) => {
                let settings = Taylor::new().rtol(NONE).atol_each(atol).order(self.order);
                prepared.borrow_mut().run(&settings, &self, start, t_end, observer)
            }
            None => {
                let solver = Dop853::new().rtol(NONE).atol_each(atol);
                let solver = if first > 0.0 { solver.first_step(first) } else { solver };
                solver.run(self, start, t_end, observer)
            }
        }
    }

    /// Largest component of difference k, in units of `scale`.
    pub(crate) fn size(&self, k: usize, q: &[f64], v: &[f64]) -> f64 {
        let (of_q, of_v) = self.scale.split_at(self.n);
        let column = self.n * (1 + k);
        let largest = |x: &[f64], scale: &[f64]| {
            x[column..].iter().zip(scale).fold(0.0, |m: f64, (x, s)| m.max((x / s).abs()))
        };
        largest(q, of_q).max(largest(v, of_v))
    }

    /// Start of the motion and its small differences. Components are the n coordinates, then the n
    /// velocities; difference k is `scale[k]` in component k and 0 elsewhere. The start does not depend on a
    /// parameter.
    pub(crate) fn start(&self, state: &State) -> State {
        let (mut q, mut v) = (state.q.clone(), state.v.clone());
        q.resize(self.n * (1 + self.columns), 0.0);
        v.resize(self.n * (1 + self.columns), 0.0);
        let free = self.free();
        for k in 0..free.min(2 * self.n) {
            let column = self.n * (1 + k);
            let half = if k < self.n { &mut q } else { &mut v };
            half[column + k % self.n] = self.scale[k];
        }
        for (k, by) in self.forced.iter().enumerate() {
            let column = self.n * (1 + free + k);
            (0..self.n).for_each(|i| v[column + i] = -by.speed * state.v[i]);
        }
        State { t: state.t, q, v }
    }

    /// Number of differences with respect to the start.
    pub(crate) fn free(&self) -> usize {
        self.columns - self.forced.len()
    }

    /// Component i of difference k, in units of `scale`.
    pub(crate) fn scaled(&self, state: &State, i: usize, k: usize) -> f64 {
        if i < self.n {
            return state.q[self.n * (1 + k) + i] / self.scale[i];
        }
        let turned = self.forced.get(k.wrapping_sub(self.free())).map_or(0.0, |by| by.speed);
        (state.v[self.n * (1 + k) + i - self.n] + turned * state.v[i - self.n]) / self.scale[i]
    }

    /// The motion without its differences.
    pub(crate) fn motion(&self, state: &State) -> State {
        State::new(state.t, &state.q[..self.n], &state.v[..self.n])
    }

    /// Runs to `t_end` with fixed tolerances. Returns the state and the number of crossings. If the budget is
    /// spent, the state is the last one reached.
    pub(crate) fn flow_with_fixed_tolerances(
        &self,
        tolerance: f64,
        start: State,
        t_end: f64,
        meter: &Meter<'_>,
    ) -> Result<(State, u64), IntegrateError> {
        // The tolerances depend on the state: they are not below the rounding error of the motion.
        let atol = self.tolerances(tolerance, &start, &vec![1.0; self.columns]);
        self.follow(start, t_end, meter, None, &mut |_| (atol.clone(), Vec::new()))
    }

    /// Runs to `t_end` with tolerances that grow with the differences: their rounding errors grow too and
    /// would exceed a fixed tolerance. An error if the budget is spent.
    pub(crate) fn flow(
        &self,
        tolerance: f64,
        start: State,
        t_end: f64,
        meter: &Meter<'_>,
    ) -> Result<(State, u64), IntegrateError> {
        self.flow_watched(tolerance, start, t_end, meter, None)
    }

    /// [`flow`](Tangent::flow) with an observer of the motion and its differences.
    pub(crate) fn flow_watched(
        &self,
        tolerance: f64,
        start: State,
        t_end: f64,
        meter: &Meter<'_>,
        watch: Option<&mut dyn Observer>,
    ) -> Result<(State, u64), IntegrateError> {
        let (state, crossings) = self.follow(start, t_end, meter, watch, &mut |state| {
            let sizes: Vec<f64> =
                (0..self.columns).map(|k| self.size(k, &state.q, &state.v).max(1.0)).collect();
            (self.tolerances(tolerance, state, &sizes), sizes.iter().map(|size| GROWTH * size).collect())
        })?;
        match meter.exhausted() {
            Some(exhausted) => Err(IntegrateError::Budget { t: state.t, exhausted }),
            None => Ok((state, crossings)),
        }
    }

    /// Runs to `t_end`. `choose` returns the tolerances at the start and after every interruption.
    fn follow(
        &self,
        start: State,
        t_end: f64,
        meter: &Meter<'_>,
        watch: Option<&mut dyn Observer>,
        choose: &mut Choose<'_>,
    ) -> Result<(State, u64), IntegrateError> {
        let (mut state, mut crossings, mut step) = (start, 0, 0.0);
        let mut interrupter = Interrupter {
            tangent: self,
            meter,
            watch,
            saltation: Saltation::new(self),
            serves: Vec::new(),
            stop: Stop::Jump,
            step,
        };
        interrupter.saltation.begin(&mut state);
        for _ in 0..RESTARTS {
            let (atol, serves) = choose(&state);
            interrupter.serves = serves;
            let finish = self
                .integrate(&atol, step, &state, t_end, &mut interrupter)
                .map_err(|error| self.explain(error))?;
            crossings += finish.stats.crossings;
            state = finish.state;
            match interrupter.stop {
                Stop::Jump if finish.stopped => {
                    state.q.copy_from_slice(interrupter.saltation.coordinates());
                    state.v.copy_from_slice(interrupter.saltation.velocities());
                }
                Stop::Budget => return Ok((state, crossings)),
                _ => {}
            }
            if let Some(contact) = interrupter.saltation.rests {
                return Err(IntegrateError::RestsOnStop { t: state.t, contact });
            }
            if state.t >= t_end {
                return Ok((state, crossings));
            }
            step = match interrupter.stop {
                Stop::Growth => interrupter.step.min(t_end - state.t),
                _ => 0.0,
            };
        }
        Err(IntegrateError::TooManySteps { t: state.t, limit: RESTARTS })
    }

    /// If the differences are not finite but the motion is, the cause is a slope: the error then names it.
    fn explain(&self, error: IntegrateError) -> IntegrateError {
        match (error, self.slopes.borrow().jacobian.not_finite()) {
            (IntegrateError::NotFinite { t, component }, Some((acceleration, coordinate, velocity)))
                if component % (self.n * (1 + self.columns)) >= self.n =>
            {
                IntegrateError::Slope {
                    t,
                    acceleration,
                    of: if velocity { "velocity" } else { "coordinate" },
                    coordinate,
                }
            }
            (error, _) => error,
        }
    }

    /// Writes ∂a/∂u u' for the slope u' of the drives.
    fn along_drives(
        &self,
        by: &DriveSlope,
        pieces: Option<&[Piece]>,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        out: &mut [f64],
    ) {
        match self.model.named_constants() {
            Some(constants) => constants.accel_along(&by.drives, pieces, u, q, v, out),
            None => out.fill(0.0),
        }
    }

    fn evaluate(&self, pieces: Option<&[Piece]>, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        let n = self.n;
        let ((q, dq), (v, dv), (a, da)) = (q.split_at(n), v.split_at(n), a.split_at_mut(n));
        accelerate(&self.model, pieces, u, q, v, a);
        let mut slopes = self.slopes.borrow_mut();
        slopes.read(&self.model, pieces, u, q, v);
        let (by_q, by_v) = (slopes.jacobian.q.as_slice(), slopes.jacobian.v.as_slice());
        let free = self.free();
        for (k, ((dq, dv), da)) in
            dq.chunks_exact(n).zip(dv.chunks_exact(n)).zip(da.chunks_exact_mut(n)).enumerate()
        {
            let turned = match k.checked_sub(free).map(|k| &self.forced[k]) {
                Some(by) => {
                    self.along_drives(by, pieces, u, q, v, da);
                    da.iter_mut().zip(&*a).for_each(|(da, a)| *da -= 2.0 * by.speed * a);
                    by.speed
                }
                None => {
                    da.fill(0.0);
                    0.0
                }
            };
            for j in 0..n {
                let (column_q, column_v) = (&by_q[j * n..][..n], &by_v[j * n..][..n]);
                let dv = dv[j] + turned * v[j];
                for i in 0..n {
                    da[i] += column_q[i] * dq[j] + column_v[i] * dv;
                }
            }
        }
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
    fn base(&self) -> Option<&dyn Model> {
        Some(&self.model)
    }
    fn offers(&self) -> Offers<'_> {
        Offers { jacobian: false, ..self.model.offers() }
    }
    #[inline]
    fn contact(&self, u: &[f64], q: &[f64], v: &[f64], out: &mut [Contact]) {
        self.model.contact(u, &q[..self.n], &v[..self.n], out);
    }
    fn expand(&self) -> Option<&dyn Expand> {
        Some(self)
    }
    /// The impact of the motion alone; [`Saltation`] computes the jump of the differences.
    fn impact(&self, contact: usize, on: Piece, u: &[f64], q: &[f64], v: &mut [f64]) {
        self.model.impact(contact, on, u, &q[..self.n], &mut v[..self.n]);
    }
    #[inline]
    fn accel_on_pieces(&self, pieces: &[Piece], u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
        self.evaluate(Some(pieces), u, q, v, a);
    }
}

impl<M: Model + ?Sized> Expand for Tangent<'_, M> {
    fn record(&self, moving: &dyn Fn(usize) -> bool) -> Recorded {
        match self.model.expand() {
            Some(expanded) => Recorded(tangent(&expanded.record(moving).0, self.columns, self.forced)),
            None => Recorded(Recording::new(self.dof(), self.drives()).finish(Vec::new(), Vec::new())),
        }
    }
    fn drive_series(&self, t: f64, coefficients: usize, u: &mut [Series]) {
        if let Some(expanded) = self.model.expand() {
            expanded.drive_series(t, coefficients, u);
        }
    }
    fn redrive_series(&self, t: f64, coefficients: usize, needed: &[bool], u: &mut [Series]) {
        if let Some(expanded) = self.model.expand() {
            expanded.redrive_series(t, coefficients, needed, u);
        }
    }
}
