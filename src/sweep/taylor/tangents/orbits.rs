//! Multipliers of many orbits, side by side.

use crate::model::{Machine, Model, Shape};
use crate::ode::Taylor;
use crate::ode::budget::Meter;
use crate::periodic::flow::flow_method::Expansion;
use crate::periodic::flow::tangent::Tangent;
use crate::periodic::flow::tangent_tape::tangent;
use crate::periodic::flow::walk::NONE;
use crate::periodic::pursuit::PursuitError;
use crate::periodic::shooting::closing::Closing;
use crate::periodic::shooting::multiple::Shooting;
use crate::periodic::shooting::segments::Segments;
use crate::sweep::engines::sweep_engine::{Orbit, OrbitJob, close_one};
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::taylor::crew::{Crew, of_equal_shapes};
use crate::sweep::taylor::program::Program;
use crate::sweep::taylor::tangents::tangent_task::TangentTask;
use crate::sweep::taylor::tangents::waiting::Waiting;
use crate::sweep::taylor::tasks::task::{LaneJob, Queue};

/// The multipliers of the orbits near motions of machines: shooting with the flow and its derivative in
/// lanes, each orbit in one segment. Machines of equal shapes share lanes. Orbits that lanes do not run are
/// found one by one.
pub(crate) fn multipliers<G: Shape>(
    shooting: &Shooting,
    set: InstructionSet,
    jobs: &[OrbitJob<Machine<G>>],
    go_on: &dyn Fn() -> bool,
) -> Vec<Orbit> {
    if !shooting.suits_lanes() {
        return jobs.iter().map(|job| close_one(shooting, job, go_on)).collect();
    }
    let mut found: Vec<Orbit> = jobs.iter().map(|_| None).collect();
    for equal in of_equal_shapes(jobs, |(job, _)| &job.model) {
        let leader = &jobs[equal[0]].0.model;
        let tape = tangent(&leader.record_shape().0, 2 * leader.dof(), &[]);
        match Program::new(&tape, leader.size().waves, &[]) {
            Ok(program) => side_by_side(shooting, set, &program, jobs, &equal, go_on, &mut found),
            Err(_) => equal.into_iter().for_each(|i| found[i] = close_one(shooting, &jobs[i], go_on)),
        }
    }
    found
}

/// An orbit that waits for a lane.
struct Prepared<'j> {
    index: usize,
    shooting: Shooting,
    segments: Segments<'j, dyn Model + 'j>,
}

/// The multipliers of machines of one shape; `chosen`: their jobs.
fn side_by_side<G: Shape>(
    settings: &Shooting,
    set: InstructionSet,
    program: &Program,
    jobs: &[OrbitJob<Machine<G>>],
    chosen: &[usize],
    go_on: &dyn Fn() -> bool,
    found: &mut [Orbit],
) {
    let meters: Vec<Meter<'_>> = chosen.iter().map(|_| settings.meter()).collect();
    let mut prepared = Vec::new();
    for (&index, meter) in chosen.iter().zip(&meters) {
        let (job, multiple) = &jobs[index];
        if !go_on() {
            return;
        }
        let shooting = settings.clone().period_multiple(*multiple);
        match shooting.one_segment(&job.model, &job.start, meter) {
            Ok(segments) => prepared.push((Prepared { index, shooting, segments }, meter)),
            Err(error) => found[index] = Some(Err(error)),
        }
    }
    let none = Expansion::none();
    let tolerance = settings.flow_tolerance;
    let mut flows: Vec<Tangent<'_, dyn Model + '_>> = Vec::new();
    for (orbit, _) in &prepared {
        let model: &dyn Model = &jobs[orbit.index].0.model;
        flows.push(Tangent::new(model, 2 * model.dof(), &[], orbit.segments.scale(), tolerance, &none));
    }
    let runs = flows.iter().zip(&prepared).map(|(flow, (Prepared { index, shooting, segments }, meter))| {
        let job = &jobs[*index].0;
        let closing = Closing::new(shooting, segments, flow, &job.start);
        TangentTask::new(flow, closing, meter, segments.end()).in_lane(*index, &job.model)
    });
    let finish =
        |task: OrbitTask<'_, '_>, outcome: Result<(), PursuitError>| task.pursuit.finish(outcome.err());
    let mut waiting = Waiting { runs, finish, found, go_on };
    let Some(first) = waiting.runs.next() else { return };
    let order = Taylor::order_for(tolerance);
    let waves = jobs[first.index].0.model.wave_series();
    let taylor = Taylor::new().rtol(NONE).order(order);
    let crew = Crew::new(&taylor, set, program, waves, order);
    run(crew, first, &mut waiting);
}

/// Makes the runs: compiled once, with the library.
#[inline(never)]
fn run<'m, 't: 'm>(
    mut crew: Crew<'_, 'm, OrbitTask<'m, 't>>,
    first: LaneJob<'m, OrbitTask<'m, 't>>,
    queue: &mut dyn Queue<'m, OrbitTask<'m, 't>>,
) {
    crew.run(first, queue);
}

/// The task of an orbit.
type OrbitTask<'m, 't> = TangentTask<'m, 't, Closing<'m, 't>>;
