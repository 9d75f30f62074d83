//! Running a model until it repeats.

use crate::analysis::returns::{Ranges, is_own_multiple};
use crate::model::equations::{Periodic, State};
use crate::model::rigid::rigid_modes;
use crate::ode::budget::Budget;
use crate::ode::error::IntegrateError;
use crate::ode::integrator::Integrator;
use crate::ode::step::{Observer, Step};
use thiserror::Error;

/// Integrates period by period until the state repeats after p of them, p as small as possible.
///
/// A model that turns freely repeats in its relative motion: rigid motion counts neither in a return nor in a range.
///
/// ```
/// use gear_dynamics::{Dop853, NfgPair, NfgParams, Settle};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let steady = Settle::new().tolerance(1e-7).run(&Dop853::new(), &pair, &pair.static_start()?)?;
/// assert_eq!(steady.period_multiple, 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Settle {
    tolerance: f64,
    max_periods: usize,
    max_multiple: usize,
    budget: Budget,
}

impl Default for Settle {
    fn default() -> Self {
        Settle::new()
    }
}

impl Settle {
    /// To 1e-9 of the range of motion, within 200 periods, orbits up to 8 periods long, within the default [`Budget`].
    pub fn new() -> Self {
        Settle { tolerance: 1e-9, max_periods: 200, max_multiple: 8, budget: Budget::new() }
    }
    /// How closely a state must repeat, as a share of the range of each coordinate and velocity; positive.
    pub fn tolerance(self, tolerance: f64) -> Self {
        Settle { tolerance, ..self }
    }
    /// After how many periods to give up.
    pub fn max_periods(self, max_periods: usize) -> Self {
        Settle { max_periods, ..self }
    }
    /// The longest orbit looked for, in periods.
    pub fn max_multiple(self, max_multiple: usize) -> Self {
        Settle { max_multiple, ..self }
    }
    /// The most steps and time of a run, all periods together.
    pub fn budget(self, budget: Budget) -> Self {
        Settle { budget, ..self }
    }

    /// Runs from `start`.
    ///
    /// # Errors
    /// [`Unsettled::Aperiodic`] with the state reached, when nothing repeats in time: chaos, quasi-periodicity, or slow decay;
    /// [`Unsettled::Failed`] when a run does, or when the budget is spent.
    pub fn run<I: Integrator, M: Periodic + ?Sized>(
        &self,
        integrator: &I,
        model: &M,
        start: &State,
    ) -> Result<Steady, Unsettled> {
        let within = |name, value: f64, range: bool, allowed| {
            let error = IntegrateError::Setting { name, value, allowed };
            if range { Ok(()) } else { Err(Unsettled::Failed { error, state: start.clone(), periods: 0 }) }
        };
        within(
            "tolerance",
            self.tolerance,
            self.tolerance > 0.0 && self.tolerance < 1.0,
            "above 0 and below 1",
        )?;
        let multiple = self.max_multiple;
        within("max_multiple", multiple as f64, (1..=LONGEST).contains(&multiple), "1 to 65536 periods")?;
        let period = model.period();
        within("period of the model", period, (1e-50..=1e50).contains(&period), "in [1e-50, 1e50]")?;
        let joined = |state: &State| [&state.q[..], &state.v].concat();
        let mut section: Vec<Vec<f64>> = vec![joined(start)];
        let mut last = start.clone();
        // One coordinate alone has no relative motion.
        let mut ranges =
            Ranges::new(model.dof(), if model.dof() > 1 { rigid_modes(model, period) } else { Vec::new() });
        // How many periods in a row each multiple has repeated.
        let mut repeated = vec![0; self.max_multiple];
        let mut changes = vec![f64::INFINITY; self.max_multiple];
        let mut closest = f64::INFINITY;
        let meter = self.budget.begin();
        for k in 1..=self.max_periods {
            // Earlier ranges fade by half each period, so that transients are forgotten.
            ranges.fade();
            let mut watch = |step: &mut Step<'_>| {
                ranges.see(step.y1());
                (&meter).step(step)
            };
            let finish = integrator.run(model, &last, start.t + k as f64 * period, &mut watch);
            let failed = |error, state| Unsettled::Failed { error, state, periods: k - 1 };
            let state = match finish {
                Ok(finish) => finish.state,
                Err(error) => return Err(failed(error, last)),
            };
            if let Some(exhausted) = meter.exhausted() {
                return Err(failed(IntegrateError::Budget { t: state.t, exhausted }, last));
            }
            last = state;
            section.push(joined(&last));
            for p in 1..=self.max_multiple.min(k) {
                let change = ranges.distance(&section[k], &section[k - p], self.tolerance);
                changes[p - 1] = change;
                if p == 1 || change < closest {
                    closest = change;
                }
                repeated[p - 1] = if change <= self.tolerance && is_own_multiple(&changes[..p]) {
                    repeated[p - 1] + 1
                } else {
                    0
                };
                if repeated[p - 1] > p {
                    return Ok(Steady { state: last, period_multiple: p, periods: k, change });
                }
            }
        }
        Err(Unsettled::Aperiodic {
            state: last,
            periods: self.max_periods,
            closest,
            multiple: self.max_multiple,
        })
    }
}

/// The longest orbit that can be looked for, in periods.
const LONGEST: usize = 1 << 16;

/// A settled orbit.
///
/// ```
/// let state = gear_dynamics::State::at_rest(1);
/// let steady = gear_dynamics::analysis::Steady { state, period_multiple: 2, periods: 30, change: 1e-10 };
/// assert_eq!(steady.period_multiple, 2);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Steady {
    /// A state on the orbit, a whole number of periods after the start.
    pub state: State,
    /// Periods of the drives in one period of the orbit.
    pub period_multiple: usize,
    /// Periods it took.
    pub periods: usize,
    /// How far the last repetition was off, as a share of the range of motion; 0 if by rounding only, below the tolerance that was asked for.
    pub change: f64,
}

/// Why no settled orbit is returned.
///
/// ```
/// use gear_dynamics::{Dop853, NfgPair, NfgParams, Settle, analysis::Unsettled};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let unsettled = Settle::new().max_periods(1).run(&Dop853::new(), &pair, &pair.static_start()?).unwrap_err();
/// assert!(matches!(unsettled, Unsettled::Aperiodic { periods: 1, .. }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Unsettled {
    /// Nothing repeated.
    #[error(
        "no orbit of up to {multiple} periods repeats within {periods} periods: the closest return is {closest:.1e} of the range of motion, \
         more than the tolerance asks; the tolerance of the solver bounds it from below"
    )]
    Aperiodic {
        /// The last state, from which statistics can be taken.
        state: State,
        /// Periods run.
        periods: usize,
        /// The closest return of the last period.
        closest: f64,
        /// The longest orbit looked for.
        multiple: usize,
    },
    /// The integration ended early.
    #[error("after {periods} periods: {error}")]
    Failed {
        /// Why.
        error: IntegrateError,
        /// The last state of the section.
        state: State,
        /// Whole periods before it.
        periods: usize,
    },
}

impl Unsettled {
    /// The last state reached.
    pub fn state(&self) -> &State {
        match self {
            Unsettled::Aperiodic { state, .. } | Unsettled::Failed { state, .. } => state,
        }
    }
}
