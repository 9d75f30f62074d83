//! Lyapunov exponents of many motions, side by side.

use crate::model::{Machine, Model, Periodic, Shape};
use crate::ode::Taylor;
use crate::ode::budget::Meter;
use crate::periodic::flow::flow_method::{Expansion, FlowMethod};
use crate::periodic::flow::tangent::Tangent;
use crate::periodic::flow::tangent_tape::tangent;
use crate::periodic::flow::walk::NONE;
use crate::periodic::lyapunov::exponents::LyapunovError;
use crate::periodic::lyapunov::progress::Progress;
use crate::periodic::lyapunov::run::Lyapunov;
use crate::periodic::pursuit::{Pursuit, PursuitError};
use crate::sweep::engines::sweep_engine::{Exponent, Job, one_by_one};
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::taylor::crew::{Crew, of_equal_shapes};
use crate::sweep::taylor::program::Program;
use crate::sweep::taylor::tangents::tangent_task::TangentTask;
use crate::sweep::taylor::tangents::waiting::Waiting;
use crate::sweep::taylor::tasks::task::{LaneJob, Queue};

/// The exponents of the motions of machines: the flow with its derivative by Taylor series in lanes. The
/// derivative is that of the tape of the shape, its jumps those of single runs. Machines of equal shapes
/// share lanes. Motions that lanes do not run, or that are wanted by another method, are run one by one.
pub(crate) fn exponents<G: Shape>(
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
                side_by_side(lyapunov, set, &program, jobs, &equal, go_on, &mut found);
            }
            _ => equal.into_iter().for_each(|i| found[i] = one_by_one(lyapunov, &jobs[i], go_on)),
        }
    }
    found
}

/// The exponents of machines of one shape; `chosen`: their jobs.
fn side_by_side<G: Shape>(
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
    let runs = flows.iter().zip(&settled).map_while(|(flow, (index, meter, motion))| {
        let Job { model, start, .. } = &jobs[*index];
        let progress = lyapunov.progress(motion, start, flow, FlowMethod::Taylor);
        let until = progress.target()?;
        Some(TangentTask::new(flow, progress, meter, until).in_lane(*index, model))
    });
    let finish = |task: ExponentTask<'_, '_>, outcome: Result<(), PursuitError>| {
        let exponents = task.pursuit.exponents.in_order();
        match outcome {
            Ok(()) => Ok(exponents),
            Err(failure) => Err(LyapunovError::after(failure, exponents)),
        }
    };
    let mut waiting = Waiting { runs, finish, found, go_on };
    let Some(first) = waiting.runs.next() else { return };
    let order = Taylor::order_for(lyapunov.tolerance());
    let waves = jobs[first.index].model.wave_series();
    let taylor = Taylor::new().rtol(NONE).order(order);
    let crew = Crew::new(&taylor, set, program, waves, order);
    run(crew, first, &mut waiting);
}

/// Makes the runs: compiled once, with the library.
#[inline(never)]
fn run<'m, 't: 'm>(
    mut crew: Crew<'_, 'm, ExponentTask<'m, 't>>,
    first: LaneJob<'m, ExponentTask<'m, 't>>,
    queue: &mut dyn Queue<'m, ExponentTask<'m, 't>>,
) {
    crew.run(first, queue);
}

/// The task of a motion.
type ExponentTask<'m, 't> = TangentTask<'m, 't, Progress<'m>>;
