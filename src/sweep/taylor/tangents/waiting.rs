//! Motions that wait for a lane, and what was found of those that are over.

use crate::sweep::taylor::tasks::task::{LaneJob, Queue, Task};

/// The queue of motions whose runs are prepared; an entry of `found` for each job.
pub(crate) struct Waiting<'w, J, F, R> {
    /// The runs to make.
    pub(crate) runs: J,
    /// What a run that is over has found.
    pub(crate) finish: F,
    pub(crate) found: &'w mut [Option<R>],
    pub(crate) go_on: &'w dyn Fn() -> bool,
}

impl<'m, T, J, F, R> Queue<'m, T> for Waiting<'_, J, F, R>
where
    T: Task<'m>,
    J: Iterator<Item = LaneJob<'m, T>>,
    F: Fn(T, Result<(), T::Error>) -> R,
{
    fn next(&mut self) -> Option<LaneJob<'m, T>> {
        self.runs.next()
    }
    fn over(&mut self, index: usize, task: T, outcome: Result<(), T::Error>) -> Option<LaneJob<'m, T>> {
        self.found[index] = Some((self.finish)(task, outcome));
        self.runs.next()
    }
    fn is_cancelled(&self) -> bool {
        !(self.go_on)()
    }
}
