//! The loop over the steps of all lanes.

use crate::analysis::Summary;
use crate::model::Periodic;
use crate::model::expansion::fourier_waves::FourierWaves;
use crate::model::expansion::waves_of_lanes::Turns;
use crate::ode::taylor::expansion::plan::Edge;
use crate::ode::{IntegrateError, Taylor};
use crate::sweep::engines::track::{Next, Plan};
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::lanes::meter::ChannelMeter;
use crate::sweep::lanes::number::Lanes;
use crate::sweep::sweep_error::PointError;
use crate::sweep::taylor::columns::Columns;
use crate::sweep::taylor::lane::{Lane, LaneJob};
use crate::sweep::taylor::meters::Meters;
use crate::sweep::taylor::pace::{Before, Pace};
use crate::sweep::taylor::program::Program;
use crate::sweep::taylor::view::LaneView;
use pulp::Arch;

/// Row and last state (coordinates, then velocities) of a run, or its error.
pub(crate) type Outcome = Result<(Vec<f64>, Vec<f64>), PointError>;

/// Where the jobs of lanes come from, and their rows go to.
pub(crate) trait Queue<'m> {
    /// The next job that shares lanes. `after` is a point that is done and its last state, empty after an
    /// error.
    fn next(&mut self, after: Option<(usize, &[f64])>) -> Option<LaneJob<'m>>;
    fn put(&mut self, index: usize, outcome: Outcome);
    /// Calls `read` with the model of point `index`.
    fn with_model(&self, index: usize, read: &mut dyn FnMut(&dyn Periodic));
    fn is_cancelled(&self) -> bool;
}

/// The numbers of all lanes.
struct Numbers<'p, const W: usize> {
    program: &'p Program,
    waves: Option<&'p FourierWaves>,
    turns: Option<Turns<W>>,
    columns: Columns<W>,
    pace: Pace,
    meters: Meters<W>,
    /// Angle of the waves, its speed.
    angles: [[f64; W]; 2],
    before: Before<W>,
    /// The lengths that the tolerances allow.
    full: [f64; W],
    /// The lengths of the steps.
    h: Lanes<W>,
    /// How far distances move in the step, at their columns.
    ranges: Vec<Lanes<W>>,
    /// Coordinates and velocities at the end of the step.
    ends: Vec<Lanes<W>>,
}

/// What becomes of a lane in a step.
#[derive(Clone, Copy, PartialEq)]
enum Turn {
    /// It has no run, or its run has failed.
    Out,
    /// A contact changed its piece at the start: the step must be repeated.
    Again,
    Step,
}

/// Runs side by side.
pub(crate) struct Crew<'p, 'm, const W: usize> {
    plan: &'p Plan,
    taylor: &'p Taylor,
    set: InstructionSet,
    edges: Vec<Edge>,
    singular: Option<&'static str>,
    numbers: Numbers<'p, W>,
    lanes: [Option<Box<Lane<'m>>>; W],
    /// How a run ended, until its lane is filled again.
    outcomes: [Option<Result<(), PointError>>; W],
    turns: [Turn; W],
}

impl<'p, 'm, const W: usize> Crew<'p, 'm, W> {
    /// `atol`: absolute tolerance of each coordinate and velocity.
    pub(crate) fn new(
        plan: &'p Plan,
        taylor: &'p Taylor,
        set: InstructionSet,
        program: &'p Program,
        waves: Option<&'p FourierWaves>,
        (degree, atol): (usize, Vec<f64>),
    ) -> Self {
        let (zeros, zero, edges) = ([0.0; W], Lanes::from(0.0), program.edges());
        Crew {
            plan,
            taylor,
            set,
            singular: program.singular(),
            numbers: Numbers {
                program,
                waves,
                turns: waves.map(Turns::new),
                columns: Columns::new(program, degree),
                pace: Pace::new(taylor.tolerances.rtol, atol, &edges),
                meters: Meters::new(program.channels.clone()),
                angles: [zeros; 2],
                before: Before { last: zeros, room: zeros },
                full: zeros,
                h: zero,
                ranges: vec![zero; program.columns],
                ends: vec![zero; 2 * program.dof],
            },
            edges,
            lanes: std::array::from_fn(|_| None),
            outcomes: std::array::from_fn(|_| None),
            turns: [Turn::Out; W],
        }
    }

    /// Makes runs until no job is left, or until cancelled.
    pub(crate) fn run(&mut self, first: LaneJob<'m>, queue: &mut dyn Queue<'m>) {
        let mut next = Some(first);
        for lane in 0..W {
            let job = next.take().or_else(|| queue.next(None));
            self.load(lane, job, queue);
        }
        while self.lanes.iter().any(Option::is_some) {
            if queue.is_cancelled() {
                return;
            }
            self.step(queue);
            for lane in 0..W {
                let Some(over) = self.outcomes[lane].take() else { continue };
                let Some(run) = self.lanes[lane].take() else { continue };
                let Lane { index, track, .. } = *run;
                let finish =
                    |()| track.finish(&|read: &mut dyn FnMut(&dyn Periodic)| queue.with_model(index, read));
                let outcome = over.map(finish);
                let state = outcome.as_ref().map_or(Vec::new(), |(_, state)| state.clone());
                queue.put(index, outcome);
                let job = queue.next(Some((index, &state)));
                self.load(lane, job, queue);
            }
        }
    }

    /// Fills a lane with a job, or with the first of the next ones that can begin.
    fn load(&mut self, lane: usize, mut job: Option<LaneJob<'m>>, queue: &mut dyn Queue<'m>) {
        while let Some(next) = job {
            match Lane::new(self.plan, &next) {
                Ok(run) => {
                    let Numbers { program, columns, meters, .. } = &mut self.numbers;
                    columns.set_lane(program, lane, &run.drives, &run.course.e.pieces);
                    meters.clear(lane);
                    self.lanes[lane] = Some(Box::new(run));
                    return;
                }
                Err(error) => {
                    queue.put(next.index, Err(error.into()));
                    job = queue.next(Some((next.index, &[])));
                }
            }
        }
    }

    /// Makes a step in every lane.
    fn step(&mut self, queue: &dyn Queue<'m>) {
        for (turn, lane) in self.turns.iter_mut().zip(&self.lanes) {
            *turn = if lane.is_some() { Turn::Step } else { Turn::Out };
        }
        self.each(|crew, lane, run| crew.begin(lane, run).map(|()| Turn::Step));
        self.set.run(Expansion(&mut self.numbers));
        self.each(|crew, lane, run| {
            let (full, longest) = (crew.numbers.full[lane], crew.taylor.tolerances.max);
            let h = run.aim(full, longest, &crew.view(lane))?;
            crew.numbers.h.0[lane] = h;
            Ok(Turn::Step)
        });
        self.set.run(Ranges(&mut self.numbers));
        self.each(|crew, lane, run| {
            let ranges = &crew.numbers.ranges;
            let length = run.meet(&crew.view(lane), |column| ranges[column].0[lane])?;
            crew.numbers.h.0[lane] = length.unwrap_or(0.0);
            if length.is_none() {
                crew.take_pieces(lane, run);
            }
            Ok(if length.is_some() { Turn::Step } else { Turn::Again })
        });
        let measuring = self.lanes.iter().flatten().any(|run| run.track.measuring());
        self.set.run(Ends(&mut self.numbers, measuring));
        self.each(|crew, lane, run| crew.end(lane, run, queue));
    }

    /// Calls `f` for every lane that makes a step. An error ends the run.
    fn each(&mut self, mut f: impl FnMut(&mut Self, usize, &mut Lane<'m>) -> Result<Turn, PointError>) {
        for lane in 0..W {
            if self.turns[lane] != Turn::Step {
                continue;
            }
            // The run is taken out, so that `f` may use the numbers of all lanes.
            let Some(mut run) = self.lanes[lane].take() else { continue };
            match f(self, lane, &mut run) {
                Ok(turn) => self.turns[lane] = turn,
                Err(error) => {
                    self.turns[lane] = Turn::Out;
                    self.numbers.h.0[lane] = 0.0;
                    self.outcomes[lane] = Some(Err(error));
                }
            }
            self.lanes[lane] = Some(run);
        }
    }

    fn view(&self, lane: usize) -> LaneView<'_, W> {
        let (columns, singular) = (&self.numbers.columns, self.singular);
        LaneView { columns, lane, edges: &self.edges, arch: Arch::new(), singular }
    }

    fn take_pieces(&mut self, lane: usize, run: &Lane<'m>) {
        let Numbers { program, columns, .. } = &mut self.numbers;
        columns.set_lane(program, lane, &run.drives, &run.course.e.pieces);
    }

    /// Writes the start of a step of a lane.
    fn begin(&mut self, lane: usize, run: &mut Lane<'m>) -> Result<(), PointError> {
        let limit = self.taylor.limits.max_steps;
        run.attempts += 1;
        if run.attempts > limit {
            return Err(IntegrateError::TooManySteps { t: run.course.e.t, limit }.into());
        }
        let Numbers { program, waves, columns, angles, before, .. } = &mut self.numbers;
        let t = run.course.e.t;
        for (column, y) in run.course.e.y.slice().iter().enumerate() {
            columns.at_mut(column, 0).0[lane] = *y;
        }
        (angles[0][lane], angles[1][lane]) = (run.speed * t, run.speed);
        (before.last[lane], before.room[lane]) = (run.last, run.course.passage.stop - t);
        if waves.is_none() {
            let series = run.drive_series(columns.degree + 1, &program.waves)?;
            for &(wave, column) in &program.waves {
                for (n, c) in series[wave].padded().iter().enumerate() {
                    columns.at_mut(column, n).0[lane] = *c;
                }
            }
        }
        Ok(())
    }

    /// Ends the step of a lane, its period and its run.
    fn end(&mut self, lane: usize, run: &mut Lane<'m>, queue: &dyn Queue<'m>) -> Result<Turn, PointError> {
        for (y, end) in run.course.e.y1.slice_mut().iter_mut().zip(&self.numbers.ends) {
            *y = end.0[lane];
        }
        let at_edge = run.end_step(self.numbers.full[lane], &self.view(lane))?;
        if run.at_period() && self.end_period(lane, run, queue)? {
            return Ok(Turn::Out);
        }
        if run.pass(at_edge)? {
            self.take_pieces(lane, run);
        }
        Ok(Turn::Step)
    }

    /// Ends a period. Returns whether the run is over.
    fn end_period(
        &mut self,
        lane: usize,
        run: &mut Lane<'m>,
        queue: &dyn Queue<'m>,
    ) -> Result<bool, PointError> {
        let (period, index) = (run.period, run.index);
        if run.track.measuring() {
            for i in 0..self.numbers.program.channels.len() {
                let summary: Summary = self.numbers.meters.summary(i, lane, period);
                run.track.add_channel(i, &ChannelMeter::of(&summary, period), period);
            }
            run.count_contacts(self.plan.layout.contacts);
            self.numbers.meters.clear(lane);
        }
        let steps = std::mem::take(&mut run.steps);
        run.attempts = 0;
        let state: Vec<f64> = run.course.e.y1.slice().to_vec();
        let with_model = &|read: &mut dyn FnMut(&dyn Periodic)| queue.with_model(index, read);
        match run.track.period(steps, period, state.into_iter(), with_model) {
            Next::Done => {
                self.outcomes[lane] = Some(Ok(()));
                Ok(true)
            }
            Next::Diverged => Err(run.not_finite().into()),
            Next::StartMeasuring => {
                self.numbers.meters.clear(lane);
                Ok(false)
            }
            Next::Settle | Next::Measure => Ok(false),
        }
    }
}

/// Drives, coefficients and lengths of steps.
struct Expansion<'n, 'p, const W: usize>(&'n mut Numbers<'p, W>);

impl<const W: usize> pulp::WithSimd for Expansion<'_, '_, W> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Numbers { program, waves, turns, columns, pace, angles, before, full, .. } = self.0;
        if let (Some(waves), Some(turns)) = (waves, turns) {
            let [angles, speeds] = &*angles;
            let (chosen, orders) = (program.waves.iter().map(|(wave, _)| *wave), columns.degree + 1);
            waves.expand_lanes([angles, speeds], orders, chosen, turns, |i, n, c| {
                *columns.at_mut(program.waves[i].1, n) = Lanes(c);
            });
        }
        columns.expand(program);
        *full = pace.lengths(columns, before);
    }
}

/// How far distances move.
struct Ranges<'n, 'p, const W: usize>(&'n mut Numbers<'p, W>);

impl<const W: usize> pulp::WithSimd for Ranges<'_, '_, W> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Numbers { columns, pace, h, ranges, .. } = self.0;
        pace.ranges(columns, h, ranges);
    }
}

/// The ends of the steps and, if chosen, the figures of the channels.
struct Ends<'n, 'p, const W: usize>(&'n mut Numbers<'p, W>, bool);

impl<const W: usize> pulp::WithSimd for Ends<'_, '_, W> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Ends(Numbers { columns, meters, h, ends, .. }, metered) = self;
        for (column, end) in ends.iter_mut().enumerate() {
            *end = columns.value(column, h);
        }
        if metered {
            meters.add(columns, &h.0);
            meters.settle(columns, &h.0);
        }
    }
}
