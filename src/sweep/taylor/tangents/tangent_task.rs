//! A motion whose small differences are followed.

use crate::model::{Machine, Shape, State};
use crate::ode::budget::Meter;
use crate::periodic::flow::saltation::Saltation;
use crate::periodic::flow::tangent::Tangent;
use crate::periodic::pursuit::{Pursuit, PursuitError};
use crate::sweep::taylor::lane::{Lane, Motion};
use crate::sweep::taylor::tasks::task::{Ended, LaneJob, Task};

/// The exponents of a motion, or its orbit. Coordinates and velocities are those of a [`Tangent`]: the
/// motion, then its differences, which jump at edges.
pub(crate) struct TangentTask<'m, 't> {
    tangent: &'m Tangent<'t>,
    pursuit: &'m mut (dyn Pursuit + 'm),
    saltation: Saltation<'m>,
    meter: &'m Meter<'m>,
    atol: Vec<f64>,
    /// The time to which the flow runs.
    target: f64,
    /// Motion and differences at the start of the next step.
    state: State,
    /// The contact that rests at the start of the flow on an edge at which its stiffness or damping jumps,
    /// and the time of the start.
    rests: Option<(usize, f64)>,
}

impl<'m, 't> TangentTask<'m, 't> {
    /// `None` if the pursuit has no target.
    pub(crate) fn new(
        tangent: &'m Tangent<'t>,
        pursuit: &'m mut (dyn Pursuit + 'm),
        meter: &'m Meter<'m>,
    ) -> Option<Self> {
        let target = pursuit.target()?;
        let (mut saltation, mut state) = (Saltation::new(tangent), pursuit.state().clone());
        let rests = tangent.rests_at(&state);
        saltation.begin(&mut state);
        let atol = tangent.fixed_tolerances(pursuit.tolerance(), &state);
        Some(TangentTask { tangent, pursuit, saltation, meter, atol, target, state, rests })
    }

    /// The run of the task with the constants of a machine.
    pub(crate) fn in_lane<G: Shape>(self, index: usize, machine: &'m Machine<G>) -> LaneJob<'m, Self> {
        let (start, speed, until) = (self.state.clone(), machine.speed(), self.target);
        let motion = Motion { model: self.tangent, expanded: &**machine, speed, start, until };
        LaneJob { index, motion, task: self }
    }

    /// Applies the jump of the differences and the impact at once that may follow from it.
    fn jump(&mut self, lane: &mut Lane<'m>) {
        let (e, n) = (&mut lane.course.e, self.state.q.len());
        self.state.t = e.t;
        self.state.q.copy_from_slice(self.saltation.coordinates());
        self.state.v.copy_from_slice(self.saltation.velocities());
        self.saltation.begin(&mut self.state);
        e.y.slice_mut()[..n].copy_from_slice(&self.state.q);
        e.y.slice_mut()[n..].copy_from_slice(&self.state.v);
    }

    /// Takes the state at the target. Returns whether the run is over.
    fn arrive(&mut self, lane: &mut Lane<'m>, ended: Ended<'_>) -> Result<bool, PursuitError> {
        self.meter.left()?;
        let (e, n) = (&mut lane.course.e, self.state.q.len());
        self.state.t = e.t;
        self.state.q.copy_from_slice(&e.y.slice()[..n]);
        self.state.v.copy_from_slice(&e.y.slice()[n..]);
        self.tangent.leaves_rest(self.rests, &self.state)?;
        let accepted = self.pursuit.arrive(&self.state)?;
        let Some(target) = self.pursuit.target() else { return Ok(true) };
        let state = self.pursuit.state();
        self.target = target;
        self.rests = self.tangent.rests_at(state);
        if accepted {
            e.y.slice_mut()[..n].copy_from_slice(&state.q);
            e.y.slice_mut()[n..].copy_from_slice(&state.v);
            lane.course.passage.extend(target);
        } else {
            self.state.clone_from(state);
            self.saltation.begin(&mut self.state);
            lane.go_back(&self.state, target)?;
        }
        self.atol = self.tangent.fixed_tolerances(self.pursuit.tolerance(), state);
        ended.pace.set_lane(ended.view.lane, &self.atol);
        lane.attempts = 0;
        Ok(false)
    }
}

impl<'m> Task<'m> for TangentTask<'m, '_> {
    type Error = PursuitError;

    fn tolerances(&self) -> &[f64] {
        &self.atol
    }
    fn measures(&self) -> bool {
        false
    }
    fn end(&mut self, lane: &mut Lane<'m>, ended: Ended<'_>) -> Result<bool, PursuitError> {
        self.meter.spend()?;
        let saltation = &mut self.saltation;
        let jumps = lane.show(&ended.view, ended.at_edge, |step| saltation.changes(step));
        if let Some(refused) = &saltation.refused {
            return Err(refused.clone().into());
        }
        lane.pass(ended.at_edge)?;
        if jumps {
            self.jump(lane);
        }
        if lane.course.e.t < self.target { Ok(false) } else { self.arrive(lane, ended) }
    }
}
