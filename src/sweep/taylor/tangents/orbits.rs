//! Multipliers of many orbits, side by side.

use crate::model::{Machine, Model, Shape};
use crate::ode::budget::Meter;
use crate::periodic::flow::flow_method::Expansion;
use crate::periodic::flow::tangent::Tangent;
use crate::periodic::shooting::closing::Closing;
use crate::periodic::shooting::multiple::Shooting;
use crate::periodic::shooting::segments::Segments;
use crate::sweep::engines::sweep_engine::{Orbit, OrbitJob, close_one};
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::taylor::program::Program;
use crate::sweep::taylor::tangents::by_shape::by_shape;
use crate::sweep::taylor::tangents::tangent_task::TangentTask;
use crate::sweep::taylor::tangents::waiting::Waiting;

/// The multipliers of the orbits near motions of machines: shooting with the flow and its derivative in
/// lanes, each orbit in one segment. Machines of equal shapes share lanes. Orbits that lanes do not run are
/// found one by one.
pub(crate) fn multipliers<G: Shape>(
    shooting: &Shooting,
    set: InstructionSet,
    jobs: &[OrbitJob<Machine<G>>],
    go_on: &dyn Fn() -> bool,
) -> Vec<Orbit> {
    let one = |job: &OrbitJob<Machine<G>>| close_one(shooting, job, go_on);
    if !shooting.suits_lanes() {
        return jobs.iter().map(one).collect();
    }
    let in_lanes = |program: &Program, chosen: &[usize], found: &mut [Orbit]| {
        side_by_side(shooting, set, program, jobs, chosen, go_on, found);
    };
    by_shape(jobs, |(job, _)| &job.model, |dof| 2 * dof, in_lanes, one)
}

/// An orbit that waits for a lane.
struct Prepared<'j> {
    index: usize,
    shooting: Shooting,
    segments: Segments<'j>,
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
    let meters: Vec<Meter<'_>> = chosen.iter().map(|_| settings.meter(go_on)).collect();
    let mut prepared = Vec::new();
    for (&index, meter) in chosen.iter().zip(&meters) {
        let (job, multiple) = &jobs[index];
        if !go_on() {
            return;
        }
        let shooting = settings.clone().period_multiple(*multiple);
        match shooting.one_segment(&job.model, &job.start, meter) {
            Ok(segments) => prepared.push((Prepared { index, shooting, segments }, meter)),
            Err(_) if !go_on() => return,
            Err(error) => found[index] = Some(Err(error)),
        }
    }
    let none = Expansion::none();
    let tolerance = settings.flow_tolerance;
    let mut flows: Vec<Tangent<'_>> = Vec::new();
    for (orbit, _) in &prepared {
        let model: &dyn Model = &jobs[orbit.index].0.model;
        flows.push(Tangent::new(model, 2 * model.dof(), &[], orbit.segments.scale(), tolerance, &none));
    }
    let mut pursuits = Vec::new();
    for (flow, (Prepared { index, shooting, segments }, _)) in flows.iter().zip(&prepared) {
        pursuits.push(Closing::new(shooting, segments, flow, &jobs[*index].0.start));
    }
    let waiting = pursuits.iter_mut().zip(flows.iter().zip(&prepared)).enumerate();
    let mut runs = waiting.map_while(|(number, (closing, (flow, (orbit, meter))))| {
        Some(TangentTask::new(flow, closing, meter)?.in_lane(number, &jobs[orbit.index].0.model))
    });
    let waves = jobs[chosen[0]].0.model.wave_series();
    let outcomes = Waiting::new(&mut runs, flows.len(), go_on).run_all(set, program, tolerance, waves);
    for (closing, (outcome, (orbit, _))) in pursuits.into_iter().zip(outcomes.into_iter().zip(&prepared)) {
        found[orbit.index] = outcome.map(|outcome| closing.finish(outcome.err()));
    }
}
