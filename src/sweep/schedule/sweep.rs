//! A sweep and how it is run.

use crate::error::ParameterError;
use crate::model::equations::{Periodic, State};
use crate::ode::probe::Probe;
use crate::periodic::lyapunov::run::Lyapunov;
use crate::sweep::engines::interface::SweepEngine;
use crate::sweep::engines::track::Plan;
use crate::sweep::error::{PointError, RowsError, SweepError};
use crate::sweep::monitor::Monitor;
use crate::sweep::rows::hash::Hash;
use crate::sweep::rows::table::{Layout, Rows};
use crate::sweep::schedule::block::Work;
use crate::sweep::settings::points::{Point, Points};
use std::fmt::Display;
use std::sync::Mutex;
use std::sync::atomic::AtomicUsize;

/// Where a run starts from.
///
/// A state carried from a speed close by is nearly settled: what is measured at once is what is measured after a turn.
///
/// ```
/// use gear_dynamics::{sweep::{Axis, LaneRk4, Points, WarmStart}, NfgPair, NfgParams, Sweep};
/// let speeds = Points::along(Axis::linear("speed", 120.0, 120.4, 3)?);
/// let ppv = |carry, settle| -> Result<f64, Box<dyn std::error::Error>> {
///     let rows = Sweep::over(speeds.clone()).settle(settle).measure(1).channels(&["q1"]).carry(carry).run(
///         &LaneRk4::<4>::new(63 * 16),
///         |p| NfgPair::new(&NfgParams { speed: p["speed"], ..NfgParams::table1() }),
///         |_, pair| pair.static_start(),
///     )?;
///     Ok(rows.row(2).ok_or("cancelled")?.map_err(Clone::clone)?.channel("q1")?.peak_to_peak())
/// };
/// let settled = ppv(WarmStart::No, 1)?;
/// assert!((ppv(WarmStart::Up, 0)? / settled - 1.0).abs() < 1e-3);
/// assert!((ppv(WarmStart::No, 0)? / settled - 1.0).abs() > 1e-2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WarmStart {
    /// From the start of its own point.
    #[default]
    No,
    /// From where its neighbour of lower index ended: along the last axis of a grid, or along the list. The first one of a line has a start.
    Up,
    /// From where its neighbour of higher index ended.
    Down,
}

/// Many runs of one family of models: which points, how long to settle and to measure, and what. Nothing is stored of a run but its row.
///
/// A rattle map in ten lines:
///
/// ```
/// use gear_dynamics::{sweep::{Axis, LaneRk4, Points}, NfgPair, NfgParams, Sweep};
/// let map = Sweep::over(Points::grid(vec![Axis::linear("speed", 120.0, 180.0, 4)?, Axis::linear("load", 20.0, 40.0, 4)?])?)
///     .settle(4)
///     .measure(1)
///     .channels(&["q1"])
///     .rattle()
///     .run(
///         &LaneRk4::<16>::new(63 * 32),
///         |p| NfgPair::new(&NfgParams { speed: p["speed"], load_torque: p["load"], ..NfgParams::table1() }),
///         |_, pair| pair.static_start(),
///     )?;
/// assert_eq!(map.iter().filter(|row| row.state(0) as u8 == 2).count(), 7);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    pub(crate) points: Points,
    settle: usize,
    measure: usize,
    repeat: Option<f64>,
    tolerance: f64,
    channels: Vec<String>,
    rattle: bool,
    strobes: usize,
    pub(crate) lyapunov: Option<Lyapunov>,
    pub(crate) carry: WarmStart,
    check_every: usize,
}

impl Sweep {
    /// Settles 60 periods and measures 40, as nothing else is said.
    pub fn over(points: Points) -> Self {
        Sweep {
            points,
            settle: 60,
            measure: 40,
            repeat: None,
            tolerance: 1e-6,
            channels: Vec::new(),
            rattle: false,
            strobes: 0,
            lyapunov: None,
            carry: WarmStart::No,
            check_every: 0,
        }
    }
    /// Periods to settle.
    pub fn settle(self, periods: usize) -> Self {
        Sweep { settle: periods, ..self }
    }
    /// Ends settling early, once the strobed state repeats this closely, as a share of the range of each coordinate and velocity over a
    /// period; rigid motion does not count.
    pub fn until_repeats(self, tolerance: f64) -> Self {
        Sweep { repeat: Some(tolerance), ..self }
    }
    /// Periods to measure over, at least one.
    pub fn measure(self, periods: usize) -> Self {
        Sweep { measure: periods, ..self }
    }
    /// How closely a motion has to return to count as periodic, in the same shares; 1e-6 if nothing is said.
    pub fn periodic_within(self, tolerance: f64) -> Self {
        Sweep { tolerance, ..self }
    }
    /// Channels of which mean, RMS and extremes are wanted (see [`Probe`]).
    pub fn channels(self, names: &[&str]) -> Self {
        Sweep { channels: names.iter().map(|name| (*name).to_owned()).collect(), ..self }
    }
    /// Rattle state, contact loss and impacts of every contact are wanted.
    pub fn rattle(self) -> Self {
        Sweep { rattle: true, ..self }
    }
    /// The last `count` strobed states are wanted, at most those of the measured periods, with the extremes of the channels in each of their periods.
    pub fn strobe(self, count: usize) -> Self {
        Sweep { strobes: count, ..self }
    }
    /// The largest Lyapunov exponent is wanted. It is computed with the variational equations and located edges, whatever the engine: from where
    /// the run of the point has ended, so that nothing is left to settle, over the periods and with the tolerance of `lyapunov`; how many it
    /// settles and how many exponents it computes otherwise is of no account. It costs about as much as three times the periods with
    /// [`Located`](crate::sweep::Located).
    pub fn lyapunov(self, lyapunov: Lyapunov) -> Self {
        Sweep { lyapunov: Some(lyapunov.settle(0).count(1)), ..self }
    }
    /// Where runs start from.
    pub fn carry(self, carry: WarmStart) -> Self {
        Sweep { carry, ..self }
    }
    /// Every `count`-th point of the sweep is run once more with a quarter of the step, which says how far the step is off; 0 checks none. Lines
    /// along which states are carried are run again as a whole, for every `count`-th of them.
    pub fn check_every(self, count: usize) -> Self {
        Sweep { check_every: count, ..self }
    }
    pub(crate) fn names(&self) -> &[String] {
        &self.channels
    }
    /// Figures of a Lyapunov exponent in a row.
    pub(crate) fn exponents(&self) -> usize {
        if self.lyapunov.is_some() { 2 } else { 0 }
    }
    /// The points.
    pub fn points(&self) -> &Points {
        &self.points
    }

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

    /// Points that are run one after the other, the state carried from each to the next.
    fn line(&self) -> usize {
        if self.carry == WarmStart::No { 1 } else { self.points.line() }
    }
    /// The lines of some rows in which one of the points is `open`.
    fn lines(&self, rows: &Rows, open: impl Fn(usize) -> bool) -> Vec<usize> {
        let length = self.line();
        let lines = rows.range.start / length..rows.range.end / length;
        lines.filter(|line| (line * length..(line + 1) * length).any(&open)).collect()
    }
    /// The lines to be run.
    fn missing(&self, rows: &Rows) -> Vec<usize> {
        self.lines(rows, |index| rows.row(index).is_none())
    }
    /// The lines to be checked: counted from the first one of the sweep, so that chunks check the same ones.
    fn unchecked(&self, rows: &Rows) -> Vec<usize> {
        let open = |index: usize| !(rows.checks.contains_key(&index) || rows.errors.contains_key(&index));
        self.lines(rows, |index| (index / self.line()).is_multiple_of(self.check_every) && open(index))
    }

    fn check(&self) -> Result<(), SweepError> {
        if self.measure == 0 {
            return Err(SweepError::Setting { name: "measure", value: 0.0, allowed: "at least 1 period" });
        }
        for (name, value) in [("periodic_within", Some(self.tolerance)), ("until_repeats", self.repeat)] {
            if let Some(value) = value.filter(|x| !(x.is_finite() && *x > 0.0)) {
                return Err(SweepError::Setting { name, value, allowed: "positive and finite" });
            }
        }
        if let Some(lyapunov) = &self.lyapunov {
            lyapunov.check_settings()?;
        }
        Ok(())
    }
}
