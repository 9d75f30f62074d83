//! Runs of the tangent flow. A run is interrupted where the differences jump or outgrow their tolerances.

use crate::excitation::Side;
use crate::model::structure::resting::rests_on_kink;
use crate::model::{Model, State};
use crate::ode::budget::Meter;
use crate::ode::{IntegrateError, Observer, Step};
use crate::periodic::flow::flow_method::{Accuracy, Expansion};
use crate::periodic::flow::jumps::Jumps;
use crate::periodic::flow::saltation::Saltation;
use crate::periodic::flow::tangent::Tangent;
use crate::periodic::flow::walk::{NONE, finest};
use std::ops::ControlFlow;

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

/// Reason for an interruption of a run.
#[derive(Clone, Copy)]
pub(crate) enum Stop {
    /// The differences jump.
    Jump,
    /// An acceleration jumps where the model states no edge.
    WithoutEdge(usize),
    /// A difference exceeds the size for which its tolerance is valid.
    Growth,
    /// The budget is spent.
    Budget,
}

/// Observer that interrupts a run for one of the reasons of [`Stop`].
pub(crate) struct Interrupter<'t, 'w, 'm> {
    pub(crate) tangent: &'t Tangent<'m>,
    pub(crate) watch: Option<&'w mut dyn Observer>,
    pub(crate) meter: &'t Meter<'t>,
    pub(crate) saltation: Saltation<'t>,
    /// `None` for Taylor series: algebra that jumps has none.
    pub(crate) jumps: Option<Jumps<'t>>,
    /// Sizes of the differences up to which the tolerances are valid; empty: all sizes.
    pub(crate) serves: Vec<f64>,
    pub(crate) stop: Stop,
    /// Length of the last step.
    pub(crate) step: f64,
}

impl Observer for Interrupter<'_, '_, '_> {
    fn step(&mut self, step: &mut Step<'_>) -> ControlFlow<()> {
        if let Some(watch) = &mut self.watch {
            let _ = watch.step(step);
        }
        if self.meter.spend().is_err() {
            self.stop = Stop::Budget;
            return ControlFlow::Break(());
        }
        if let Some(acceleration) = self.jumps.as_mut().and_then(|jumps| jumps.over(step)) {
            self.stop = Stop::WithoutEdge(acceleration);
            return ControlFlow::Break(());
        }
        if self.saltation.changes(step) {
            self.stop = Stop::Jump;
            return ControlFlow::Break(());
        }
        let grown = |(k, serves): (usize, &f64)| self.tangent.size(k, step.q1(), step.v1()) > *serves;
        if self.serves.iter().enumerate().any(grown) {
            (self.stop, self.step) = (Stop::Growth, step.t1() - step.t0());
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}

impl Tangent<'_> {
    /// Absolute tolerances from the tolerance of the motion, as a share of `scale` but not below rounding.
    /// The tolerance of the differences is ten times larger, relative to their sizes.
    fn tolerances(&self, tolerance: f64, start: &State, sizes: &[f64]) -> Vec<f64> {
        // The error norm is a mean over all components. The factor prevents small errors of the differences
        // from hiding an error of the motion.
        let share = tolerance / (1.0 + self.columns as f64).sqrt();
        // The differences cannot be more accurate than their slopes.
        let columns = (COLUMNS * tolerance).max(self.slopes.borrow().noise());
        let mut atol = Vec::with_capacity(2 * self.n * (1 + self.columns));
        let (q, v) = self.scale.split_at(self.n);
        for (values, scale) in [(&start.q, q), (&start.v, v)] {
            atol.extend(values.iter().zip(scale).map(|(y, s)| finest(share * s, *y)));
            sizes.iter().for_each(|size| atol.extend(scale.iter().map(|s| columns * size * s)));
        }
        atol
    }

    /// Absolute tolerances for differences of size 1. They depend on the state: they are not below the
    /// rounding error of the motion.
    pub(crate) fn fixed_tolerances(&self, tolerance: f64, start: &State) -> Vec<f64> {
        self.tolerances(tolerance, start, &vec![1.0; self.columns])
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
        let atol = self.fixed_tolerances(tolerance, &start);
        self.follow(start, t_end, meter, None, &mut |_| (atol.clone(), Vec::new()))
    }

    /// Runs to `t_end` with tolerances that grow with the differences: their rounding errors grow too and
    /// would exceed a fixed tolerance. `watch` observes the motion and its differences. An error if the
    /// budget is spent.
    pub(crate) fn flow(
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
        meter.left().map_err(|exhausted| IntegrateError::Exhausted { t: state.t, exhausted })?;
        Ok((state, crossings))
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
        let rests = self.rests_at(&start);
        let (mut state, mut crossings, mut step) = (start, 0, 0.0);
        let mut interrupter = Interrupter {
            tangent: self,
            meter,
            watch,
            saltation: Saltation::new(self),
            jumps: match self.expansion {
                Expansion::Series(_) => None,
                Expansion::Dop853 | Expansion::Own(_) => Some(Jumps::new(&self.model)),
            },
            serves: Vec::new(),
            stop: Stop::Jump,
            step,
        };
        interrupter.saltation.begin(&mut state);
        if let Some(refused) = interrupter.saltation.refused {
            return Err(refused);
        }
        for _ in 0..RESTARTS {
            let (atol, serves) = choose(&state);
            interrupter.serves = serves;
            let accuracy = Accuracy { rtol: NONE, atol: &atol, order: self.order, first: step };
            let finish = self
                .expansion
                .run(&accuracy, self, &state, t_end, &mut interrupter)
                .map_err(|error| self.explain(error))?;
            crossings += finish.stats.crossings;
            state = finish.state;
            match interrupter.stop {
                Stop::Jump if finish.stopped => {
                    state.q.copy_from_slice(interrupter.saltation.coordinates());
                    state.v.copy_from_slice(interrupter.saltation.velocities());
                }
                Stop::Budget => return Ok((state, crossings)),
                Stop::WithoutEdge(acceleration) => {
                    return Err(IntegrateError::JumpWithoutEdge { t: state.t, acceleration });
                }
                _ => {}
            }
            if let Some(refused) = interrupter.saltation.refused {
                return Err(refused);
            }
            if state.t >= t_end {
                self.leaves_rest(rests, &state)?;
                return Ok((state, crossings));
            }
            step = match interrupter.stop {
                Stop::Growth => interrupter.step.min(t_end - state.t),
                _ => 0.0,
            };
        }
        Err(IntegrateError::TooManySteps { t: state.t, limit: RESTARTS })
    }

    /// The first contact that rests in a state on an edge at which its stiffness or damping jumps, and the
    /// time of the state.
    pub(crate) fn rests_at(&self, state: &State) -> Option<(usize, f64)> {
        self.rests_on_kink(state).map(|contact| (contact, state.t))
    }

    /// Refuses the derivative of a motion in which a contact rests on an edge from start to end. `rested`:
    /// the contact that rested at the start, and the time of the start.
    ///
    /// # Errors
    /// [`IntegrateError::RestsOnEdge`].
    pub(crate) fn leaves_rest(
        &self,
        rested: Option<(usize, f64)>,
        end: &State,
    ) -> Result<(), IntegrateError> {
        match rested {
            Some((contact, t)) if self.rests_on_kink(end) == Some(contact) => {
                Err(IntegrateError::RestsOnEdge { t, contact })
            }
            _ => Ok(()),
        }
    }

    fn rests_on_kink(&self, state: &State) -> Option<usize> {
        let (q, v) = (&state.q[..self.n], &state.v[..self.n]);
        let (u, contacts) = &mut *self.at_rest.borrow_mut();
        self.model.drive(state.t, Side::After, u);
        self.model.contact(u, q, v, contacts);
        rests_on_kink(&self.model, &mut self.slopes.borrow_mut(), contacts, u, q, v)
    }

    /// Names the cause where it lies in the differences and not in the motion: slopes that are not finite,
    /// that jump, or that are lost in rounding.
    fn explain(&self, error: IntegrateError) -> IntegrateError {
        if let IntegrateError::Discontinuity { t, acceleration: row }
        | IntegrateError::BelowRounding { t, velocity: row, .. } = error
            && row >= self.n
        {
            return IntegrateError::DerivativeNotResolved { t, acceleration: row % self.n };
        }
        // The time, and whether an entry of the differences is not finite.
        let failed = match error {
            IntegrateError::NotFinite { t, component } => {
                Some((t, component % (self.n * (1 + self.columns)) >= self.n))
            }
            IntegrateError::NotANumber { t, acceleration } => Some((t, acceleration >= self.n)),
            _ => None,
        };
        match (failed, self.slopes.borrow().jacobian.not_finite()) {
            (Some((t, true)), Some((acceleration, coordinate, velocity))) => IntegrateError::Slope {
                t,
                acceleration,
                of: if velocity { "velocity" } else { "coordinate" },
                coordinate,
            },
            _ => error,
        }
    }
}
