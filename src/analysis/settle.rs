//! Running a model until it repeats.

use crate::model::{Periodic, State};
use crate::ode::{IntegrateError, Integrator, Step};
use std::ops::ControlFlow;
use thiserror::Error;

/// Integrates period by period until the state repeats after p of them, p as small as possible.
///
/// ```
/// use gear_dynamics::{Dop853, NfgPair, NfgParams, Settle};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let steady = Settle::new().tolerance(1e-7).run(&Dop853::new(), &pair, &pair.static_start()?)?;
/// assert_eq!(steady.period_multiple, 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settle {
    tolerance: f64,
    most_periods: usize,
    largest_multiple: usize,
}

impl Default for Settle {
    fn default() -> Self {
        Settle::new()
    }
}

impl Settle {
    /// To 1e-9 of the range of motion, within 200 periods, orbits up to 8 periods long.
    pub fn new() -> Self {
        Settle { tolerance: 1e-9, most_periods: 200, largest_multiple: 8 }
    }
    /// How closely a state must repeat, as a share of the range of each coordinate and velocity; positive.
    pub fn tolerance(self, tolerance: f64) -> Self {
        Settle { tolerance, ..self }
    }
    /// After how many periods to give up.
    pub fn most_periods(self, most_periods: usize) -> Self {
        Settle { most_periods, ..self }
    }
    /// The longest orbit looked for, in periods.
    pub fn largest_multiple(self, largest_multiple: usize) -> Self {
        Settle { largest_multiple, ..self }
    }

    /// Runs from `start`.
    ///
    /// # Errors
    /// [`Unsettled::Aperiodic`] with the state reached, when nothing repeats in time: chaos, quasi-periodicity, or slow decay.
    pub fn run<I: Integrator, M: Periodic + ?Sized>(&self, integrator: &I, model: &M, start: &State) -> Result<Steady, Unsettled> {
        let positive = |name, value: f64| {
            let error = IntegrateError::Setting { name, value, allowed: "positive" };
            if value > 0.0 { Ok(()) } else { Err(Unsettled::Failed { error, state: start.clone(), periods: 0 }) }
        };
        positive("tolerance", self.tolerance)?;
        positive("largest_multiple", self.largest_multiple as f64)?;
        if self.largest_multiple > LONGEST {
            let (value, allowed) = (self.largest_multiple as f64, "at most 65536 periods");
            let error = IntegrateError::Setting { name: "largest_multiple", value, allowed };
            return Err(Unsettled::Failed { error, state: start.clone(), periods: 0 });
        }
        let period = model.period();
        let components = 2 * model.dof();
        let mut section: Vec<State> = vec![start.clone()];
        let mut range = vec![[f64::INFINITY, f64::NEG_INFINITY]; components];
        // How many periods in a row each multiple has repeated.
        let mut repeated = vec![0; self.largest_multiple];
        let mut changes = vec![f64::INFINITY; self.largest_multiple];
        let mut closest = f64::INFINITY;
        for k in 1..=self.most_periods {
            let last = &section[k - 1];
            // Earlier ranges fade by half each period, so that transients are forgotten.
            range.iter_mut().for_each(|r| {
                let middle = 0.5 * (r[0] + r[1]);
                *r = if middle.is_finite() { [middle - 0.25 * (r[1] - r[0]), middle + 0.25 * (r[1] - r[0])] } else { *r };
            });
            let mut watch = |step: &mut Step<'_>| {
                for (r, y) in range.iter_mut().zip(step.y1()) {
                    *r = [r[0].min(*y), r[1].max(*y)];
                }
                ControlFlow::Continue(())
            };
            let finish = integrator.run(model, last, start.t + k as f64 * period, &mut watch).map_err(|error| Unsettled::Failed {
                error,
                state: last.clone(),
                periods: k - 1,
            })?;
            section.push(finish.state);
            for p in 1..=self.largest_multiple.min(k) {
                let change = distance(&section[k], &section[k - p], &range, self.tolerance);
                changes[p - 1] = change;
                if p == 1 || change < closest {
                    closest = change;
                }
                repeated[p - 1] = if change <= self.tolerance && is_own_multiple(&changes[..p]) { repeated[p - 1] + 1 } else { 0 };
                if repeated[p - 1] > p {
                    return Ok(Steady { state: section.swap_remove(k), period_multiple: p, periods: k, change });
                }
            }
        }
        let state = section.pop().unwrap_or_else(|| start.clone());
        Err(Unsettled::Aperiodic { state, periods: self.most_periods, closest, multiple: self.largest_multiple })
    }
}

/// The longest orbit that can be looked for, in periods.
const LONGEST: usize = 1 << 16;

/// A motion that winds into an orbit comes back closer after some multiples of its period than after one; it is p periods long only if it comes
/// back this much closer than after any divisor of p.
const CLOSER: f64 = 1e-3;

/// Whether returns after 1, 2, ..., p periods, by their distances, tell of an orbit of p periods and none shorter.
pub(crate) fn is_own_multiple(returns: &[f64]) -> bool {
    let (p, last) = (returns.len(), returns[returns.len() - 1]);
    (1..p).filter(|d| p.is_multiple_of(*d)).all(|d| last <= CLOSER * returns[d - 1])
}

/// The largest difference of two states in units of the range of each component; one that moves by rounding only counts as at rest.
fn distance(a: &State, b: &State, range: &[[f64; 2]], tolerance: f64) -> f64 {
    let both = a.q.iter().chain(&a.v).zip(b.q.iter().chain(&b.v));
    both.zip(range).fold(0.0, |worst: f64, ((x, y), r)| {
        let rounding = 64.0 * f64::EPSILON * r[0].abs().max(r[1].abs()) / tolerance;
        let size = (r[1] - r[0]).max(rounding);
        worst.max(if x == y { 0.0 } else { (x - y).abs() / size })
    })
}

/// A settled orbit.
///
/// ```
/// let state = gear_dynamics::State::at_rest(1);
/// let steady = gear_dynamics::Steady { state, period_multiple: 2, periods: 30, change: 1e-10 };
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
    /// How far the last repetition was off, as a share of the range of motion.
    pub change: f64,
}

/// Why no settled orbit is returned.
///
/// ```
/// use gear_dynamics::{Dop853, NfgPair, NfgParams, Settle, Unsettled};
/// let pair = NfgPair::new(&NfgParams { speed: 100.0, ..NfgParams::table1() })?;
/// let unsettled = Settle::new().most_periods(1).run(&Dop853::new(), &pair, &pair.static_start()?).unwrap_err();
/// assert!(matches!(unsettled, Unsettled::Aperiodic { periods: 1, .. }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Unsettled {
    /// Nothing repeated.
    #[error("no orbit of up to {multiple} periods repeats within {periods}: the closest return is {closest} of the range of motion")]
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
