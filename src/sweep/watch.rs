//! What follows the progress of a sweep or an ensemble, and the flag that cancels it.

use crate::sweep::rows::row::Row;
use std::fmt::{self, Debug, Formatter};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

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
    /// Reports the progress.
    pub(crate) fn show(&self, done: usize, total: usize) {
        if let Some(progress) = &self.progress {
            progress(done, total);
        }
    }
    /// Whether the flag is `true`.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancel.as_ref().is_some_and(|cancel| cancel.load(Ordering::Relaxed))
    }
}
