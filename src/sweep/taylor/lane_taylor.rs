//! The engine that runs machines side by side with located edges: Taylor series in vector lanes.

use crate::model::shapes::compiled::Code;
use crate::model::{Machine, Model, Periodic, Shape};
use crate::ode::probe::ChannelKind;
use crate::ode::{IntegrateError, Taylor};
use crate::periodic::{Lyapunov, Shooting};
use crate::sweep::engines::batch::refuse;
use crate::sweep::engines::sweep_engine::{Exponent, Job, Orbit, OrbitJob, Source, SweepEngine, kinds};
use crate::sweep::engines::track::Plan;
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::sweep_error::{PointError, SweepError};
use crate::sweep::taylor::columns::W;
use crate::sweep::taylor::crew::Crew;
use crate::sweep::taylor::lane::Motion;
use crate::sweep::taylor::program::Program;
use crate::sweep::taylor::tangents::exponents::exponents;
use crate::sweep::taylor::tangents::orbits::multipliers;
use crate::sweep::taylor::tasks::row_task::RowTask;
use crate::sweep::taylor::tasks::task::{LaneJob, Queue};
use std::cell::OnceCell;
use std::collections::VecDeque;

/// Engine for every [`Machine`] with Taylor series: the runs of [`Located`](crate::sweep::Located) with
/// [`Taylor`], eight of them side by side in the lanes of the vector registers.
///
/// Each lane has its own time, step, pieces and edges. A lane that finds an edge ends its own step there; a
/// lane whose run is over takes the next point. Tolerances, edges of position, moving edges, rigid stops and
/// jumps of waves are those of `Taylor`. Two runs share lanes if and only if their [shapes](Shape) are equal.
///
/// Channels are those of [`LaneRk4`](crate::sweep::LaneRk4): coordinates, velocities, deflections and mesh
/// forces. Their integrals are those of the polynomials of the steps; extremes are found inside the steps.
/// A row depends on its point only, with a warm start on its line: its bits are the same for any
/// instruction set, number of threads, order and neighbouring lanes.
///
/// [Lyapunov exponents](crate::Sweep::lyapunov) and [multipliers](crate::Sweep::multipliers) are computed in
/// lanes, too: the flow with its derivative is the same engine on a larger tape.
///
/// A shape without series, or with a root or a power of something that varies (a contact of Hertz), gives the
/// error of its point: [`Located`](crate::sweep::Located) runs it.
///
/// ```
/// use gear_dynamics::sweep::{Axis, LaneTaylor, Located, bounds::SweepEngine};
/// use gear_dynamics::{NfgPair, NfgParams, Sweep, Taylor};
/// fn range(engine: &impl SweepEngine<NfgPair>) -> Result<f64, Box<dyn std::error::Error>> {
///     let speeds = Axis::linear("speed", 100.0, 130.0, 3)?;
///     let rows = Sweep::new(speeds).settle(1).measure(1).channels(&["q0"]).of(
///         engine,
///         |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
///     ).run()?;
///     Ok(rows.get(2)?.channel("q0")?.peak_to_peak())
/// }
/// let taylor = Taylor::new().rtol(1e-9).atol(1e-14);
/// let (lanes, located) = (range(&LaneTaylor::new(taylor.clone()))?, range(&Located(taylor))?);
/// assert!((lanes / located - 1.0).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct LaneTaylor {
    taylor: Taylor,
    set: InstructionSet,
}

/// Factor on the tolerances of a check `[1]`.
const TIGHTER: f64 = 0.01;

/// Models that are kept until all runs with them are over, per lane.
const KEPT: usize = 32;

impl LaneTaylor {
    /// An engine with these tolerances and limits. Default: [`InstructionSet::Best`].
    pub fn new(taylor: Taylor) -> Self {
        LaneTaylor { taylor, set: InstructionSet::Best }
    }
    /// The instruction set. Default: [`InstructionSet::Best`].
    pub fn instructions(self, set: InstructionSet) -> Self {
        LaneTaylor { set, ..self }
    }
}

impl<G: Shape> SweepEngine<Machine<G>> for LaneTaylor {
    fn accepts(&self, model: &Machine<G>, channels: &[usize]) -> Result<(), SweepError> {
        self.taylor.check_rtol()?;
        self.taylor.check(2 * model.dof())?;
        kinds(model, channels).map(|_| ())
    }
    fn finer(&self) -> Option<Self> {
        Some(LaneTaylor { taylor: self.taylor.finer(TIGHTER), ..self.clone() })
    }
    fn batch(&self) -> usize {
        W
    }
    fn exponents(
        &self,
        lyapunov: &Lyapunov,
        jobs: &[Job<Machine<G>>],
        go_on: &dyn Fn() -> bool,
    ) -> Vec<Exponent> {
        exponents(lyapunov, self.set, jobs, go_on)
    }
    fn multipliers(
        &self,
        shooting: &Shooting,
        jobs: &[OrbitJob<Machine<G>>],
        go_on: &dyn Fn() -> bool,
    ) -> Vec<Orbit> {
        multipliers(shooting, self.set, jobs, go_on)
    }
    fn exponents_at_once(&self) -> usize {
        KEPT * W
    }

    fn work(&self, plan: &Plan, channels: &[usize], source: &mut dyn Source<Machine<G>>) {
        let mut waiting = VecDeque::new();
        while !source.is_cancelled() {
            let Some(leader) = waiting.pop_front().or_else(|| source.next(None)) else { return };
            let settings = self.taylor.check(2 * leader.model.dof());
            let (Ok(kinds), Ok(settings)) = (kinds(&leader.model, channels), settings) else { return };
            let program = match program(&*leader.model, &kinds) {
                Ok(program) => program,
                Err(error) => {
                    waiting.extend(refuse(source, leader.index, error));
                    continue;
                }
            };
            let models: Vec<OnceCell<Machine<G>>> = (0..KEPT * W).map(|_| OnceCell::new()).collect();
            let (degree, atol) = settings;
            let mut shelf =
                Shelf { plan, atol: &atol, models: &models, taken: 0, waiting: &mut waiting, source };
            let Some(first) = shelf.keep(leader) else { continue };
            let waves = models.first().and_then(|model| model.get()?.wave_series());
            run(Crew::new(&self.taylor, self.set, &program, waves, degree), first, &mut shelf);
        }
    }
}

/// Makes the runs: compiled once, with the library.
#[inline(never)]
fn run<'m>(
    mut crew: Crew<'_, 'm, RowTask<'m>>,
    first: LaneJob<'m, RowTask<'m>>,
    queue: &mut dyn Queue<'m, RowTask<'m>>,
) {
    crew.run(first, queue);
}

/// The program of the shape of a model.
fn program(model: &dyn Code, kinds: &[ChannelKind]) -> Result<Program, PointError> {
    if let Some((output, what)) = model.record(&|_| false).0.kink() {
        return Err(IntegrateError::NoSeries { place: output.to_string(), what }.into());
    }
    let tape = model.record_shape().0;
    Program::new(&tape, model.size().waves, kinds).map_err(|what| PointError::NotInLanes { what })
}

/// The models of the runs in lanes, which stay where they are.
struct Shelf<'m, 's, G> {
    plan: &'s Plan,
    /// Absolute tolerance of each coordinate and velocity.
    atol: &'m [f64],
    models: &'m [OnceCell<Machine<G>>],
    taken: usize,
    /// Jobs that share no lanes with the first one, or for which there is no place left.
    waiting: &'s mut VecDeque<Job<Machine<G>>>,
    source: &'s mut dyn Source<Machine<G>>,
}

impl<'m, G: Shape> Shelf<'m, '_, G> {
    /// Keeps the model of a job; `None` if it shares no lanes with the first one or if the shelf is full: the
    /// job then waits.
    fn keep(&mut self, job: Job<Machine<G>>) -> Option<LaneJob<'m, RowTask<'m>>> {
        let shares = self.models[0].get().is_none_or(|first| first.shares_lanes_with(&job.model));
        let Some(cell) = self.models.get(self.taken).filter(|_| shares) else {
            self.waiting.push_back(job);
            return None;
        };
        self.taken += 1;
        let Job { index, model, start } = job;
        let model = cell.get_or_init(|| model);
        let (speed, until) = (model.speed(), model.period());
        let motion = Motion { model: &**model, expanded: &**model, speed, start, until };
        let task = RowTask::new(self.plan, model, &motion, self.atol);
        Some(LaneJob { index, motion, task })
    }

    /// The next run. `after` is a point that is done and its last state, empty after an error.
    fn next_after(&mut self, after: Option<(usize, &[f64])>) -> Option<LaneJob<'m, RowTask<'m>>> {
        let mut job = self.source.next(after);
        while let Some(next) = job {
            if let Some(kept) = self.keep(next) {
                return Some(kept);
            }
            if self.taken == self.models.len() {
                return None;
            }
            job = self.source.next(None);
        }
        // The shapes of jobs that wait may be that of the first one.
        let shares = |job: &Job<Machine<G>>| {
            self.models[0].get().is_some_and(|first| first.shares_lanes_with(&job.model))
        };
        let place = self.waiting.iter().position(shares)?;
        self.waiting.remove(place).and_then(|job| self.keep(job))
    }
}

impl<'m, G: Shape> Queue<'m, RowTask<'m>> for Shelf<'m, '_, G> {
    fn next(&mut self) -> Option<LaneJob<'m, RowTask<'m>>> {
        self.next_after(None)
    }
    fn over(
        &mut self,
        index: usize,
        task: RowTask<'m>,
        outcome: Result<(), PointError>,
    ) -> Option<LaneJob<'m, RowTask<'m>>> {
        match outcome {
            Ok(()) => {
                let (row, state) = task.finish();
                self.source.put(index, Ok((row, &state)));
                self.next_after(Some((index, &state)))
            }
            Err(error) => {
                self.source.put(index, Err(error));
                self.next_after(Some((index, &[])))
            }
        }
    }
    fn is_cancelled(&self) -> bool {
        self.source.is_cancelled()
    }
}
