//! Lyapunov exponents of many motions, side by side.

use crate::model::{Machine, Model, Periodic, Shape};
use crate::ode::Taylor;
use crate::ode::budget::Meter;
use crate::periodic::flow::flow_method::{Expansion, FlowMethod};
use crate::periodic::flow::tangent::Tangent;
use crate::periodic::flow::tangent_tape::tangent;
use crate::periodic::flow::walk::NONE;
use crate::periodic::lyapunov::directions::Failure;
use crate::periodic::lyapunov::progress::Progress;
use crate::periodic::lyapunov::run::{Lyapunov, Settled};
use crate::periodic::pursuit::Pursuit;
use crate::sweep::engines::sweep_engine::{Exponent, Job, one_by_one};
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::taylor::crew::{Crew, of_equal_shapes};
use crate::sweep::taylor::lane::Motion;
use crate::sweep::taylor::program::Program;
use crate::sweep::taylor::tasks::tangent_task::TangentTask;
use crate::sweep::taylor::tasks::task::{LaneJob, Queue};
use std::iter::Zip;
use std::slice::Iter;

/// The exponents of the motions of machines: the flow with its derivative by Taylor series in W lanes. The
/// derivative is that of the tape of the shape, its jumps those of single runs. Machines of equal shapes
/// share lanes. Motions that lanes do not run, or that are wanted by another method, are run one by one.
pub(crate) fn exponents<G: Shape, const W: usize>(
    lyapunov: &Lyapunov,
    set: InstructionSet,
    jobs: &[Job<Machine<G>>],
    go_on: &dyn Fn() -> bool,
) -> Vec<Exponent> {
    let mut found: Vec<Exponent> = jobs.iter().map(|_| None).collect();
    for equal in of_equal_shapes(jobs, |job| &job.model) {
        let leader = &jobs[equal[0]].model;
        let count = lyapunov.count_for(leader.dof());
        let tape = tangent(&leader.record_shape().0, count, &[]);
        match Program::new(&tape, leader.size().waves, &[]) {
            Ok(program) if lyapunov.allows_series() => {
                side_by_side::<G, W>(lyapunov, set, &program, jobs, &equal, go_on, &mut found);
            }
            _ => equal.into_iter().for_each(|i| found[i] = one_by_one(lyapunov, &jobs[i], go_on)),
        }
    }
    found
}

/// The exponents of machines of one shape; `chosen`: their jobs.
fn side_by_side<G: Shape, const W: usize>(
    lyapunov: &Lyapunov,
    set: InstructionSet,
    program: &Program,
    jobs: &[Job<Machine<G>>],
    chosen: &[usize],
    go_on: &dyn Fn() -> bool,
    found: &mut [Exponent],
) {
    let meters: Vec<Meter<'_>> = chosen.iter().map(|_| lyapunov.meter()).collect();
    let mut settled = Vec::new();
    for (&i, meter) in chosen.iter().zip(&meters) {
        let Job { model, start, .. } = &jobs[i];
        if !go_on() {
            return;
        }
        match lyapunov.settled(model, start, model.period(), meter) {
            Ok(motion) => settled.push((i, meter, motion)),
            Err(error) => found[i] = Some(Err(error)),
        }
    }
    let none = Expansion::none();
    let flows: Vec<Tangent<'_, dyn Model + '_>> =
        settled.iter().map(|(i, _, motion)| lyapunov.tangent(&jobs[*i].model, motion, &none)).collect();
    let mut waiting = WaitingMotions { lyapunov, jobs, waiting: flows.iter().zip(&settled), found, go_on };
    let Some(first) = waiting.next() else { return };
    let order = Taylor::order_for(lyapunov.tolerance());
    let waves = jobs[first.index].model.wave_series();
    let taylor = Taylor::new().rtol(NONE).order(order);
    Crew::<_, W>::new(&taylor, set, program, waves, order).run(first, &mut waiting);
}

/// A motion after settling: its job and its work so far.
type Settling<'b> = (usize, &'b Meter<'b>, Settled);

/// The task of a motion.
type ExponentTask<'m, 't> = TangentTask<'m, 't, Progress<'m>>;

/// The motions that wait for a lane, and the exponents found.
struct WaitingMotions<'m, 't, 'w, G> {
    lyapunov: &'m Lyapunov,
    jobs: &'m [Job<Machine<G>>],
    waiting: Zip<Iter<'m, Tangent<'t, dyn Model + 't>>, Iter<'m, Settling<'m>>>,
    found: &'w mut [Exponent],
    go_on: &'w dyn Fn() -> bool,
}

impl<'m, 't: 'm, G: Shape> Queue<'m, ExponentTask<'m, 't>> for WaitingMotions<'m, 't, '_, G> {
    fn next(&mut self) -> Option<LaneJob<'m, ExponentTask<'m, 't>>> {
        let (flow, (index, meter, settled)) = self.waiting.next()?;
        let Job { model, start, .. } = &self.jobs[*index];
        let progress = self.lyapunov.progress(settled, start, flow, FlowMethod::Taylor);
        let until = progress.target()?;
        let task = TangentTask::new(flow, progress, meter, until);
        let (start, speed) = (task.state().clone(), model.speed());
        let motion = Motion { model: flow, expanded: model, speed, start, until };
        Some(LaneJob { index: *index, motion, task })
    }
    fn over(
        &mut self,
        index: usize,
        task: ExponentTask<'m, 't>,
        outcome: Result<(), Failure>,
    ) -> Option<LaneJob<'m, ExponentTask<'m, 't>>> {
        let exponents = task.pursuit.exponents.in_order();
        self.found[index] = Some(match outcome {
            Ok(()) => Ok(exponents),
            Err(failure) => Err(failure.with(exponents)),
        });
        self.next()
    }
    fn is_cancelled(&self) -> bool {
        !(self.go_on)()
    }
}
