//! A sweep and how it is run.

use crate::error::ParameterError;
use crate::model::equations::{Periodic, State};
use crate::ode::probe::Probe;
use crate::sweep::engines::interface::SweepEngine;
use crate::sweep::engines::track::Plan;
use crate::sweep::error::{PointError, SweepError};
use crate::sweep::monitor::Monitor;
use crate::sweep::rows::hash::Hash;
use crate::sweep::rows::layout::Layout;
use crate::sweep::rows::merge::RowsError;
use crate::sweep::rows::table::Rows;
use crate::sweep::schedule::block::Work;
use crate::sweep::settings::points::Point;
use crate::sweep::settings::sweep::Sweep;
use std::fmt::Display;
use std::sync::Mutex;
use std::sync::atomic::AtomicUsize;

impl Sweep {
    /// All points.
    ///
    /// # Errors
    /// [`SweepError`] for what is wrong with the sweep as a whole. A point that fails keeps its error among the rows.
    pub fn run<M, E, X, Y>(
        &self,
        engine: &E,
        family: impl Fn(&Point<'_>) -> Result<M, X> + Sync,
        start: impl Fn(&Point<'_>, &M) -> Result<State, Y> + Sync,
    ) -> Result<Rows, SweepError>
    where
        M: Periodic,
        E: SweepEngine<M>,
        X: Display,
        Y: Display,
    {
        self.run_chunk(0, 1, engine, family, start, &Monitor::new())
    }

    /// Chunk `chunk` of `chunks`: the rows of a part of the points, as they are in the whole sweep. [`Rows::merge`] puts them together.
    ///
    /// # Errors
    /// As [`run`](Sweep::run), and [`SweepError::Chunk`].
    pub fn run_chunk<M, E, X, Y>(
        &self,
        chunk: usize,
        chunks: usize,
        engine: &E,
        family: impl Fn(&Point<'_>) -> Result<M, X> + Sync,
        start: impl Fn(&Point<'_>, &M) -> Result<State, Y> + Sync,
        watch: &Monitor<'_>,
    ) -> Result<Rows, SweepError>
    where
        M: Periodic,
        E: SweepEngine<M>,
        X: Display,
        Y: Display,
    {
        if chunk >= chunks {
            return Err(SweepError::Chunk { chunk, chunks });
        }
        let length = self.line();
        let lines = self.points.len() / length;
        let share = |i: usize| (lines as u128 * i as u128 / chunks as u128) as usize * length;
        let range = share(chunk)..share(chunk + 1);
        self.check()?;
        Rows::check_room(range.len(), Some(Layout::HEAD))?;
        let mut rows = Rows::new(self, &Layout::default(), range);
        self.complete(&mut rows, engine, family, start, watch)?;
        Ok(rows)
    }

    /// Runs what is missing in the rows of a run, of a chunk or of merged chunks that were cancelled; what is done stands. A line along which
    /// states are carried is run again as a whole.
    ///
    /// # Errors
    /// As [`run`](Sweep::run), and [`SweepError::Parts`] for rows of another sweep; the error holds the rows.
    pub fn resume<M, E, X, Y>(
        &self,
        mut rows: Rows,
        engine: &E,
        family: impl Fn(&Point<'_>) -> Result<M, X> + Sync,
        start: impl Fn(&Point<'_>, &M) -> Result<State, Y> + Sync,
        watch: &Monitor<'_>,
    ) -> Result<Rows, RowsError>
    where
        M: Periodic,
        E: SweepEngine<M>,
        X: Display,
        Y: Display,
    {
        match self.complete(&mut rows, engine, family, start, watch) {
            Ok(()) => Ok(rows),
            Err(error) => Err(RowsError { error, rows: vec![rows] }),
        }
    }

    /// Runs what is missing in some rows. After an error they are what they were.
    fn complete<M, E, X, Y>(
        &self,
        rows: &mut Rows,
        engine: &E,
        family: impl Fn(&Point<'_>) -> Result<M, X> + Sync,
        start: impl Fn(&Point<'_>, &M) -> Result<State, Y> + Sync,
        watch: &Monitor<'_>,
    ) -> Result<(), SweepError>
    where
        M: Periodic,
        E: SweepEngine<M>,
        X: Display,
        Y: Display,
    {
        self.check()?;
        if rows.sweep != Hash::of(self) {
            return Err(SweepError::Parts { row: rows.range.start });
        }
        let family = |point: &Point<'_>| family(point).map_err(|e| PointError::Model(e.to_string()));
        let start =
            |point: &Point<'_>, model: &M| start(point, model).map_err(|e| PointError::Model(e.to_string()));
        let finer = if self.check_every > 0 { engine.finer() } else { None };
        let total = self.line()
            * (self.missing(rows).len() + if finer.is_some() { self.unchecked(rows).len() } else { 0 });
        let Some(model) = self.first_model(rows, &family, watch, total) else { return Ok(()) };
        let probe = Probe::new(&model);
        let channels = self.channels.iter().map(|name| probe.index(name)).collect::<Result<Vec<_>, _>>()?;
        if model.dof() == 0 {
            return Err(
                ParameterError::TooFew { name: "degrees of freedom".into(), value: 0, least: 1 }.into()
            );
        }
        engine.accepts(&model, &channels)?;
        if let Some(finer) = &finer {
            finer.accepts(&model, &channels)?;
        }
        let layout = Layout {
            dof: model.dof(),
            channels: channels.len(),
            contacts: if self.rattle { model.contacts() } else { 0 },
            strobes: self.strobes.min(self.measure),
            exponents: self.exponents(),
        };
        let plan = Plan {
            settle: self.settle,
            measure: self.measure,
            repeat: self.repeat,
            tolerance: self.tolerance,
            layout,
        };
        if !rows.shape(&plan.layout)? {
            return Err(SweepError::Parts { row: rows.range.start });
        }
        let (lines, checks) =
            (self.missing(rows), if finer.is_some() { self.unchecked(rows) } else { Vec::new() });
        let work = Work {
            sweep: self,
            plan: &plan,
            channels: &channels,
            shape: [model.dof(), model.contacts()],
            length: self.line(),
            family: &family,
            start: &start,
            watch,
            bare: watch.rows.map(|_| Rows::new(self, &plan.layout, 0..0)),
            done: AtomicUsize::new(total - self.line() * (lines.len() + checks.len())),
            total,
            rows: Mutex::new(rows),
        };
        work.all(engine, &lines, false);
        if let Some(finer) = &finer {
            work.all(finer, &checks, true);
        }
        Ok(())
    }

    /// The first model of the sweep, whatever the chunk: it gives the shape of the rows. Errors up to there are kept. `None` if there is none, or
    /// cancelled.
    fn first_model<M>(
        &self,
        rows: &mut Rows,
        family: &impl Fn(&Point<'_>) -> Result<M, PointError>,
        watch: &Monitor<'_>,
        total: usize,
    ) -> Option<M> {
        let (length, missing) = (self.line(), self.missing(rows));
        let mut done = 0;
        for index in 0..self.points.len() {
            if watch.is_cancelled() {
                return None;
            }
            match family(&self.points.point(index)) {
                Ok(model) => return Some(model),
                Err(error) if rows.range.contains(&index) => rows.put(index, &Err(error)),
                Err(_) => {}
            }
            if (index + 1).is_multiple_of(length) && missing.binary_search(&(index / length)).is_ok() {
                done += length;
                watch.show(done, total);
            }
        }
        None
    }

    /// The lines of some rows in which one of the points is `open`.
    fn lines(&self, rows: &Rows, open: impl Fn(usize) -> bool) -> Vec<usize> {
        let length = self.line();
        let lines = rows.range.start / length..rows.range.end / length;
        lines.filter(|line| (line * length..(line + 1) * length).any(&open)).collect()
    }

    /// The lines to be run.
    fn missing(&self, rows: &Rows) -> Vec<usize> {
        self.lines(rows, |index| rows.is_open(index))
    }

    /// The lines to be checked: counted from the first one of the sweep, so that chunks check the same ones.
    fn unchecked(&self, rows: &Rows) -> Vec<usize> {
        let open = |index: usize| !(rows.checks.contains_key(&index) || rows.errors.contains_key(&index));
        self.lines(rows, |index| (index / self.line()).is_multiple_of(self.check_every) && open(index))
    }
}
