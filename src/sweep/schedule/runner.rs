//! The runner of a sweep: whole, in chunks, or resumed.

use crate::error::{ParameterError, check};
use crate::linear::statics::default_start;
use crate::model::channel::index_of;
use crate::model::{Machine, Periodic, Shape};
use crate::ode::probe::Probe;
use crate::sweep::engines::sweep_engine::SweepEngine;
use crate::sweep::engines::track::Plan;
use crate::sweep::rows::collection::Rows;
use crate::sweep::rows::layout::Layout;
use crate::sweep::rows::merge::RowsError;
use crate::sweep::rows::row::Row;
use crate::sweep::schedule::start::IntoStart;
use crate::sweep::schedule::worker::{ModelOf, OfRows, StartOf, Work};
use crate::sweep::settings::points::Point;
use crate::sweep::settings::sweep::Sweep;
use crate::sweep::sweep_error::{FamilyError, PointError, SweepError};
use crate::sweep::watch::Watch;
use std::error::Error as AnyError;
use std::fmt;
use std::sync::{Arc, Mutex};

/// A sweep with its engine and its family of models: runs the points, all or in chunks.
///
/// Each run starts in the [static state](crate::linear::static_state) of its model, or where
/// [`start`](Runner::start) says.
///
/// ```
/// use gear_dynamics::sweep::{Axis, LaneRk4, Rows, Watch};
/// use gear_dynamics::{NfgPair, NfgParams, Sweep};
/// use std::sync::{Arc, atomic::{AtomicBool, Ordering::Relaxed}};
/// let sweep = Sweep::new(Axis::linear("speed", 100.0, 130.0, 400)?);
/// let sweep = sweep.settle(1).measure(1).channels(&["q0"]);
/// let engine = LaneRk4::new(63 * 16);
/// let pair = NfgPair::new(&NfgParams::table1())?;
/// let runner = || sweep.of(&engine, |p| pair.with("speed", p["speed"]));
/// let whole = runner().run()?;
/// let halves = vec![runner().chunk(0, 2)?, runner().chunk(1, 2)?]; // for example on two computers
/// assert_eq!(Rows::merge(halves)?, whole); // the same rows, bit by bit
/// // Cancelled after 20 runs, then completed:
/// let stop = Arc::new(AtomicBool::new(false));
/// let count = |done: usize, _total: usize| stop.store(done >= 20, Relaxed);
/// let part = runner().watch(Watch::new().progress(count).cancel(stop.clone())).run()?;
/// assert!((20..400).contains(&part.iter().count()));
/// assert_eq!(runner().resume(part)?, whole);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use = "nothing runs before `run`"]
pub struct Runner<'a, M, E> {
    pub(crate) sweep: &'a Sweep,
    pub(crate) engine: &'a E,
    pub(crate) family: Box<ModelOf<'a, M>>,
    pub(crate) start: Box<StartOf<'a, M>>,
    pub(crate) watch: Watch<'a>,
    pub(crate) rows: Option<Arc<OfRows<'a>>>,
}

impl<M, E> fmt::Debug for Runner<'_, M, E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Runner").field("sweep", &self.sweep).finish_non_exhaustive()
    }
}

impl Sweep {
    /// The runner of this sweep with a function that makes the model of each point. Constants of one
    /// machine by their names: [`over`](Sweep::over).
    pub fn of<'a, M, E, X>(
        &'a self,
        engine: &'a E,
        family: impl Fn(&Point<'_>) -> Result<M, X> + Sync + 'a,
    ) -> Runner<'a, M, E>
    where
        M: Periodic,
        E: SweepEngine<M>,
        X: Into<Box<dyn AnyError + Send + Sync>>,
    {
        Runner {
            sweep: self,
            engine,
            family: Box::new(move |point| family(point).map_err(|e| PointError::Model(FamilyError::new(e)))),
            start: Box::new(|_, model| Ok(default_start(model)?)),
            watch: Watch::new(),
            rows: None,
        }
    }

    /// The runner of this sweep over constants of one machine: the names of the points are constants, the
    /// others are those of `machine`.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchConstant`], which lists the constants.
    ///
    /// ```
    /// use gear_dynamics::sweep::{Axis, LaneRk4, Points};
    /// use gear_dynamics::trains::SpurPair;
    /// use gear_dynamics::Sweep;
    /// let pair = SpurPair::of_numbers(0.05, 0.1, &[0.2], &[])?.parts()?.build("driver", 0.4)?;
    /// let axes = vec![Axis::linear("speed", 0.4, 0.6, 5)?, Axis::of_values("mesh damping", &[0.1, 0.2])?];
    /// let sweep = Sweep::new(Points::grid(axes)?).channels(&["deflection"]);
    /// let rows = sweep.over(&LaneRk4::of_model(&pair)?, &pair)?.run()?;
    /// let mean = rows.get(0)?.channel("deflection")?.mean; // without contact loss
    /// assert!((mean - 1.102).abs() < 1e-3 && rows.errors().is_empty());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn over<'a, G: Shape, E: SweepEngine<Machine<G>>>(
        &'a self,
        engine: &'a E,
        machine: &'a Machine<G>,
    ) -> Result<Runner<'a, Machine<G>, E>, ParameterError> {
        let indices = self.points.names().iter().map(|name| index_of(machine.names(), name));
        let indices = indices.collect::<Result<Vec<_>, _>>()?;
        Ok(self.of(engine, move |point| {
            let values: Vec<_> = indices.iter().copied().zip(point.values().iter().copied()).collect();
            machine.with_indexed(&values)
        }))
    }
}

impl<'a, M: Periodic, E: SweepEngine<M>> Runner<'a, M, E> {
    /// The start states: a function of a point and its model, at time 0. It returns a state, or a result with
    /// an error. Default: the [static state](crate::linear::static_state) of each model.
    pub fn start<S: IntoStart>(self, start: impl Fn(&Point<'_>, &M) -> S + Sync + 'a) -> Self {
        let start = move |point: &Point<'_>, of: &M| start(point, of).into_start().map_err(PointError::Model);
        Runner { start: Box::new(start), ..self }
    }

    /// Function that is called with every row as soon as its run is complete, in any order. It blocks only
    /// the worker that produced the row.
    pub fn row_callback(self, rows: impl Fn(&Row<'_>) + Send + Sync + 'a) -> Self {
        Runner { rows: Some(Arc::new(rows)), ..self }
    }

    /// Progress by runs, those of the points of the chunk and of their checks, and a flag. If cancelled,
    /// completed rows are kept: [`resume`](Runner::resume) runs the other points.
    ///
    /// Fixed-step engines check the flag at least every max(64, n/24) steps, with n steps per period; drive
    /// tables every 64 rows; [`Located`](crate::sweep::Located) after every step.
    pub fn watch(self, watch: Watch<'a>) -> Self {
        Runner { watch, ..self }
    }

    /// Runs all points.
    ///
    /// # Errors
    /// [`SweepError`] for an error of the sweep as a whole. The error of a single point is stored in
    /// [`Rows::errors`].
    pub fn run(&self) -> Result<Rows, SweepError> {
        self.chunk(0, 1)
    }

    /// Runs chunk `chunk` (counted from 0) of `chunks`: a part of the points, with the same rows as in the
    /// whole sweep. [`Rows::merge`] merges all chunks.
    ///
    /// # Errors
    /// As [`run`](Runner::run); [`SweepError::Chunk`].
    pub fn chunk(&self, chunk: usize, chunks: usize) -> Result<Rows, SweepError> {
        if chunk >= chunks {
            return Err(SweepError::Chunk { chunk, chunks });
        }
        let sweep = self.sweep;
        let length = sweep.line();
        let lines = sweep.points.len() / length;
        let share = |i: usize| (lines as u128 * i as u128 / chunks as u128) as usize * length;
        let range = share(chunk)..share(chunk + 1);
        sweep.check()?;
        Rows::check_room(range.len(), Some(Layout::GROUP))?;
        let mut rows = Rows::new(sweep, &Layout::default(), range);
        self.complete(&mut rows)?;
        Ok(rows)
    }

    /// Completes cancelled rows: runs the points that have neither row nor error, and the missing checks.
    /// `rows` may be those of a sweep, of a chunk or of merged chunks. Existing rows are kept, but with a
    /// warm start an incomplete line is run again as a whole.
    ///
    /// # Errors
    /// As [`run`](Runner::run); [`SweepError::Parts`] for rows of another sweep. [`RowsError::rows`] contains
    /// the rows.
    pub fn resume(&self, mut rows: Rows) -> Result<Rows, RowsError> {
        match self.complete(&mut rows) {
            Ok(()) => Ok(rows),
            Err(error) => Err(RowsError { error, rows: vec![rows] }),
        }
    }

    /// Completes rows. If it returns an error, the rows are unchanged, except that errors of points before
    /// the first model may have been stored.
    fn complete(&self, rows: &mut Rows) -> Result<(), SweepError> {
        let (sweep, engine) = (self.sweep, self.engine);
        sweep.check()?;
        if rows.sweep != sweep.without_budget() {
            return Err(SweepError::Parts { row: rows.range.start });
        }
        let finer = if sweep.check_every > 0 { engine.finer() } else { None };
        let total = sweep.line()
            * (sweep.missing(rows).len() + if finer.is_some() { sweep.unchecked(rows).len() } else { 0 });
        let Some(model) = self.first_model(rows, total) else { return Ok(()) };
        let probe = Probe::new(&model);
        let channels = probe.indices(&sweep.channels)?;
        check::at_least("degrees of freedom", model.dof(), 1)?;
        let units = channels.iter().map(|&channel| probe.channels()[channel].unit.clone()).collect();
        engine.accepts(&model, &channels)?;
        if let Some(finer) = &finer {
            finer.accepts(&model, &channels)?;
        }
        let layout = Layout {
            dof: model.dof(),
            channels: channels.len(),
            contacts: if sweep.rattle { model.offers().touching(model.contacts()) } else { 0 },
            strobes: sweep.strobes.min(sweep.measure),
            exponents: sweep.exponents(),
            multipliers: sweep.multipliers_of(model.dof()),
        };
        let plan = Plan {
            settle: sweep.settle,
            measure: sweep.measure,
            repeat: sweep.repeat,
            tolerance: sweep.tolerance,
            layout,
        };
        if !rows.shape(&plan.layout)? {
            return Err(SweepError::Parts { row: rows.range.start });
        }
        rows.units = units;
        let (lines, checks) =
            (sweep.missing(rows), if finer.is_some() { sweep.unchecked(rows) } else { Vec::new() });
        let work = Work {
            sweep,
            plan: &plan,
            channels: &channels,
            shape: [model.dof(), model.contacts()],
            length: sweep.line(),
            family: &*self.family,
            start: &*self.start,
            watch: &self.watch,
            show: self.rows.as_deref().map(|show| (show, Rows::new(sweep, &plan.layout, 0..0))),
            progress: self.watch.begin(total - sweep.line() * (lines.len() + checks.len()), total),
            rows: Mutex::new(rows),
        };
        work.all(engine, &lines, false);
        if let Some(finer) = &finer {
            work.all(finer, &checks, true);
        }
        Ok(())
    }

    /// The first model of the whole sweep, also for a chunk: it determines the layout of the rows. Stores the
    /// errors of those points of `rows` that precede it. `None` if no point has a model, or if cancelled.
    fn first_model(&self, rows: &mut Rows, total: usize) -> Option<M> {
        let sweep = self.sweep;
        let (length, missing, progress) = (sweep.line(), sweep.missing(rows), self.watch.begin(0, total));
        for index in 0..sweep.points.len() {
            if self.watch.is_cancelled() {
                return None;
            }
            match (self.family)(&sweep.points.point(index)) {
                Ok(model) => return Some(model),
                Err(error) if rows.range.contains(&index) => rows.put(index, &Err(error)),
                Err(_) => {}
            }
            if (index + 1).is_multiple_of(length) && missing.binary_search(&(index / length)).is_ok() {
                progress.add(length);
            }
        }
        None
    }
}

impl Sweep {
    /// The lines of some rows in which at least one point is `open`.
    fn lines(&self, rows: &Rows, open: impl Fn(usize) -> bool) -> Vec<usize> {
        let length = self.line();
        let lines = rows.range.start / length..rows.range.end / length;
        lines.filter(|line| (line * length..(line + 1) * length).any(&open)).collect()
    }

    /// The lines that must be run.
    fn missing(&self, rows: &Rows) -> Vec<usize> {
        self.lines(rows, |index| rows.is_open(index))
    }

    /// The lines that must be checked. They are counted from the first line of the sweep, so that chunks
    /// check the same lines as the whole sweep.
    fn unchecked(&self, rows: &Rows) -> Vec<usize> {
        let open = |index: usize| !(rows.checks.contains_key(&index) || rows.errors.contains_key(&index));
        self.lines(rows, |index| (index / self.line()).is_multiple_of(self.check_every) && open(index))
    }
}
