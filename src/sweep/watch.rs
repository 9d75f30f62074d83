//! What follows many runs: their progress, the flag that cancels them, their blocks.

use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::fmt::{self, Debug, Formatter};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

type OfProgress<'w> = Arc<dyn Fn(usize, usize) + Send + Sync + 'w>;

/// The progress of many runs, and the flag that cancels them: a setting of sweeps, ensembles, long runs and
/// rare events. Default: neither. One call of a solver is cancelled by its [`Budget`](crate::Budget).
///
/// What was complete when the flag became `true` is kept.
///
/// ```
/// use gear_dynamics::{model::from_fn, sweep::{Ensemble, Watch}, ParameterError, Rk4, State};
/// use std::sync::{Arc, atomic::{AtomicBool, Ordering::Relaxed}};
/// let stop = Arc::new(AtomicBool::new(false));
/// let progress = |done: usize, _all: usize| stop.store(done >= 10, Relaxed);
/// let watch = Watch::new().progress(progress).cancel(stop.clone());
/// let spring = |_| Ok::<_, ParameterError>((from_fn(1, |_, q, _, a| a[0] = -q[0])?, State::at_rest(1)));
/// let bands = Ensemble::new(100_000, 1.0, 1)?.watch(watch).run(&Rk4::new(0.1), spring)?;
/// assert!((10..100_000).contains(&bands.members()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Default)]
#[must_use = "a setting returns a new value"]
pub struct Watch<'w> {
    progress: Option<OfProgress<'w>>,
    cancel: Option<Arc<AtomicBool>>,
}

impl Debug for Watch<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.debug_struct("Watch").field("cancel", &self.cancel).finish_non_exhaustive()
    }
}

impl<'w> Watch<'w> {
    /// No function and no flag.
    pub fn new() -> Self {
        Watch::default()
    }
    /// Function that is called with two numbers, completed and all runs, whenever more of them are complete:
    /// after each run of a sweep or an ensemble, each group of members of a long run, each block of members
    /// of a first passage, each repeat of a splitting.
    pub fn progress(self, progress: impl Fn(usize, usize) + Send + Sync + 'w) -> Self {
        Watch { progress: Some(Arc::new(progress)), ..self }
    }
    /// Flag that cancels the runs when it becomes `true`.
    pub fn cancel(self, cancel: Arc<AtomicBool>) -> Self {
        Watch { cancel: Some(cancel), ..self }
    }

    /// Begins to count the runs of a call: `done` of `all` are complete.
    pub(crate) fn begin(&self, done: usize, all: usize) -> Progress<'_> {
        Progress { watch: self, done: AtomicUsize::new(done), all }
    }
    /// Reports the progress.
    pub(crate) fn show(&self, done: usize, all: usize) {
        if let Some(progress) = &self.progress {
            progress(done, all);
        }
    }
    /// Whether the flag is `true`.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancel.as_ref().is_some_and(|cancel| cancel.load(Ordering::Relaxed))
    }
}

/// The completed runs of one call.
pub(crate) struct Progress<'w> {
    watch: &'w Watch<'w>,
    done: AtomicUsize,
    all: usize,
}

impl Progress<'_> {
    /// Counts completed runs and reports them.
    pub(crate) fn add(&self, runs: usize) {
        self.watch.show(runs + self.done.fetch_add(runs, Ordering::Relaxed), self.all);
    }

    /// Runs members in blocks of `size`, on all threads, and reports after each block. The results of the
    /// blocks that were complete, in their order: a block that was cancelled gives `None`.
    ///
    /// # Errors
    /// That of the first block that fails.
    pub(crate) fn blocks<T: Send, E: Send>(
        &self,
        members: Range<usize>,
        size: usize,
        run: impl Fn(Range<usize>) -> Result<Option<T>, E> + Sync,
    ) -> Result<Vec<T>, E> {
        let block = |block: usize| {
            if self.watch.is_cancelled() {
                return Ok(None);
            }
            let first = members.start + block * size;
            let here = first..(first + size).min(members.end);
            let count = here.len();
            let seen = run(here)?;
            if seen.is_some() {
                self.add(count);
            }
            Ok(seen)
        };
        let blocks: Vec<Result<Option<T>, E>> =
            (0..members.len().div_ceil(size)).into_par_iter().map(block).collect();
        blocks.into_iter().filter_map(Result::transpose).collect()
    }
}
