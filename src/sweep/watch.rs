//! What follows the progress of many runs, the flag that cancels them, and their blocks.

use crate::sweep::rows::row::Row;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::fmt::{self, Debug, Formatter};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

type OfProgress<'w> = Arc<dyn Fn(usize, usize) + Send + Sync + 'w>;
type OfRows<'w> = Arc<dyn Fn(&Row<'_>) + Send + Sync + 'w>;

/// Functions that receive the progress and the rows, and the flag that cancels the runs.
#[derive(Clone, Default)]
pub(crate) struct Watch<'w> {
    pub(crate) progress: Option<OfProgress<'w>>,
    pub(crate) rows: Option<OfRows<'w>>,
    pub(crate) cancel: Option<Arc<AtomicBool>>,
}

impl Debug for Watch<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.debug_struct("Watch").field("cancel", &self.cancel).finish_non_exhaustive()
    }
}

impl Watch<'_> {
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
