//! Motions that wait for a lane, and how those that are over have ended.

use crate::model::shapes::waves::fourier_waves::FourierWaves;
use crate::ode::Taylor;
use crate::periodic::flow::walk::NONE;
use crate::periodic::pursuit::PursuitError;
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::taylor::crew::Crew;
use crate::sweep::taylor::program::Program;
use crate::sweep::taylor::tangents::tangent_task::TangentTask;
use crate::sweep::taylor::tasks::task::{LaneJob, Queue};

/// How a run has ended; `None` if it was cancelled before its end.
pub(crate) type PursuitOutcome = Option<Result<(), PursuitError>>;

/// The queue of motions whose runs are prepared.
pub(crate) struct Waiting<'w, 'm, 't> {
    /// The runs to make, with their numbers as indices.
    runs: &'w mut dyn Iterator<Item = LaneJob<'m, TangentTask<'m, 't>>>,
    outcomes: Vec<PursuitOutcome>,
    go_on: &'w dyn Fn() -> bool,
}

impl<'w, 'm, 't: 'm> Waiting<'w, 'm, 't> {
    /// `runs`: at most `count` runs, each with its number as index.
    pub(crate) fn new(
        runs: &'w mut dyn Iterator<Item = LaneJob<'m, TangentTask<'m, 't>>>,
        count: usize,
        go_on: &'w dyn Fn() -> bool,
    ) -> Self {
        Waiting { runs, outcomes: (0..count).map(|_| None).collect(), go_on }
    }

    /// Makes the runs: compiled once, with the library. `tolerance`: local error of the flow.
    #[inline(never)]
    pub(crate) fn run_all(
        mut self,
        set: InstructionSet,
        program: &Program,
        tolerance: f64,
        waves: Option<&FourierWaves>,
    ) -> Vec<PursuitOutcome> {
        if let Some(first) = self.runs.next() {
            let order = Taylor::order_for(tolerance);
            let taylor = Taylor::new().rtol(NONE).order(order);
            Crew::new(&taylor, set, program, waves, order).run(first, &mut self);
        }
        self.outcomes
    }
}

impl<'m, 't> Queue<'m, TangentTask<'m, 't>> for Waiting<'_, 'm, 't> {
    fn next(&mut self) -> Option<LaneJob<'m, TangentTask<'m, 't>>> {
        self.runs.next()
    }
    fn over(
        &mut self,
        index: usize,
        _: TangentTask<'m, 't>,
        outcome: Result<(), PursuitError>,
    ) -> Option<LaneJob<'m, TangentTask<'m, 't>>> {
        self.outcomes[index] = Some(outcome);
        self.runs.next()
    }
    fn is_cancelled(&self) -> bool {
        !(self.go_on)()
    }
}
