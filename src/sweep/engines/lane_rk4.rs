//! The engine that runs machines side by side: RK4 in vector lanes over a shared table of waves.

use crate::error::check;
use crate::linear::{LinearError, Modes};
use crate::model::{Machine, Periodic, Shape};
use crate::sweep::engines::batch::{Batch, LaneRun, refuse};
use crate::sweep::engines::sweep_engine::{Job, Source, SweepEngine, kinds};
use crate::sweep::engines::track::Plan;
use crate::sweep::lanes::compiled::Compiled;
use crate::sweep::lanes::drive_table::DriveTable;
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::lanes::number::Lanes;
use crate::sweep::sweep_error::{PointError, SweepError};
use std::collections::VecDeque;

/// Engine for every [`Machine`]: RK4 with a fixed number of steps per period, W runs side by side in the
/// lanes of the vector registers. Default: 16 lanes.
///
/// The drives come from a table that is computed once for all runs that share lanes. Two runs share lanes if
/// and only if their [shapes](Shape) are equal. A run whose shape no other run has runs alone.
///
/// Steps cross the edges of contacts without locating them, as in the papers (Liu 2021, Yao 2020). 64 steps
/// in the shortest period of a drive keep this error small; [`check_every`](crate::Sweep::check_every)
/// measures it. Drive edges must fall on whole steps, otherwise the point fails with
/// [`TableError::EdgeOffGrid`](crate::sweep::TableError::EdgeOffGrid).
/// A row depends on its point only, with a warm start on its line: its bits are the same for any W,
/// instruction set, number of threads, order and neighbouring lanes. W = 16 suits all models. W = 32
/// ([`lanes`](LaneRk4::lanes)) is faster for one or two degrees of freedom and for small rings, W = 8 for a
/// ring of 16.
///
/// ```
/// use gear_dynamics::sweep::{Axis, InstructionSet, LaneRk4, bounds::SweepEngine};
/// use gear_dynamics::{NfgPair, NfgParams, Sweep};
/// fn fingerprint(engine: &impl SweepEngine<NfgPair>) -> Result<u64, Box<dyn std::error::Error>> {
///     let speeds = Axis::linear("speed", 100.0, 130.0, 6)?;
///     let rows = Sweep::new(speeds).settle(0).measure(1).channels(&["q0"]).of(
///         engine,
///         |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
///     ).run()?;
///     Ok(rows.fingerprint())
/// }
/// let sixteen = LaneRk4::new(63 * 16);
/// let four = LaneRk4::new(63 * 16).lanes::<4>().instructions(InstructionSet::Baseline);
/// assert_eq!(sixteen.steps(), 1008);
/// assert_eq!(fingerprint(&sixteen)?, fingerprint(&four)?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// A model that is not a [`Machine`] does not compile:
///
/// ```compile_fail,E0271
/// use gear_dynamics::sweep::{Axis, LaneRk4, Point};
/// use gear_dynamics::{ParameterError, Sweep, model::from_fn};
/// let rest = from_fn(1, |_, _, _, a| a[0] = 0.0)?.with_period(1.0)?;
/// let points = Axis::of_values("x", &[1.0])?;
/// let model = |_: &Point<'_>| Ok::<_, ParameterError>(rest);
/// let engine = LaneRk4::new(64); // with `TableRk4::new(64)` it compiles
/// Sweep::new(points).of(&engine, model).run()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use = "a setting returns a new value"]
pub struct LaneRk4<const W: usize = 16> {
    steps: usize,
    set: InstructionSet,
}

/// Steps in a cycle of the fastest wave.
const STEPS_PER_CYCLE: usize = 64;

/// Steps per radian of the fastest mode.
const STEPS_PER_RADIAN: f64 = 2.0;

impl LaneRk4 {
    /// An engine with this number of steps per period of the model. Defaults: 16 lanes,
    /// [`InstructionSet::Best`].
    pub fn new(steps: usize) -> Self {
        LaneRk4 { steps, set: InstructionSet::Best }
    }
    /// An engine with steps for this model: 64 in each [cycle](Shape::cycles_in_a_period) of its fastest
    /// wave, and 2 per radian of its fastest [mode](Modes::mean_in_contact). Give the slowest of the models
    /// of a sweep, which has the most radians in a period.
    ///
    /// # Errors
    /// As [`Modes::mean_in_contact`]; more steps than a table may have.
    ///
    /// ```
    /// use gear_dynamics::sweep::LaneRk4;
    /// use gear_dynamics::{NfgPair, NfgParams, Periodic};
    /// let pair = NfgPair::new(&NfgParams { speed: 200.0, ..NfgParams::table1() })?;
    /// assert_eq!(LaneRk4::of_model(&pair)?.steps(), 63 * 64); // 63 cycles of the mesh in a period
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of_model<G: Shape>(model: &Machine<G>) -> Result<Self, LinearError> {
        let fastest = Modes::mean_in_contact(model)?.frequencies().last().copied().unwrap_or(0.0);
        let radians = fastest * model.period();
        let cycles = STEPS_PER_CYCLE.saturating_mul(model.shape().cycles_in_a_period() as usize);
        // The conversion saturates.
        let steps = cycles.max((STEPS_PER_RADIAN * radians).ceil() as usize);
        check::count("steps in a period", &[steps], check::NUMBERS)?;
        Ok(LaneRk4::new(steps))
    }
}

impl<const W: usize> LaneRk4<W> {
    /// The same engine with another number of lanes.
    pub fn lanes<const OTHER: usize>(self) -> LaneRk4<OTHER> {
        LaneRk4 { steps: self.steps, set: self.set }
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
        DriveTable::check_size(self.steps, model.size().waves)?;
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
                match LaneRun::of(&job) {
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
                batch.run(&Compiled::<G, f64>::of(leader.model.shape()), &runs);
            } else {
                batch.run(&Compiled::<G, Lanes<W>>::of(leader.model.shape()), &runs);
            }
        }
    }
}

/// The table of a job and the job's run over it; `None` if cancelled.
fn lead<G: Shape>(
    job: &Job<Machine<G>>,
    steps: usize,
    source: &dyn Source<Machine<G>>,
) -> Result<Option<(DriveTable, LaneRun)>, PointError> {
    let run = LaneRun::of(job)?;
    let table = DriveTable::of_waves(&*job.model, steps, &|| !source.is_cancelled())?;
    Ok(table.map(|table| (table, run)))
}
