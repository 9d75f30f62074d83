//! Engines with a fixed step: RK4 over a table of drives.

use crate::model::equations::{Model, Periodic, State};
use crate::model::machine::Machine;
use crate::model::rigid_stops::first_stop;
use crate::model::shape::Shape;
use crate::ode::error::IntegrateError;
use crate::sweep::engines::interface::{Job, Source, SweepEngine, kinds};
use crate::sweep::engines::track::{Next, Plan, Track};
use crate::sweep::error::{PointError, SweepError};
use crate::sweep::lanes::drive_table::{Table, TableError};
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::lanes::kernel::{Algebra, Bundle, Kernel, Plain, Shared};
use crate::sweep::lanes::meter::{Kind, Meters, Reading};
use crate::sweep::lanes::number::{Lanes, Number};
use std::collections::VecDeque;

/// Number of steps between two checks for cancellation.
const STRETCH: usize = 64;

/// Approximate number of states sampled within a period to find the range of the motion. The steps between
/// them are irregular, so that no frequency of the motion is aliased.
const LOOKS: usize = 48;

/// Engine for every [`Machine`]: RK4 with a fixed number of steps per period, W runs side by side in the
/// lanes of the vector registers.
///
/// The drives come from a table that is computed once for all runs that share lanes. Two runs share lanes if
/// and only if their [shapes](Shape) are equal. A run whose shape no other run has runs alone.
///
/// Steps cross the edges of contacts without locating them, as in the papers (Liu 2021, Yao 2020). 64 steps
/// in the shortest period of a drive keep this error small; [`check_every`](crate::Sweep::check_every)
/// measures it. Drive edges must fall on whole steps, else the point fails with [`TableError::EdgeOffGrid`].
/// A row depends on its point only, with a warm start on its line: its bits are the same for any W,
/// instruction set, number of threads, order and neighbouring lanes. W = 16 suits all models. W = 32 is
/// faster for one or two degrees of freedom and for small rings, W = 8 for a ring of 16.
///
/// ```
/// use gear_dynamics::sweep::{Axis, InstructionSet, LaneRk4, Points, SweepEngine};
/// use gear_dynamics::{NfgPair, NfgParams, Sweep};
/// fn fingerprint(engine: &impl SweepEngine<NfgPair>) -> Result<u64, Box<dyn std::error::Error>> {
///     let speeds = Points::along(Axis::linear("speed", 100.0, 130.0, 6)?);
///     let rows = Sweep::over(speeds).settle(0).measure(1).channels(&["q1"]).run(
///         engine,
///         |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
///         |_, pair| pair.static_start(),
///     )?;
///     Ok(rows.fingerprint())
/// }
/// let eight = LaneRk4::<8>::new(63 * 16);
/// let four = LaneRk4::<4>::new(63 * 16).instructions(InstructionSet::Baseline);
/// assert_eq!(eight.steps(), 1008);
/// assert_eq!(fingerprint(&eight)?, fingerprint(&four)?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// A model that is not a [`Machine`] does not compile:
///
/// ```compile_fail,E0277
/// use gear_dynamics::{sweep::{Axis, LaneRk4, Points}, Model, ParameterError, State, Sweep};
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
    /// An engine with this number of steps per period of the model. Default: [`InstructionSet::Best`].
    pub fn new(steps: usize) -> Self {
        LaneRk4 { steps, set: InstructionSet::Best }
    }
    /// The instruction set. Default: [`InstructionSet::Best`].
    pub fn instructions(self, set: InstructionSet) -> Self {
        LaneRk4 { set, ..self }
    }
    /// Steps per period of the model.
    pub fn steps(&self) -> usize {
        self.steps
    }
}

impl<const W: usize, G: Shape> SweepEngine<Machine<G>> for LaneRk4<W> {
    fn accepts(&self, model: &Machine<G>, channels: &[usize]) -> Result<(), SweepError> {
        Table::check_size(self.steps, model.size().waves)?;
        kinds(model, channels).map(|_| ())
    }
    fn finer(&self) -> Option<Self> {
        Some(LaneRk4 { steps: self.steps.saturating_mul(4), ..*self })
    }
    fn batch(&self) -> usize {
        W
    }

    fn work(&self, plan: &Plan, channels: &[usize], source: &mut dyn Source<Machine<G>>) {
        let mut waiting = VecDeque::new();
        while !source.is_cancelled() {
            let Some(leader) = waiting.pop_front().or_else(|| source.next(None)) else {
                return;
            };
            let Ok(kinds) = kinds(&leader.model, channels) else { return };
            let (table, run) = match lead(&leader, self.steps, source) {
                Ok(Some(lead)) => lead,
                Ok(None) => return,
                Err(error) => {
                    waiting.extend(refuse(source, leader.index, error));
                    continue;
                }
            };
            // Up to W runs that share lanes with the first one.
            let (mut runs, mut pending) = (vec![run], Vec::new());
            let mut drawn = std::mem::take(&mut waiting);
            let shares = |job: &Job<Machine<G>>| leader.model.shares_lanes_with(&job.model);
            while runs.len() < W
                && let Some(job) = drawn.pop_front().or_else(|| source.next(None))
            {
                if !shares(&job) {
                    pending.push(job);
                    continue;
                }
                match Run::of(&job) {
                    Ok(run) => runs.push(run),
                    Err(error) => drawn.extend(refuse(source, job.index, error)),
                }
            }
            waiting.extend(pending.into_iter().chain(drawn));
            let mut batch = Batch {
                plan,
                table: &table,
                kinds: &kinds,
                set: self.set,
                shares: &shares,
                waiting: &mut waiting,
                source,
            };
            if runs.len() == 1 {
                batch.run::<f64, _>(&Shared(leader.model.shape()), &runs);
            } else {
                batch.run::<Lanes<W>, _>(&Shared(leader.model.shape()), &runs);
            }
        }
    }
}

/// The table of a job and the job's run over it; `None` if cancelled.
fn lead<G: Shape>(
    job: &Job<Machine<G>>,
    steps: usize,
    source: &dyn Source<Machine<G>>,
) -> Result<Option<(Table, Run)>, PointError> {
    let run = Run::of(job)?;
    let table = Table::of_waves(&job.model, steps, || !source.is_cancelled())?;
    Ok(table.map(|table| (table, run)))
}

/// Stores the error of a run that cannot be made. Returns the next job of its line, if any.
fn refuse<M>(source: &mut dyn Source<M>, index: usize, error: PointError) -> Option<Job<M>> {
    source.put(index, Err(error));
    source.next(Some((index, &[])))
}

/// Engine for any periodic model: RK4 with a fixed number of steps per period, one run at a time over a table
/// of all drives of the model. Edges are treated as by [`LaneRk4`].
///
/// ```
/// use gear_dynamics::sweep::{Axis, Points, TableRk4};
/// use gear_dynamics::{Model, ParameterError, Periodic, State, Sweep};
/// struct Swing(f64); // q'' + 3 q' + 2 q = f cos 2t
/// impl Model for Swing {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, u: &[f64], q: &[f64], v: &[f64], a: &mut [f64]) {
///         a[0] = self.0 * (2.0 * u[0]).cos() - 3.0 * v[0] - 2.0 * q[0];
///     }
/// }
/// impl Periodic for Swing {
///     fn period(&self) -> f64 { std::f64::consts::PI }
/// }
/// let amplitudes = Points::along(Axis::list("f", &[1.0, 4.0])?);
/// let rows = Sweep::over(amplitudes).settle(20).measure(1).channels(&["q1"]).run(
///     &TableRk4::new(64),
///     |p| Ok::<_, ParameterError>(Swing(p["f"])),
///     |_, _| Ok::<_, ParameterError>(State::at_rest(1)),
/// )?;
/// // Closed form: q = f (3 sin 2t - cos 2t)/20, RMS = f √5/20.
/// assert!((rows.get(1)?.channel("q1")?.rms - 5f64.sqrt() / 5.0).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableRk4 {
    steps: usize,
}

impl TableRk4 {
    /// An engine with this number of steps per period of the model.
    pub fn new(steps: usize) -> Self {
        TableRk4 { steps }
    }
    /// Steps per period of the model.
    pub fn steps(&self) -> usize {
        self.steps
    }
}

impl<M: Periodic> SweepEngine<M> for TableRk4 {
    fn accepts(&self, model: &M, channels: &[usize]) -> Result<(), SweepError> {
        Table::check_size(self.steps, model.drives())?;
        kinds(model, channels).map(|_| ())
    }
    fn finer(&self) -> Option<Self> {
        Some(TableRk4 { steps: self.steps.saturating_mul(4) })
    }

    fn work(&self, plan: &Plan, channels: &[usize], source: &mut dyn Source<M>) {
        let mut waiting = VecDeque::new();
        while !source.is_cancelled() {
            let Some(Job { index, model, start }) = waiting.pop_front().or_else(|| source.next(None)) else {
                return;
            };
            let Ok(kinds) = kinds(&model, channels) else { return };
            if let Err(error) = refuse_stops(&model) {
                waiting.extend(refuse(source, index, error));
                continue;
            }
            match Table::of_drives(&model, self.steps, || !source.is_cancelled()) {
                Err(error) => waiting.extend(refuse(source, index, error.into())),
                Ok(None) => return,
                Ok(Some(table)) => {
                    let never = |_: &Job<M>| false;
                    let set = InstructionSet::Baseline;
                    let run = Run { index, start, period: model.period(), constants: Vec::new() };
                    let mut batch = Batch {
                        plan,
                        table: &table,
                        kinds: &kinds,
                        set,
                        shares: &never,
                        waiting: &mut waiting,
                        source,
                    };
                    batch.run_plain(&Plain(&model), &run);
                }
            }
        }
    }
}

/// Refuses a model with a rigid stop: an impact needs a located edge, and fixed steps do not locate edges.
fn refuse_stops<M: Model>(model: &M) -> Result<(), PointError> {
    match first_stop(model) {
        Some(contact) => Err(IntegrateError::StopNotLocated { contact }.into()),
        None => Ok(()),
    }
}

/// The data of a job that its lane needs.
struct Run {
    index: usize,
    start: State,
    period: f64,
    /// The drives that differ from lane to lane; they are constant in time.
    constants: Vec<f64>,
}

impl Run {
    fn of<G: Shape>(job: &Job<Machine<G>>) -> Result<Self, PointError> {
        let (model, constants) = (&job.model, job.model.own_drives());
        refuse_stops(model)?;
        if let Some(bad) = constants.iter().position(|x| !x.is_finite()) {
            return Err(TableError::NotFinite {
                drive: model.size().waves + bad,
                value: constants[bad],
                phase: 0.0,
            }
            .into());
        }
        Ok(Run { index: job.index, start: job.start.clone(), period: model.period(), constants })
    }
}

/// Length of stretch `k` of a period in steps: 1 + round(2 (m - 1) frac(k/φ)), with mean m =
/// max(floor(steps/[`LOOKS`]), 1) and golden ratio φ. The lengths are evenly distributed about m and do not
/// repeat.
fn irregular(steps: usize, k: f64) -> usize {
    let mean = (steps / LOOKS).max(1) as f64;
    1 + ((k * 0.618_033_988_749_894_9).fract() * 2.0 * (mean - 1.0)).round() as usize
}

/// The run that occupies a lane.
struct Slot {
    index: usize,
    track: Track,
}

/// Runs over the same table.
struct Batch<'a, M> {
    plan: &'a Plan,
    table: &'a Table,
    kinds: &'a [Kind],
    set: InstructionSet,
    shares: &'a dyn Fn(&Job<M>) -> bool,
    /// Jobs that need another table.
    waiting: &'a mut VecDeque<Job<M>>,
    source: &'a mut dyn Source<M>,
}

impl<M: Periodic> Batch<'_, M> {
    fn bundle<S: Number, A: Algebra<S>>(&self, algebra: &A) -> Bundle<S> {
        Bundle::new(algebra, self.table, Meters::new(self.kinds, self.plan.layout.contacts))
    }

    /// One run of a model that need not be a [`Machine`].
    fn run_plain<A: Algebra<f64>>(&mut self, algebra: &A, run: &Run) {
        let mut bundle = self.bundle::<f64, _>(algebra);
        let mut slots = [Some(self.load(&mut bundle, 0, run))];
        while let [Some(slot)] = &slots {
            bundle.metered = slot.track.watching();
            if !self.period(algebra, &mut bundle, &mut slots) {
                return;
            }
            if let Some((index, state)) = self.account(&mut bundle, &mut slots[0], 0)
                && let Some(job) = self.source.next(Some((index, &state)))
            {
                self.waiting.push_back(job);
            }
        }
    }

    /// Puts the start, the step and the constant drives of a run into a lane.
    fn load<S: Number>(&self, bundle: &mut Bundle<S>, lane: usize, run: &Run) -> Slot {
        let (drives, State { q, v, .. }) = (bundle.u.len(), &run.start);
        for (u, x) in bundle.u[drives - run.constants.len()..].iter_mut().zip(&run.constants) {
            u.set_lane(lane, *x);
        }
        bundle.step.set_lane(lane, run.period / self.table.steps() as f64);
        bundle.q.iter_mut().zip(q).for_each(|(x, q)| x.set_lane(lane, *q));
        bundle.v.iter_mut().zip(v).for_each(|(x, v)| x.set_lane(lane, *v));
        bundle.meters.restart(lane);
        Slot { index: run.index, track: Track::new(self.plan, q, v) }
    }

    /// Advances all lanes by one period. Returns `false` if cancelled.
    fn period<S: Number, A: Algebra<S>>(
        &mut self,
        algebra: &A,
        bundle: &mut Bundle<S>,
        slots: &mut [Option<Slot>],
    ) -> bool {
        let steps = self.table.steps();
        let ranging = slots.iter().flatten().any(|slot| slot.track.ranging());
        let (mut from, mut looks) = (0, 0.0);
        while from < steps {
            let stretch = if ranging { irregular(steps, looks) } else { STRETCH };
            let to = (from + stretch).min(steps);
            Kernel { algebra, table: self.table, steps: from..to, bundle }.run(self.set);
            if self.source.is_cancelled() {
                return false;
            }
            for (lane, slot) in slots.iter_mut().enumerate() {
                if let Some(slot) = slot.as_mut().filter(|slot| slot.track.ranging()) {
                    slot.track.see_state(bundle.q.iter().chain(&bundle.v).map(|x| x.lane(lane)));
                }
            }
            (from, looks) = (to, looks + 1.0);
        }
        true
    }

    /// Evaluates a period of one lane. If its run is over, stores the row or the error and returns the index
    /// of the point and its last state (empty after an error).
    fn account<S: Number>(
        &mut self,
        bundle: &mut Bundle<S>,
        slot: &mut Option<Slot>,
        lane: usize,
    ) -> Option<(usize, Vec<f64>)> {
        let run = slot.as_mut()?;
        let weight = self.table.steps() as f64;
        if run.track.measuring() {
            bundle.meters.read(lane, |reading| match reading {
                Reading::Channel(i, meter) => run.track.add_channel(i, &meter, weight),
                Reading::Contact(i, meter) => run.track.add_contact(i, &meter, weight),
            });
        }
        let state = bundle.q.iter().chain(&bundle.v).map(|x| x.lane(lane));
        let index = run.index;
        match run.track.period(weight, state, &|| self.source.rigid(index)) {
            Next::Settle | Next::Measure => None,
            Next::StartMeasuring => {
                bundle.meters.clear(lane);
                None
            }
            Next::Done => {
                let Slot { index, track } = slot.take()?;
                let (row, state) = track.finish(&|| self.source.rigid(index));
                self.source.put(index, Ok((row, &state)));
                Some((index, state))
            }
            Next::Diverged => {
                let Slot { index, track } = slot.take()?;
                // NaN or infinity in this lane would slow the other lanes down.
                bundle.q.iter_mut().chain(&mut bundle.v).for_each(|x| x.set_lane(lane, 0.0));
                self.source.put(index, Err(PointError::Diverged { period: track.periods }));
                Some((index, Vec::new()))
            }
        }
    }
}

impl<G: Shape> Batch<'_, Machine<G>> {
    /// Runs of machines. A lane whose run is over takes the next job that shares lanes; other jobs wait.
    fn run<S: Number, A: Algebra<S>>(&mut self, algebra: &A, runs: &[Run]) {
        let mut bundle = self.bundle::<S, _>(algebra);
        let mut slots: Vec<Option<Slot>> = (0..S::WIDTH).map(|_| None).collect();
        for ((lane, slot), run) in slots.iter_mut().enumerate().zip(runs) {
            *slot = Some(self.load_one(&mut bundle, lane, run));
        }
        while slots.iter().any(Option::is_some) {
            bundle.metered = slots.iter().flatten().any(|slot| slot.track.watching());
            if !self.period(algebra, &mut bundle, &mut slots) {
                return;
            }
            for (lane, slot) in slots.iter_mut().enumerate() {
                let Some((index, state)) = self.account(&mut bundle, slot, lane) else { continue };
                let mut next = self.source.next(Some((index, &state)));
                while let Some(job) = next {
                    if !(self.shares)(&job) {
                        self.waiting.push_back(job);
                        next = self.source.next(None);
                        continue;
                    }
                    next = match Run::of(&job) {
                        Ok(run) => {
                            *slot = Some(self.load_one(&mut bundle, lane, &run));
                            None
                        }
                        Err(error) => refuse(self.source, job.index, error),
                    };
                }
            }
        }
    }

    /// As [`load`](Batch::load); counts the point if it runs alone.
    fn load_one<S: Number>(&mut self, bundle: &mut Bundle<S>, lane: usize, run: &Run) -> Slot {
        if S::WIDTH == 1 {
            self.source.alone(1);
        }
        self.load(bundle, lane, run)
    }
}
