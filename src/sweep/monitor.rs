//! The monitor of a sweep or an ensemble.

use crate::sweep::rows::row::Row;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering;

/// Receives the progress and the rows of a sweep or an ensemble while it runs, and may cancel it.
///
/// ```
/// use gear_dynamics::{sweep::{Axis, LaneRk4, Monitor, Point, Points}, NfgPair, NfgParams, Sweep};
/// use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
/// let stop = AtomicBool::new(false);
/// let show = |done: usize, _total: usize| stop.store(done >= 20, Relaxed);
/// let speeds = Points::on_axis(Axis::linear("speed", 100.0, 130.0, 400)?);
/// let sweep = Sweep::new(speeds).settle(1).measure(1).channels(&["q0"]);
/// let engine = LaneRk4::new(63 * 16);
/// let watch = Monitor::new().progress(&show).cancel(&stop);
/// let pair = |p: &Point<'_>| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() });
/// let runner = sweep.runner(&engine, pair, |_, pair| pair.static_start());
/// let part = runner.monitor(&watch).run()?;
/// assert!((20..400).contains(&part.iter().count()));
/// let whole = sweep.runner(&engine, pair, |_, pair| pair.static_start()).resume(part)?;
/// assert_eq!(whole.iter().count(), 400);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Default)]
pub struct Monitor<'w> {
    pub(crate) progress: Option<&'w (dyn Fn(usize, usize) + Sync)>,
    pub(crate) rows: Option<&'w (dyn Fn(&Row<'_>) + Sync)>,
    cancel: Option<&'w AtomicBool>,
}

impl std::fmt::Debug for Monitor<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Monitor").field("cancel", &self.cancel).finish_non_exhaustive()
    }
}

impl<'w> Monitor<'w> {
    /// A monitor without functions and without a flag.
    pub fn new() -> Self {
        Monitor::default()
    }
    /// Function that is called after every run with two numbers: completed runs and all runs. All runs are
    /// the points of the chunk and their checks, or the members of an ensemble.
    pub fn progress(self, progress: &'w (dyn Fn(usize, usize) + Sync)) -> Self {
        Monitor { progress: Some(progress), ..self }
    }
    /// Function that is called with every row as soon as its run is complete, in any order. It blocks only
    /// the worker that produced the row. An ensemble does not call it.
    pub fn rows(self, rows: &'w (dyn Fn(&Row<'_>) + Sync)) -> Self {
        Monitor { rows: Some(rows), ..self }
    }
    /// Flag that cancels the sweep or the ensemble when it becomes `true`. Completed rows are kept:
    /// [`Runner::resume`](crate::sweep::Runner::resume) runs the other points.
    ///
    /// Fixed-step engines check the flag at least every max(64, n/24) steps, with n steps per period; drive
    /// tables every 64 rows; [`Located`](crate::sweep::Located) and ensembles after every step.
    pub fn cancel(self, cancel: &'w AtomicBool) -> Self {
        Monitor { cancel: Some(cancel), ..self }
    }
    /// Reports the progress.
    pub(crate) fn show(&self, done: usize, total: usize) {
        if let Some(progress) = self.progress {
            progress(done, total);
        }
    }
    /// Whether the flag of [`cancel`](Monitor::cancel) is `true`.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed))
    }
}
