//! Looking on while a sweep runs.

use crate::sweep::rows::row::Row;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering;

/// Looks on while a sweep runs, and may stop it.
///
/// ```
/// use gear_dynamics::{sweep::{Axis, LaneRk4, Monitor, Points}, NfgPair, NfgParams, Sweep};
/// use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
/// let stop = AtomicBool::new(false);
/// let show = |done: usize, _total: usize| stop.store(done >= 20, Relaxed);
/// let sweep = Sweep::over(Points::along(Axis::linear("speed", 100.0, 130.0, 400)?)).settle(1).measure(1).channels(&["q1"]);
/// let (engine, watch) = (LaneRk4::<4>::new(63 * 16), Monitor::new().progress(&show).cancel(&stop));
/// let pair = |p: &gear_dynamics::sweep::Point<'_>| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() });
/// let part = sweep.run_chunk(0, 1, &engine, pair, |_, pair| pair.static_start(), &watch)?;
/// assert!((20..400).contains(&part.iter().count()));
/// let whole = sweep.resume(part, &engine, pair, |_, pair| pair.static_start(), &Monitor::new())?;
/// assert_eq!(whole.iter().count(), 400);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Default)]
pub struct Monitor<'w> {
    pub(crate) progress: Option<&'w (dyn Fn(usize, usize) + Sync)>,
    pub(crate) rows: Option<&'w (dyn Fn(&Row<'_>) + Sync)>,
    cancel: Option<&'w AtomicBool>,
}

impl<'w> Monitor<'w> {
    /// Nothing to look at.
    pub fn new() -> Self {
        Monitor::default()
    }
    /// Called as runs are done with their number and that of all runs to be made here: the points of the chunk, and those to be checked once more.
    pub fn progress(self, progress: &'w (dyn Fn(usize, usize) + Sync)) -> Self {
        Monitor { progress: Some(progress), ..self }
    }
    /// Called with every row as it comes, in no order. No other row waits for it to return, but the thread that made it.
    pub fn rows(self, rows: &'w (dyn Fn(&Row<'_>) + Sync)) -> Self {
        Monitor { rows: Some(rows), ..self }
    }
    /// Stops the sweep within 64 steps, or 64 rows of a table, once it is true. What is done is kept: [`Sweep::resume`](crate::Sweep::resume) runs
    /// the rest.
    pub fn cancel(self, cancel: &'w AtomicBool) -> Self {
        Monitor { cancel: Some(cancel), ..self }
    }
    pub(crate) fn show(&self, done: usize, total: usize) {
        if let Some(progress) = self.progress {
            progress(done, total);
        }
    }
    /// Whether it is to stop.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed))
    }
}
