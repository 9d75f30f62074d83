//! Limits on work: steps, time, a flag that stops it.

use crate::ode::step::{Observer, Step};
use std::cell::Cell;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering;
use std::time::Duration;
use std::time::Instant;
use thiserror::Error;

/// How much work one call may do: accepted steps of time integration or iterations of a root finder, wall time, and a flag that stops it
/// from another thread.
///
/// Default: 10⁸ steps, no limit on time, no flag. A limit on steps gives the same result on every machine; a limit on time does not.
///
/// ```
/// use gear_dynamics::{Budget, ode::Exhausted};
/// use std::sync::{Arc, atomic::{AtomicBool, Ordering}};
/// use std::time::Duration;
/// let stop = Arc::new(AtomicBool::new(false));
/// let budget = Budget::new().steps(1_000_000).time(Duration::from_secs(10)).cancel(stop.clone());
/// stop.store(true, Ordering::Relaxed); // from any thread
/// assert_eq!(Exhausted::Steps { limit: 1_000_000 }.to_string(), "the budget of 1000000 steps is spent");
/// # drop(budget);
/// ```
#[derive(Clone, Debug)]
pub struct Budget {
    steps: u64,
    time: Option<Duration>,
    cancel: Option<Arc<AtomicBool>>,
}

impl PartialEq for Budget {
    /// Equal limits, and the same flag.
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
    /// 10⁸ steps, no limit on time, no flag.
    pub fn new() -> Self {
        Budget { steps: 100_000_000, time: None, cancel: None }
    }
    /// At most this many accepted steps, or iterations of a root finder.
    pub fn steps(self, steps: u64) -> Self {
        Budget { steps, ..self }
    }
    /// At most this wall time.
    pub fn time(self, time: Duration) -> Self {
        Budget { time: Some(time), ..self }
    }
    /// Stops once the flag is true.
    pub fn cancel(self, cancel: Arc<AtomicBool>) -> Self {
        Budget { cancel: Some(cancel), ..self }
    }
    /// Starts the clock of one call.
    pub(crate) fn begin(&self) -> Meter<'_> {
        Meter { budget: self, begun: Instant::now(), spent: Cell::new(0), exhausted: Cell::new(None) }
    }
}

/// Which limit of a [`Budget`] ended a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Exhausted {
    /// The steps.
    #[error("the budget of {limit} steps is spent")]
    Steps {
        /// The limit.
        limit: u64,
    },
    /// The time.
    #[error("the budget of {limit:?} is spent")]
    Time {
        /// The limit.
        limit: Duration,
    },
    /// The flag.
    #[error("cancelled")]
    Cancelled,
}

/// What one call has spent of its budget. As an observer it stops a run once nothing is left.
#[derive(Debug)]
pub(crate) struct Meter<'b> {
    budget: &'b Budget,
    begun: Instant,
    spent: Cell<u64>,
    exhausted: Cell<Option<Exhausted>>,
}

impl Meter<'_> {
    /// Takes one step from the budget.
    #[inline]
    pub(crate) fn spend(&self) -> Result<(), Exhausted> {
        let spent = self.spent.get() + 1;
        self.spent.set(spent);
        // A look at the clock costs as much as a small step.
        if spent <= self.budget.steps && spent % 64 != 1 {
            return Ok(());
        }
        self.look()
    }

    /// The same with a look at the clock every time: for steps that take long.
    pub(crate) fn spend_slowly(&self) -> Result<(), Exhausted> {
        self.spent.set(self.spent.get() + 1);
        self.look()
    }

    /// Whether anything is left: for work that is not counted in steps.
    pub(crate) fn look(&self) -> Result<(), Exhausted> {
        let Budget { steps, time, cancel } = self.budget;
        let exhausted = if self.spent.get() > *steps {
            Some(Exhausted::Steps { limit: *steps })
        } else if cancel.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed)) {
            Some(Exhausted::Cancelled)
        } else {
            time.filter(|limit| self.begun.elapsed() > *limit).map(|limit| Exhausted::Time { limit })
        };
        self.exhausted.set(exhausted);
        exhausted.map_or(Ok(()), Err)
    }

    /// Whether no limit has stopped a run that this meter observed.
    pub(crate) fn left(&self) -> Result<(), Exhausted> {
        self.exhausted.get().map_or(Ok(()), Err)
    }

    /// Which limit stopped a run that this meter observed.
    pub(crate) fn exhausted(&self) -> Option<Exhausted> {
        self.exhausted.get()
    }
}

impl Observer for &Meter<'_> {
    fn step(&mut self, _: &mut Step<'_>) -> ControlFlow<()> {
        if self.spend().is_err() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
