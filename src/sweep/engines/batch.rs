//! Runs over the same table of drives, in one or several lanes.

use crate::model::shapes::compiled::own_drives;
use crate::model::{Machine, Model, Periodic, Shape, State};
use crate::numeric::spread::golden;
use crate::ode::IntegrateError;
use crate::ode::probe::ChannelKind;
use crate::sweep::engines::sweep_engine::{Job, Source};
use crate::sweep::engines::track::{Next, Plan, Track};
use crate::sweep::lanes::compiled::Advance;
use crate::sweep::lanes::drive_table::{DriveTable, TableError};
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::lanes::kernel::Bundle;
use crate::sweep::lanes::meter::{MeterReading, Meters};
use crate::sweep::lanes::number::Number;
use crate::sweep::sweep_error::PointError;
use std::collections::VecDeque;

/// Number of steps between two checks for cancellation.
const STEPS_UNCHECKED: usize = 64;

/// Approximate number of states sampled within a period to find the range of the motion. The steps between
/// them are irregular, so that no frequency of the motion is aliased.
const SAMPLES: usize = 48;

/// Stores the error of a run that cannot be made. Returns the next job of its line, if any.
pub(crate) fn refuse<M>(source: &mut dyn Source<M>, index: usize, error: PointError) -> Option<Job<M>> {
    source.put(index, Err(error));
    source.next(Some((index, &[])))
}

/// The data of a job that its lane needs.
pub(crate) struct LaneRun {
    pub(crate) index: usize,
    pub(crate) start: State,
    pub(crate) period: f64,
    /// The drives that differ from lane to lane; they are constant in time.
    pub(crate) constants: Vec<f64>,
}

impl LaneRun {
    pub(crate) fn of<G: Shape>(job: &Job<Machine<G>>) -> Result<Self, PointError> {
        let (model, constants) = (&job.model, own_drives(&*job.model));
        model.offers().refuse_stops(|contact| IntegrateError::StopNotLocated { contact })?;
        IntegrateError::of_start(&**model, &job.start)?;
        if let Some(bad) = constants.iter().position(|x| !x.is_finite()) {
            return Err(TableError::NotFinite {
                drive: model.size().waves + bad,
                value: constants[bad],
                phase: 0.0,
            }
            .into());
        }
        Ok(LaneRun { index: job.index, start: job.start.clone(), period: model.period(), constants })
    }
}

/// Length of stretch `k` of a period in steps: 1 + round(2 (m - 1) frac(k/φ)), with mean m =
/// max(floor(steps/[`SAMPLES`]), 1) and golden ratio φ. The lengths are evenly distributed about m and do not
/// repeat.
fn irregular(steps: usize, k: f64) -> usize {
    let mean = (steps / SAMPLES).max(1) as f64;
    1 + (golden(k) * 2.0 * (mean - 1.0)).round() as usize
}

/// The run that occupies a lane.
struct Slot {
    index: usize,
    track: Track,
}

/// Runs over the same table.
pub(crate) struct Batch<'a, M> {
    pub(crate) plan: &'a Plan,
    pub(crate) table: &'a DriveTable,
    pub(crate) kinds: &'a [ChannelKind],
    pub(crate) set: InstructionSet,
    pub(crate) shares: &'a dyn Fn(&Job<M>) -> bool,
    /// Jobs that need another table.
    pub(crate) waiting: &'a mut VecDeque<Job<M>>,
    pub(crate) source: &'a mut dyn Source<M>,
}

impl<M: Periodic> Batch<'_, M> {
    fn bundle<S: Number>(&self, code: &dyn Advance<S>) -> Bundle<S> {
        Bundle::new(code.sizes(), self.table, Meters::new(self.kinds, self.plan.layout.contacts))
    }

    /// One run of a model that need not be a [`Machine`].
    pub(crate) fn run_plain(&mut self, code: &dyn Advance<f64>, run: &LaneRun) {
        let mut bundle = self.bundle(code);
        let mut slots = [Some(self.load(&mut bundle, 0, run))];
        while let [Some(slot)] = &slots {
            bundle.metered = slot.track.watching();
            if !self.period(code, &mut bundle, &mut slots) {
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
    fn load<S: Number>(&self, bundle: &mut Bundle<S>, lane: usize, run: &LaneRun) -> Slot {
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
    fn period<S: Number>(
        &mut self,
        code: &dyn Advance<S>,
        bundle: &mut Bundle<S>,
        slots: &mut [Option<Slot>],
    ) -> bool {
        let steps = self.table.steps();
        let ranging = slots.iter().flatten().any(|slot| slot.track.ranging());
        let (mut from, mut samples) = (0, 0.0);
        while from < steps {
            let stretch = if ranging { irregular(steps, samples) } else { STEPS_UNCHECKED };
            let to = (from + stretch).min(steps);
            code.advance(self.table, from..to, bundle, self.set);
            if self.source.is_cancelled() {
                return false;
            }
            for (lane, slot) in slots.iter_mut().enumerate() {
                if let Some(slot) = slot.as_mut().filter(|slot| slot.track.ranging()) {
                    slot.track.see_state(bundle.q.iter().chain(&bundle.v).map(|x| x.lane(lane)));
                }
            }
            (from, samples) = (to, samples + 1.0);
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
        let mut negative = None;
        if run.track.measuring() {
            bundle.meters.read(lane, |reading| match reading {
                MeterReading::Channel(i, meter) => run.track.add_channel(i, &meter, weight),
                MeterReading::Contact(i, meter) => {
                    let overlaps = meter.overlaps || meter.samples[0] + meter.samples[1] > weight;
                    negative = negative.or(overlaps.then_some(i));
                    run.track.add_contact(i, &meter, weight);
                }
            });
        }
        if let Some(contact) = negative {
            let error = PointError::NegativeGap { contact, period: run.track.periods + 1 };
            return self.end(bundle, slot, lane, error);
        }
        let state = bundle.q.iter().chain(&bundle.v).map(|x| x.lane(lane));
        let index = run.index;
        match run
            .track
            .period(self.table.steps() as u64, weight, state, &|read| self.source.with_model(index, read))
        {
            Next::Settle | Next::Measure => None,
            Next::StartMeasuring => {
                bundle.meters.clear(lane);
                None
            }
            Next::Done => {
                let Slot { index, track } = slot.take()?;
                let (row, state) = track.finish(&|read| self.source.with_model(index, read));
                self.source.put(index, Ok((row, &state)));
                Some((index, state))
            }
            Next::Diverged => {
                let error = PointError::Diverged { period: run.track.periods };
                self.end(bundle, slot, lane, error)
            }
        }
    }

    /// Ends the run of a lane with an error. Returns the index of the point and an empty state.
    fn end<S: Number>(
        &mut self,
        bundle: &mut Bundle<S>,
        slot: &mut Option<Slot>,
        lane: usize,
        error: PointError,
    ) -> Option<(usize, Vec<f64>)> {
        let index = slot.take()?.index;
        // NaN or infinity in this lane would slow the other lanes down.
        bundle.q.iter_mut().chain(&mut bundle.v).for_each(|x| x.set_lane(lane, 0.0));
        self.source.put(index, Err(error));
        Some((index, Vec::new()))
    }
}

impl<G: Shape> Batch<'_, Machine<G>> {
    /// Runs of machines. A lane whose run is over takes the next job that shares lanes; other jobs wait.
    pub(crate) fn run<S: Number>(&mut self, code: &dyn Advance<S>, runs: &[LaneRun]) {
        let mut bundle = self.bundle(code);
        let mut slots: Vec<Option<Slot>> = (0..S::WIDTH).map(|_| None).collect();
        for ((lane, slot), run) in slots.iter_mut().enumerate().zip(runs) {
            *slot = Some(self.load_one(&mut bundle, lane, run));
        }
        while slots.iter().any(Option::is_some) {
            bundle.metered = slots.iter().flatten().any(|slot| slot.track.watching());
            if !self.period(code, &mut bundle, &mut slots) {
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
                    next = match LaneRun::of(&job) {
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
    fn load_one<S: Number>(&mut self, bundle: &mut Bundle<S>, lane: usize, run: &LaneRun) -> Slot {
        if S::WIDTH == 1 {
            self.source.alone(1);
        }
        self.load(bundle, lane, run)
    }
}
