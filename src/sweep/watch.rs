//! Looking on while a sweep runs.

use super::row::Row;
use std::sync::atomic::{AtomicBool, Ordering};

/// Looks on while a sweep runs, and may stop it.
///
/// ```
/// use gear_dynamics::Watch;
/// use std::sync::atomic::AtomicBool;
/// let stop = AtomicBool::new(false);
/// let show = |done: usize, total: usize| assert!(done <= total);
/// let watch = Watch::new().progress(&show).cancel(&stop);
/// assert!(!watch.is_cancelled());
/// ```
#[derive(Clone, Copy, Default)]
pub struct Watch<'w> {
    pub(super) progress: Option<&'w (dyn Fn(usize, usize) + Sync)>,
    pub(super) rows: Option<&'w (dyn Fn(&Row<'_>) + Sync)>,
    cancel: Option<&'w AtomicBool>,
}

impl<'w> Watch<'w> {
    /// Nothing to look at.
    pub fn new() -> Self {
        Watch::default()
    }
    /// Called after every point with the points done and all points.
    pub fn progress(self, progress: &'w (dyn Fn(usize, usize) + Sync)) -> Self {
        Watch { progress: Some(progress), ..self }
    }
    /// Called with every row as it comes, in no order.
    pub fn rows(self, rows: &'w (dyn Fn(&Row<'_>) + Sync)) -> Self {
        Watch { rows: Some(rows), ..self }
    }
    /// Stops the sweep within some steps once it is true; what is done is kept.
    pub fn cancel(self, cancel: &'w AtomicBool) -> Self {
        Watch { cancel: Some(cancel), ..self }
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
