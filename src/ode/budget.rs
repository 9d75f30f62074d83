//! Limits on the work of one call: steps, wall time, a cancel flag.

use crate::ode::step::{Observer, Step};
use std::cell::Cell;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering;
use std::time::Duration;
use std::time::Instant;
use thiserror::Error;

/// Limits on the work of one call: steps, wall time, a cancel flag.
///
/// A step is an accepted step of a time integration or an evaluation of the residual by a root finder.
/// Another thread cancels the call with the flag.
///
/// Defaults: 10⁸ steps, no time limit, no flag. A step limit gives the same result on every machine; a time
/// limit does not.
///
/// ```
/// use gear_dynamics::{Budget, Dop853, NfgPair, NfgParams, Settle};
/// use gear_dynamics::{analysis::SettleError, ode::Exhausted};
/// use std::sync::{Arc, atomic::{AtomicBool, Ordering}};
/// use std::time::Duration;
/// let stop = Arc::new(AtomicBool::new(false));
/// let budget = Budget::new().steps(1_000_000).time(Duration::from_secs(10)).cancel(stop.clone());
/// stop.store(true, Ordering::Relaxed); // from any thread
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let settled = Settle::new().budget(budget).run(&Dop853::new(), &pair, &pair.on_drive_flank()?);
/// assert!(matches!(settled, Err(SettleError::Exhausted { exhausted: Exhausted::Cancelled, .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "a setting returns a new value"]
pub struct Budget {
    steps: u64,
    time: Option<Duration>,
    cancel: Option<Arc<AtomicBool>>,
}

impl PartialEq for Budget {
    /// Budgets are equal if their limits are equal and their flag is the same object.
    fn eq(&self, other: &Self) -> bool {
        let flag = |b: &Budget| b.cancel.as_ref().map(Arc::as_ptr);
        (self.steps, self.time, flag(self)) == (other.steps, other.time, flag(other))
    }
}

impl Default for Budget {
    fn default() -> Self {
        Budget::new()
    }
}

impl Budget {
    /// Defaults: 10⁸ steps, no time limit, no flag.
    pub fn new() -> Self {
        Budget { steps: 100_000_000, time: None, cancel: None }
    }
    /// Maximum number of accepted steps, or of evaluations of the residual by a root finder. Default: 10⁸.
    pub fn steps(self, steps: u64) -> Self {
        Budget { steps, ..self }
    }
    /// Maximum wall time of the call. Default: none.
    pub fn time(self, time: Duration) -> Self {
        Budget { time: Some(time), ..self }
    }
    /// Stops the call once the flag is true. Default: none.
    pub fn cancel(self, cancel: Arc<AtomicBool>) -> Self {
        Budget { cancel: Some(cancel), ..self }
    }
    /// Starts the meter of one call.
    pub(crate) fn begin(&self) -> Meter<'_> {
        self.begin_while(&|| true)
    }
    /// Starts the meter of one call that is cancelled, too, once `go_on` returns `false`.
    pub(crate) fn begin_while<'b>(&'b self, go_on: &'b dyn Fn() -> bool) -> Meter<'b> {
        Meter { budget: self, go_on, begun: Instant::now(), spent: Cell::new(0), exhausted: Cell::new(None) }
    }
}

/// The limit of a [`Budget`] that ended a call.
///
/// ```
/// use gear_dynamics::ode::Exhausted;
/// assert_eq!(Exhausted::Steps { limit: 1_000_000 }.to_string(), "the budget of 1000000 steps is spent");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Exhausted {
    /// The step limit was reached.
    #[error("the budget of {limit} steps is spent")]
    Steps {
        /// Maximum number of steps.
        limit: u64,
    },
    /// The time limit was reached.
    #[error("the budget of {limit:?} is spent")]
    Time {
        /// Maximum wall time.
        limit: Duration,
    },
    /// The cancel flag was set.
    #[error("cancelled")]
    Cancelled,
}

/// The work that one call has done so far. As an observer it stops a run once a limit is reached.
pub(crate) struct Meter<'b> {
    budget: &'b Budget,
    /// Whether the call goes on: `false` if those who wait for it cancelled it.
    go_on: &'b dyn Fn() -> bool,
    begun: Instant,
    spent: Cell<u64>,
    exhausted: Cell<Option<Exhausted>>,
}

impl Meter<'_> {
    /// Counts one step. Checks the step limit at every call, clock and flag at every 64th.
    #[inline]
    pub(crate) fn spend(&self) -> Result<(), Exhausted> {
        let spent = self.spent.get() + 1;
        self.spent.set(spent);
        // Reading the clock costs as much as a small step.
        if spent <= self.budget.steps && spent % 64 != 1 {
            return Ok(());
        }
        self.check()
    }

    /// Counts one step and checks all limits. For steps that take long compared with reading the clock.
    pub(crate) fn spend_slowly(&self) -> Result<(), Exhausted> {
        self.spent.set(self.spent.get() + 1);
        self.check()
    }

    /// Checks all limits and counts no step. For work that is not counted in steps.
    pub(crate) fn check(&self) -> Result<(), Exhausted> {
        let Budget { steps, time, cancel } = self.budget;
        let exhausted = if self.spent.get() > *steps {
            Some(Exhausted::Steps { limit: *steps })
        } else if cancel.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed)) || !(self.go_on)() {
            Some(Exhausted::Cancelled)
        } else {
            time.filter(|limit| self.begun.elapsed() > *limit).map(|limit| Exhausted::Time { limit })
        };
        self.exhausted.set(exhausted);
        exhausted.map_or(Ok(()), Err)
    }

    /// `Err` with the limit that the last check found reached, otherwise `Ok`.
    pub(crate) fn left(&self) -> Result<(), Exhausted> {
        self.exhausted.get().map_or(Ok(()), Err)
    }

    /// The limit that the last check found reached.
    pub(crate) fn exhausted(&self) -> Option<Exhausted> {
        self.exhausted.get()
    }
}

impl Observer for &Meter<'_> {
    fn step(&mut self, _: &mut Step<'_>) -> ControlFlow<()> {
        if self.spend().is_err() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
