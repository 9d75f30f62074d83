//! Fixed-step engines over a table of drives.

use super::engine::{Job, Source, SweepEngine, kinds};
use super::error::{PointError, SweepError};
use super::track::{Next, Plan, Track};
use crate::lanes::{Algebra, Bundle, InstructionSet, Kernel, Kind, Lanes, Meters, Number, Plain, Reading, Shared, Table, TableError};
use crate::model::{Contact, Generic, Periodic};
use std::collections::VecDeque;

/// Steps between two looks at whether the sweep is cancelled.
const STRETCH: usize = 64;

/// RK4 with a fixed number of steps per period, W runs side by side in the lanes of the processor's vectors: the drives come from a table
/// that is made once for all runs. For models that are [`Generic`] and [`Periodic`]; two runs share lanes only if the models say so
/// ([`Generic::shares_lanes_with`]), and one that shares with no other runs alone.
///
/// Steps go straight across tooth edges, as RK4 of the papers do; 64 steps in the shortest period of a drive keep that error small, and
/// [`check_every`](crate::Sweep::check_every) measures it. Jumps of the drives have to fall on whole steps: a model where they
/// do not gets a [`TableError::EdgeOffGrid`]. A row is a function of its point alone: the same bits for any W, instructions, threads, order
/// and neighbours. W = 16 suits all; 32 is faster for one or two degrees of freedom and for small rings, 8 for a ring of 16.
///
/// ```
/// use gear_dynamics::{InstructionSet, LaneRk4};
/// let engine = LaneRk4::<16>::new(63 * 64).instructions(InstructionSet::Baseline);
/// assert_eq!(engine.steps(), 4032);
/// ```
///
/// A model without a period does not compile, nor does one that is not generic:
///
/// ```compile_fail,E0277
/// use gear_dynamics::{Axis, LaneRk4, Model, ParameterError, Points, State, Sweep};
/// struct Rest;
/// impl Model for Rest {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) { a[0] = 0.0; }
/// }
/// let points = Points::along(Axis::list("x", &[1.0])?);
/// let start = |_: &_, _: &_| Ok::<_, ParameterError>(State::at_rest(1));
/// Sweep::over(points).run(&LaneRk4::<16>::new(64), |_| Ok::<_, ParameterError>(Rest), start)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneRk4<const W: usize> {
    steps: usize,
    set: InstructionSet,
}

impl<const W: usize> LaneRk4<W> {
    /// Steps per period of the model.
    pub fn new(steps: usize) -> Self {
        LaneRk4 { steps, set: InstructionSet::Best }
    }
    /// Other instructions than the best.
    pub fn instructions(self, set: InstructionSet) -> Self {
        LaneRk4 { set, ..self }
    }
    /// Steps per period.
    pub fn steps(&self) -> usize {
        self.steps
    }
}

impl<const W: usize, M: Generic + Periodic> SweepEngine<M> for LaneRk4<W> {
    fn accepts(&self, model: &M, channels: &[usize]) -> Result<(), SweepError> {
        check_steps(self.steps)?;
        kinds(model, channels).map(|_| ())
    }
    fn finer(&self) -> Option<Self> {
        Some(LaneRk4 { steps: 4 * self.steps, ..*self })
    }
    fn batch(&self) -> usize {
        W
    }

    fn work(&self, plan: &Plan, channels: &[usize], source: &mut dyn Source<M>) {
        let mut waiting = VecDeque::new();
        while !source.is_cancelled() {
            let Some(leader) = waiting.pop_front().or_else(|| source.next(None)) else {
                return;
            };
            let table = match Table::of_shapes(&leader.model, self.steps) {
                Ok(table) => table,
                Err(error) => {
                    source.put(leader.index, Err(error.into()));
                    continue;
                }
            };
            let Ok(kinds) = kinds(&leader.model, channels) else { return };
            if plan.layout.contacts > 0 && !offers_contacts(&leader.model) {
                source.put(leader.index, Err(PointError::NoContacts));
                continue;
            }
            // As many as there are lanes, of those that share them.
            let mut first: Vec<Job<M>> = Vec::with_capacity(W);
            let (model, mut pending) = (&leader.model, Vec::new());
            let shares = |job: &Job<M>| model.shares_lanes_with(&job.model);
            for job in std::mem::take(&mut waiting) {
                if first.len() + 1 < W && shares(&job) { first.push(job) } else { pending.push(job) }
            }
            while first.len() + 1 < W
                && let Some(job) = source.next(None)
            {
                if shares(&job) { first.push(job) } else { pending.push(job) }
            }
            waiting.extend(pending);
            let mut batch = Batch { plan, table: &table, kinds: &kinds, set: self.set, shares: &shares, waiting: &mut waiting, source };
            let (index, start) = (leader.index, &leader.start);
            let load = (index, Loaded::of(&leader.model), start.q.as_slice(), start.v.as_slice());
            if first.is_empty() {
                batch.source.alone(1);
                batch.run::<f64, _>(&Shared(&leader.model), load, first);
            } else {
                batch.run::<Lanes<W>, _>(&Shared(&leader.model), load, first);
            }
        }
    }
}

/// RK4 with a fixed number of steps per period for any periodic model, one run at a time over a table of all its drives. Otherwise as
/// [`LaneRk4`].
///
/// ```
/// assert_eq!(gear_dynamics::TableRk4::new(4032).steps(), 4032);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableRk4 {
    steps: usize,
}

impl TableRk4 {
    /// Steps per period of the model.
    pub fn new(steps: usize) -> Self {
        TableRk4 { steps }
    }
    /// Steps per period.
    pub fn steps(&self) -> usize {
        self.steps
    }
}

impl<M: Periodic> SweepEngine<M> for TableRk4 {
    fn accepts(&self, model: &M, channels: &[usize]) -> Result<(), SweepError> {
        check_steps(self.steps)?;
        kinds(model, channels).map(|_| ())
    }
    fn finer(&self) -> Option<Self> {
        Some(TableRk4 { steps: 4 * self.steps })
    }

    fn work(&self, plan: &Plan, channels: &[usize], source: &mut dyn Source<M>) {
        let mut waiting = VecDeque::new();
        while !source.is_cancelled() {
            let Some(job) = waiting.pop_front().or_else(|| source.next(None)) else {
                return;
            };
            let Job { index, model, start } = job;
            let Ok(kinds) = kinds(&model, channels) else { return };
            match Table::of_drives(&model, self.steps) {
                Err(error) => source.put(index, Err(error.into())),
                Ok(table) => {
                    let never = |_: &Job<M>| false;
                    let set = InstructionSet::Baseline;
                    let mut batch = Batch { plan, table: &table, kinds: &kinds, set, shares: &never, waiting: &mut waiting, source };
                    let loaded = Loaded { period: model.period(), constants: Vec::new() };
                    batch.run_plain(&Plain(&model), (index, loaded, &start.q, &start.v));
                }
            }
        }
    }
}

fn check_steps(steps: usize) -> Result<(), SweepError> {
    // A quarter of what the meters can count, for `finer`.
    let allowed = "at least 1 and below 2^24";
    if (1..1 << 24).contains(&steps) { Ok(()) } else { Err(SweepError::Setting { name: "steps per period", value: steps as f64, allowed }) }
}

fn offers_contacts<M: Generic>(model: &M) -> bool {
    let (n, contacts) = (model.dof(), model.contacts());
    let mut out = vec![Contact::default(); contacts];
    model.contact_on(0..contacts, &vec![1.0; model.drives()], &vec![0.0; n], &vec![0.0; n], &mut out)
}

/// What a lane needs of its model.
struct Loaded {
    period: f64,
    /// All drives, those of this lane filled in.
    constants: Vec<f64>,
}

impl Loaded {
    fn of<M: Generic + Periodic>(model: &M) -> Self {
        let mut constants = vec![0.0; model.drives()];
        model.constants(&mut constants);
        constants.drain(..model.phases());
        Loaded { period: model.period(), constants }
    }
}

/// A run in a lane.
struct Slot {
    index: usize,
    track: Track,
}

type Load<'j> = (usize, Loaded, &'j [f64], &'j [f64]);

/// Runs over one table.
struct Batch<'a, M> {
    plan: &'a Plan,
    table: &'a Table,
    kinds: &'a [Kind],
    set: InstructionSet,
    shares: &'a dyn Fn(&Job<M>) -> bool,
    /// Runs that need another table.
    waiting: &'a mut VecDeque<Job<M>>,
    source: &'a mut dyn Source<M>,
}

impl<M: Periodic> Batch<'_, M> {
    fn bundle<S: Number, A: Algebra<S>>(&self, algebra: &A) -> Bundle<S> {
        Bundle::new(algebra, self.table, Meters::new(self.kinds, self.plan.layout.contacts, true))
    }

    /// One run of any model.
    fn run_plain<A: Algebra<f64>>(&mut self, algebra: &A, load: Load<'_>) {
        let mut bundle = self.bundle::<f64, _>(algebra);
        let mut slots = [Some(self.load(&mut bundle, 0, load))];
        while let [Some(slot)] = &slots {
            bundle.metered = slot.track.watching();
            if !self.period(algebra, &mut bundle) {
                return;
            }
            if let Some((index, state)) = self.account(&mut bundle, &mut slots[0], 0)
                && let Some(job) = self.source.next(Some((index, &state)))
            {
                self.waiting.push_back(job);
            }
        }
    }

    fn load<S: Number>(&self, bundle: &mut Bundle<S>, lane: usize, (index, loaded, q, v): Load<'_>) -> Slot {
        let drives = bundle.u.len();
        for (u, x) in bundle.u[drives - loaded.constants.len()..].iter_mut().zip(&loaded.constants) {
            u.set_lane(lane, *x);
        }
        bundle.step.set_lane(lane, loaded.period / self.table.steps() as f64);
        bundle.q.iter_mut().zip(q).for_each(|(x, q)| x.set_lane(lane, *q));
        bundle.v.iter_mut().zip(v).for_each(|(x, v)| x.set_lane(lane, *v));
        bundle.meters.restart(lane);
        Slot { index, track: Track::new(self.plan, q, v) }
    }

    /// One period of all lanes. `false`: cancelled.
    fn period<S: Number, A: Algebra<S>>(&mut self, algebra: &A, bundle: &mut Bundle<S>) -> bool {
        let steps = self.table.steps();
        let mut from = 0;
        while from < steps {
            let to = (from + STRETCH).min(steps);
            Kernel { algebra, table: self.table, steps: from..to, bundle }.run(self.set);
            if self.source.is_cancelled() {
                return false;
            }
            from = to;
        }
        true
    }

    /// What a period did to one lane. The state of a run that is over, if its line goes on.
    fn account<S: Number>(&mut self, bundle: &mut Bundle<S>, slot: &mut Option<Slot>, lane: usize) -> Option<(usize, Vec<f64>)> {
        let run = slot.as_mut()?;
        let weight = self.table.steps() as f64;
        if run.track.measuring() {
            bundle.meters.read(lane, |reading| match reading {
                Reading::Channel(i, meter) => run.track.add_channel(i, &meter),
                Reading::Contact(i, meter) => run.track.add_contact(i, &meter, weight),
            });
        }
        let state = bundle.q.iter().chain(&bundle.v).map(|x| x.lane(lane));
        match run.track.period(weight, state) {
            Next::Settle | Next::Measure => None,
            Next::StartMeasuring => {
                bundle.meters.clear(lane);
                None
            }
            Next::Done => {
                let Slot { index, track } = slot.take()?;
                let (row, state) = track.finish();
                self.source.put(index, Ok((row, &state)));
                Some((index, state))
            }
            Next::Diverged => {
                let Slot { index, track } = slot.take()?;
                // Numbers that are none would slow the other lanes down.
                bundle.q.iter_mut().chain(&mut bundle.v).for_each(|x| x.set_lane(lane, 0.0));
                self.source.put(index, Err(PointError::Diverged { period: track.periods }));
                Some((index, Vec::new()))
            }
        }
    }
}

impl<M: Generic + Periodic> Batch<'_, M> {
    /// Runs of generic models, each lane refilled as it finishes.
    fn run<S: Number, A: Algebra<S>>(&mut self, algebra: &A, load: Load<'_>, jobs: Vec<Job<M>>) {
        let mut bundle = self.bundle::<S, _>(algebra);
        let mut slots: Vec<Option<Slot>> = (0..S::WIDTH).map(|_| None).collect();
        slots[0] = Some(self.load(&mut bundle, 0, load));
        for (i, job) in jobs.into_iter().enumerate() {
            slots[1 + i] = Some(self.load_job(&mut bundle, 1 + i, &job));
        }
        while slots.iter().any(Option::is_some) {
            bundle.metered = slots.iter().flatten().any(|slot| slot.track.watching());
            if !self.period(algebra, &mut bundle) {
                return;
            }
            for (lane, slot) in slots.iter_mut().enumerate() {
                let over = self.account(&mut bundle, slot, lane);
                let mut after = over.as_ref().map(|(index, state)| (*index, state.as_slice()));
                if after.is_some() {
                    while let Some(job) = self.source.next(after.take()) {
                        if (self.shares)(&job) {
                            *slot = Some(self.load_job(&mut bundle, lane, &job));
                            break;
                        }
                        self.waiting.push_back(job);
                    }
                }
            }
        }
    }

    fn load_job<S: Number>(&self, bundle: &mut Bundle<S>, lane: usize, job: &Job<M>) -> Slot {
        let loaded = Loaded::of(&job.model);
        self.load(bundle, lane, (job.index, loaded, &job.start.q, &job.start.v))
    }
}

impl From<TableError> for SweepError {
    fn from(error: TableError) -> Self {
        match error {
            TableError::NoSteps => SweepError::Setting { name: "steps per period", value: 0.0, allowed: "at least 1" },
            _ => SweepError::Setting { name: "table", value: f64::NAN, allowed: "made of finite drives" },
        }
    }
}
