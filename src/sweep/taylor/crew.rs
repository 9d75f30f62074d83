//! The loop over the steps of all lanes.

use crate::model::shapes::waves::fourier_waves::FourierWaves;
use crate::model::shapes::waves::waves_of_lanes::Turns;
use crate::ode::taylor::course::are_steep;
use crate::ode::taylor::defect::{Checked, Defect};
use crate::ode::taylor::expansion::degrees::{may_have_gaps, may_hide};
use crate::ode::taylor::expansion::plan::EdgeColumn;
use crate::ode::{IntegrateError, Taylor};
use crate::steepness::JETS;
use crate::sweep::lanes::instructions::InstructionSet;
use crate::sweep::lanes::number::Lanes;
use crate::sweep::taylor::columns::{Columns, W};
use crate::sweep::taylor::lane::Lane;
use crate::sweep::taylor::meters::SeriesMeters;
use crate::sweep::taylor::pace::{Before, Pace};
use crate::sweep::taylor::program::Program;
use crate::sweep::taylor::tasks::task::{Ended, LaneJob, Queue, Task};
use crate::sweep::taylor::view::LaneView;
use pulp::Arch;

/// The numbers of all lanes.
struct Numbers<'p> {
    program: &'p Program,
    waves: Option<&'p FourierWaves>,
    turns: Option<Turns<W>>,
    columns: Columns,
    pace: Pace,
    meters: SeriesMeters,
    /// Angle of the waves, its speed.
    angles: [[f64; W]; 2],
    before: Before,
    /// The lengths that the tolerances allow.
    full: [f64; W],
    /// The lengths of the steps.
    h: Lanes<W>,
    /// Bounds of the moves of the distances in the step, at their columns.
    moves: Vec<[Lanes<W>; 2]>,
    /// Coordinates and velocities at the end of the step.
    ends: Vec<Lanes<W>>,
}

/// What becomes of a lane in a step.
#[derive(Clone, Copy, PartialEq)]
enum LaneTurn {
    /// It has no run, or its run has failed.
    Out,
    /// A contact changed its piece at the start: the step must be repeated.
    Again,
    Step,
}

/// A run in progress.
struct Run<'m, T> {
    index: usize,
    lane: Lane<'m>,
    task: T,
}

/// Runs side by side.
pub(crate) struct Crew<'p, 'm, T: Task<'m>> {
    taylor: &'p Taylor,
    set: InstructionSet,
    edges: Vec<EdgeColumn>,
    singular: Option<&'static str>,
    numbers: Numbers<'p>,
    /// The check of steps; `None` if neither algebra nor waves nor their sums have something that a step may
    /// pass unseen, and no series has gaps.
    defect: Option<Defect>,
    has_gaps: bool,
    runs: [Option<Box<Run<'m, T>>>; W],
    /// How a run ended, until its lane is filled again.
    outcomes: [Option<Result<(), T::Error>>; W],
    turns: [LaneTurn; W],
}

impl<'p, 'm, T: Task<'m>> Crew<'p, 'm, T> {
    /// `degree`: highest order of the series.
    pub(crate) fn new(
        taylor: &'p Taylor,
        set: InstructionSet,
        program: &'p Program,
        waves: Option<&'p FourierWaves>,
        degree: usize,
    ) -> Self {
        let (zeros, zero, edges) = ([0.0; W], Lanes::from(0.0), program.edges());
        let (hides, has_gaps) = (may_hide(&program.tape), may_have_gaps(&program.tape));
        let hidden =
            |waves: &FourierWaves| program.waves.iter().any(|(wave, _)| waves.sizes(*wave).is_some());
        let is_checked = hides || has_gaps || !program.time_sums.is_empty() || waves.is_none_or(hidden);
        Crew {
            taylor,
            set,
            singular: program.singular(),
            numbers: Numbers {
                program,
                waves,
                turns: waves.map(Turns::new),
                columns: Columns::new(program, degree),
                pace: Pace::new(taylor.tolerances.rtol, 2 * program.dof, &edges),
                meters: SeriesMeters::new(program.channels.clone()),
                angles: [zeros; 2],
                before: Before { last: zeros, room: zeros },
                full: zeros,
                h: zero,
                moves: vec![[zero; 2]; program.columns],
                ends: vec![zero; 2 * program.dof],
            },
            edges,
            defect: is_checked.then(|| Defect::new(&program.tape, hides)),
            has_gaps,
            runs: std::array::from_fn(|_| None),
            outcomes: std::array::from_fn(|_| None),
            turns: [LaneTurn::Out; W],
        }
    }

    /// Makes runs, beginning with `first`, until none is left, or until cancelled.
    pub(crate) fn run(&mut self, first: LaneJob<'m, T>, queue: &mut dyn Queue<'m, T>) {
        let mut next = Some(first);
        for lane in 0..W {
            let job = next.take().or_else(|| queue.next());
            self.load(lane, job, queue);
        }
        while self.runs.iter().any(Option::is_some) {
            if queue.is_cancelled() {
                return;
            }
            self.step();
            for lane in 0..W {
                let Some(over) = self.outcomes[lane].take() else { continue };
                let Some(run) = self.runs[lane].take() else { continue };
                let job = queue.over(run.index, run.task, over);
                self.load(lane, job, queue);
            }
        }
    }

    /// Fills a lane with a run, or with the first of the next ones that can begin.
    fn load(&mut self, place: usize, mut job: Option<LaneJob<'m, T>>, queue: &mut dyn Queue<'m, T>) {
        while let Some(LaneJob { index, motion, task }) = job {
            match Lane::new(&motion) {
                Ok(lane) => {
                    let Numbers { program, columns, meters, pace, .. } = &mut self.numbers;
                    columns.set_lane(program, place, &lane.drives, &lane.course.e.pieces);
                    meters.clear(place);
                    pace.set_lane(place, task.tolerances());
                    self.runs[place] = Some(Box::new(Run { index, lane, task }));
                    return;
                }
                Err(error) => job = queue.over(index, task, Err(error.into())),
            }
        }
    }

    /// Makes a step in every lane.
    fn step(&mut self) {
        for (turn, run) in self.turns.iter_mut().zip(&self.runs) {
            *turn = if run.is_some() { LaneTurn::Step } else { LaneTurn::Out };
        }
        self.each(|crew, place, run| Ok(crew.begin(place, &mut run.lane).map(|()| LaneTurn::Step)?));
        self.set.run(Expansion(&mut self.numbers));
        self.each(|crew, place, run| {
            let (full, longest) = (crew.numbers.full[place], crew.taylor.tolerances.max);
            let h = run.lane.aim(full, longest, &crew.view(place))?;
            crew.numbers.h.0[place] = h;
            Ok(LaneTurn::Step)
        });
        self.set.run(Moves(&mut self.numbers));
        self.each(|crew, place, run| {
            let moves = |column: usize| crew.numbers.moves[column].map(|bound| bound.0[place]);
            let mut length = run.lane.course.meet(&crew.view(place), moves)?;
            if let Some(h) = length {
                length = Some(crew.check(place, run, h)?);
            }
            crew.numbers.h.0[place] = length.unwrap_or(0.0);
            if length.is_none() {
                crew.take_pieces(place, &run.lane);
            }
            Ok(if length.is_some() { LaneTurn::Step } else { LaneTurn::Again })
        });
        let measuring = self.runs.iter().flatten().any(|run| run.task.measures());
        self.set.run(Ends(&mut self.numbers, measuring));
        self.each(|crew, place, run| crew.end(place, run));
    }

    /// Calls `f` for every lane that makes a step. An error ends the run.
    fn each(&mut self, mut f: impl FnMut(&mut Self, usize, &mut Run<'m, T>) -> Result<LaneTurn, T::Error>) {
        for place in 0..W {
            if self.turns[place] != LaneTurn::Step {
                continue;
            }
            // The run is taken out, so that `f` may use the numbers of all lanes.
            let Some(mut run) = self.runs[place].take() else { continue };
            match f(self, place, &mut run) {
                Ok(turn) => self.turns[place] = turn,
                Err(error) => {
                    self.turns[place] = LaneTurn::Out;
                    self.numbers.h.0[place] = 0.0;
                    self.outcomes[place] = Some(Err(error));
                }
            }
            self.runs[place] = Some(run);
        }
    }

    fn view(&self, lane: usize) -> LaneView<'_> {
        let (columns, singular) = (&self.numbers.columns, self.singular);
        LaneView { columns, lane, edges: &self.edges, arch: Arch::new(), singular }
    }

    /// Ends the step of length `h` of a lane where its polynomials cease to solve the equation. Returns its
    /// length.
    fn check(&mut self, place: usize, run: &mut Run<'m, T>, h: f64) -> Result<f64, IntegrateError> {
        let Some(mut defect) = self.defect.take() else { return Ok(h) };
        let Run { lane, task, .. } = run;
        let mut solved = h;
        let hides_a_sum = self.hides_a_sum(place);
        let is_steep = defect.of_tape || hides_a_sum || self.are_waves_steep(place, lane);
        if is_steep || self.has_gaps && lane.course.may_miss(self.numbers.full[place]) {
            let (e, rtol, atol) = (&lane.course.e, self.taylor.tolerances.rtol, task.tolerances());
            let step = Checked { t: e.t, h, pieces: &e.pieces, rtol, atol, is_steep, hides_a_sum };
            solved = defect.length(&step, lane.expanded, &self.view(place));
        }
        self.defect = Some(defect);
        if solved < h {
            self.numbers.full[place] = solved;
            return lane.shorten(solved, &self.view(place));
        }
        Ok(h)
    }

    /// Whether a later part of the step of a lane may be hidden in its waves.
    fn are_waves_steep(&self, place: usize, lane: &Lane<'m>) -> bool {
        let Numbers { program, waves, columns, .. } = &self.numbers;
        let Some(waves) = waves else { return are_steep(&lane.series, &program.waves) };
        let (degree, speed) = (columns.degree, lane.speed);
        let below = (1..degree).fold(1.0, |power, _| power * speed);
        let power = |k: usize| if k < degree { below } else { below * speed };
        program.waves.iter().any(|&(wave, column)| {
            let at = |n: usize| columns.at(column, n).0[place];
            waves.sizes(wave).is_some_and(|sizes| sizes.hides(degree + 1, at, power))
        })
    }

    /// Whether the last coefficients of a sum that varies with the time alone do not show it.
    fn hides_a_sum(&self, place: usize) -> bool {
        let Numbers { program, columns, .. } = &self.numbers;
        let (degree, at) = (columns.degree, |column: u32, n: usize| columns.at(column as usize, n).0[place]);
        program.time_sums.iter().any(|sum| degree <= JETS + 1 || sum.hides(degree - 1, at))
    }

    fn take_pieces(&mut self, place: usize, lane: &Lane<'m>) {
        let Numbers { program, columns, .. } = &mut self.numbers;
        columns.set_lane(program, place, &lane.drives, &lane.course.e.pieces);
    }

    /// Writes the start of a step of a lane.
    fn begin(&mut self, place: usize, run: &mut Lane<'m>) -> Result<(), IntegrateError> {
        let limit = self.taylor.limits.max_steps;
        run.attempts += 1;
        if run.attempts > limit {
            return Err(IntegrateError::TooManySteps { t: run.course.e.t, limit });
        }
        let Numbers { program, waves, columns, angles, before, .. } = &mut self.numbers;
        let t = run.course.e.t;
        for (column, y) in run.course.e.y.slice().iter().enumerate() {
            columns.at_mut(column, 0).0[place] = *y;
        }
        (angles[0][place], angles[1][place]) = (run.speed * t, run.speed);
        (before.last[place], before.room[place]) = (run.course.last, run.course.passage.stop - t);
        if waves.is_none() {
            let series = run.drive_series(columns.degree + 1, &program.waves)?;
            for &(wave, column) in &program.waves {
                for (n, c) in series[wave].padded().iter().enumerate() {
                    columns.at_mut(column, n).0[place] = *c;
                }
            }
        }
        Ok(())
    }

    /// Ends the step of a lane.
    fn end(&mut self, place: usize, run: &mut Run<'m, T>) -> Result<LaneTurn, T::Error> {
        let Run { lane, task, .. } = run;
        for (y, end) in lane.course.e.y1.slice_mut().iter_mut().zip(&self.numbers.ends) {
            *y = end.0[place];
        }
        let at_edge = lane.end_step(self.numbers.full[place], &self.view(place))?;
        let Numbers { columns, meters, pace, .. } = &mut self.numbers;
        let view =
            LaneView { columns, lane: place, edges: &self.edges, arch: Arch::new(), singular: self.singular };
        if task.end(lane, Ended { view, at_edge, meters, pace })? {
            self.outcomes[place] = Some(Ok(()));
            return Ok(LaneTurn::Out);
        }
        if std::mem::take(&mut lane.changed) {
            self.take_pieces(place, lane);
        }
        Ok(LaneTurn::Step)
    }
}

/// Drives, coefficients and lengths of steps.
struct Expansion<'n, 'p>(&'n mut Numbers<'p>);

impl pulp::WithSimd for Expansion<'_, '_> {
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
struct Moves<'n, 'p>(&'n mut Numbers<'p>);

impl pulp::WithSimd for Moves<'_, '_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Numbers { columns, pace, h, moves, .. } = self.0;
        pace.moves(columns, h, moves);
    }
}

/// The ends of the steps and, if chosen, the figures of the channels.
struct Ends<'n, 'p>(&'n mut Numbers<'p>, bool);

impl pulp::WithSimd for Ends<'_, '_> {
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
