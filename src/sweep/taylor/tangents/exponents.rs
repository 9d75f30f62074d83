//! Lyapunov exponents of many motions, side by side.

use crate::model::{Machine, Periodic, Shape};
use crate::ode::budget::Meter;
use crate::periodic::flow::flow_method::{Expansion, FlowMethod};
use crate::periodic::flow::tangent::Tangent;
use crate::periodic::lyapunov::exponents::LyapunovError;
use crate::periodic::lyapunov::run::Lyapunov;
use crate::sweep::engines::sweep_engine::{Exponent, Job, one_by_one};
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::taylor::program::Program;
use crate::sweep::taylor::tangents::by_shape::by_shape;
use crate::sweep::taylor::tangents::tangent_task::TangentTask;
use crate::sweep::taylor::tangents::waiting::Waiting;

/// The exponents of the motions of machines: the flow with its derivative by Taylor series in lanes. The
/// derivative is that of the tape of the shape, its jumps those of single runs. Machines of equal shapes
/// share lanes. Motions that lanes do not run, or that are wanted by another method, are run one by one.
pub(crate) fn exponents<G: Shape>(
    lyapunov: &Lyapunov,
    set: InstructionSet,
    jobs: &[Job<Machine<G>>],
    go_on: &dyn Fn() -> bool,
) -> Vec<Exponent> {
    let one = |job: &Job<Machine<G>>| one_by_one(lyapunov, job, go_on);
    if !lyapunov.allows_series() {
        return jobs.iter().map(one).collect();
    }
    let count = |dof: usize| lyapunov.count_for(dof);
    let in_lanes = |program: &Program, chosen: &[usize], found: &mut [Exponent]| {
        side_by_side(lyapunov, set, program, jobs, chosen, go_on, found);
    };
    by_shape(jobs, |job| &job.model, count, in_lanes, one)
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
    let meters: Vec<Meter<'_>> = chosen.iter().map(|_| lyapunov.meter(go_on)).collect();
    let mut settled = Vec::new();
    for (&i, meter) in chosen.iter().zip(&meters) {
        let job = &jobs[i];
        if !go_on() {
            return;
        }
        match lyapunov.settled(&job.model, &job.start, job.model.period(), meter) {
            Ok(motion) => settled.push((i, meter, motion)),
            Err(_) if !go_on() => return,
            Err(error) => found[i] = Some(Err(error)),
        }
    }
    let none = Expansion::none();
    let flows: Vec<Tangent<'_>> =
        settled.iter().map(|(i, _, motion)| lyapunov.tangent(&jobs[*i].model, motion, &none)).collect();
    let mut pursuits = Vec::new();
    for (flow, (i, _, motion)) in flows.iter().zip(&settled) {
        pursuits.push(lyapunov.progress(motion, &jobs[*i].start, flow, FlowMethod::Taylor));
    }
    let waiting = pursuits.iter_mut().zip(flows.iter().zip(&settled)).enumerate();
    let mut runs = waiting.map_while(|(number, (progress, (flow, (i, meter, _))))| {
        Some(TangentTask::new(flow, progress, meter)?.in_lane(number, &jobs[*i].model))
    });
    let (tolerance, waves) = (lyapunov.tolerance(), jobs[chosen[0]].model.wave_series());
    let outcomes = Waiting::new(&mut runs, flows.len(), go_on).run_all(set, program, tolerance, waves);
    for (progress, (outcome, (i, ..))) in pursuits.into_iter().zip(outcomes.into_iter().zip(&settled)) {
        let exponents = progress.exponents.in_order();
        found[*i] = outcome.map(|outcome| match outcome {
            Ok(()) => Ok(exponents),
            Err(failure) => Err(LyapunovError::after(failure, exponents)),
        });
    }
}
