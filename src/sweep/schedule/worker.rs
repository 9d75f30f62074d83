//! The workers of a sweep: order of the runs and storage of their rows.

use crate::model::period::check_period;
use crate::model::{Periodic, State};
use crate::periodic::multipliers::Multipliers;
use crate::sweep::engines::sweep_engine::{Job, Source, SweepEngine};
use crate::sweep::engines::track::Plan;
use crate::sweep::rows::collection::Rows;
use crate::sweep::rows::layout::Layout;
use crate::sweep::rows::row::Row;
use crate::sweep::settings::points::Point;
use crate::sweep::settings::sweep::{Sweep, WarmStart};
use crate::sweep::sweep_error::PointError;
use crate::sweep::watch::{Progress, Watch};
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use std::sync::Mutex;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering;

/// The model of a point.
pub(crate) type ModelOf<'a, M> = dyn Fn(&Point<'_>) -> Result<M, PointError> + Sync + 'a;

/// The start state of the model of a point.
pub(crate) type StartOf<'a, M> = dyn Fn(&Point<'_>, &M) -> Result<State, PointError> + Sync + 'a;

/// What receives each row as soon as its run is complete.
pub(crate) type OfRows<'a> = dyn Fn(&Row<'_>) + Send + Sync + 'a;

/// Data that all workers of a sweep share.
pub(crate) struct Work<'s, M> {
    pub(crate) sweep: &'s Sweep,
    pub(crate) plan: &'s Plan,
    /// Indices of the requested channels among those of a [`Probe`](crate::ode::probe::Probe).
    pub(crate) channels: &'s [usize],
    /// Degrees of freedom and contacts of every model.
    pub(crate) shape: [usize; 2],
    /// Number of points in a line.
    pub(crate) length: usize,
    pub(crate) family: &'s ModelOf<'s, M>,
    pub(crate) start: &'s StartOf<'s, M>,
    pub(crate) watch: &'s Watch<'s>,
    pub(crate) rows: Mutex<&'s mut Rows>,
    /// What receives the rows, and rows without points, with names and layout, for them.
    pub(crate) show: Option<(&'s OfRows<'s>, Rows)>,
    /// Completed runs, checks included.
    pub(crate) progress: Progress<'s>,
}

impl<M: Periodic> Work<'_, M> {
    /// Makes the runs of some lines, or their checks. The workers, one on each thread, take line after line.
    pub(crate) fn all<E: SweepEngine<M>>(&self, engine: &E, lines: &[usize], checking: bool) {
        let workers = rayon::current_num_threads().min(lines.len().div_ceil(engine.batch().max(1)));
        let taken = AtomicUsize::new(0);
        (0..workers).into_par_iter().with_max_len(1).for_each(|_| {
            let taken = &taken;
            let mut source = Worker { work: self, engine, lines, taken, checking, ended: Vec::new() };
            engine.work(self.plan, self.channels, &mut source);
            source.add_exponents();
        });
    }
}

/// A worker on the lines of a sweep.
struct Worker<'b, 's, M, E> {
    work: &'b Work<'s, M>,
    engine: &'b E,
    lines: &'b [usize],
    /// Number of lines that all workers together have started.
    taken: &'b AtomicUsize,
    /// Whether the runs are checks.
    checking: bool,
    /// Rows that wait for their exponents.
    ended: Vec<EndedRun>,
}

/// The exponent and the multipliers of a row were found, or why not. `None`: the sweep was cancelled.
type Outcome = Option<Result<(), PointError>>;

/// Writes multipliers and their error into their place in a row.
fn write(found: &Multipliers, place: &mut [f64]) {
    if let Some((error, parts)) = place.split_last_mut() {
        *error = found.value_error();
        for (part, value) in parts.as_chunks_mut().0.iter_mut().zip(found.values()) {
            *part = [value.re, value.im];
        }
    }
}

/// A run without its exponent and multipliers.
struct EndedRun {
    index: usize,
    row: Vec<f64>,
    /// Its last state: coordinates, then velocities.
    state: Vec<f64>,
}

impl EndedRun {
    /// Period multiple of the motion; 0 if it does not repeat.
    fn multiple(&self) -> usize {
        let [multiple, ..] = Layout::group(&self.row, Layout::HEAD);
        *multiple as usize
    }
}

impl<M: Periodic, E: SweepEngine<M>> Worker<'_, '_, M, E> {
    /// The job of a point. `carried`: the state of a warm start, if any.
    fn job(&self, index: usize, carried: Option<&[f64]>) -> Result<Job<M>, PointError> {
        let point = self.work.sweep.points.point(index);
        let model = (self.work.family)(&point)?;
        let found = [model.dof(), model.contacts()];
        if found != self.work.shape {
            return Err(PointError::Shape { found, expected: self.work.shape });
        }
        let period = model.period();
        if !(period.is_finite() && period > 0.0) {
            return Err(PointError::Period { period });
        }
        let start = match carried {
            Some(state) => State::new(0.0, &state[..found[0]], &state[found[0]..]),
            None => (self.work.start)(&point, &model)?,
        };
        let checked = start.check_at_zero(found[0]).and_then(|()| check_period(&model, &start));
        checked.map_err(PointError::Parameter)?;
        Ok(Job { index, model, start })
    }

    /// Computes the exponents and the multipliers of the rows that wait for them, and stores the rows. Rows
    /// for which they are cancelled are dropped.
    fn add_exponents(&mut self) {
        let work = self.work;
        let (sweep, layout) = (work.sweep, &work.plan.layout);
        let go_on = || !work.watch.is_cancelled();
        let (mut jobs, mut waiting) = (Vec::new(), Vec::new());
        for mut ended in std::mem::take(&mut self.ended) {
            ended.row[layout.exponent()..layout.strobe(0)].fill(f64::NAN);
            match (work.family)(&sweep.points.point(ended.index)) {
                Ok(model) => {
                    let (q, v) = ended.state.split_at(layout.dof);
                    jobs.push(Job { index: ended.index, model, start: State::new(0.0, q, v) });
                    waiting.push(ended);
                }
                Err(error) => self.store(ended.index, Ok(ended.row), Some(error)),
            }
        }
        let mut outcomes: Vec<Outcome> = waiting.iter().map(|_| Some(Ok(()))).collect();
        if let Some(lyapunov) = &sweep.lyapunov {
            let found = self.engine.exponents(lyapunov, &jobs, &go_on);
            for ((ended, found), outcome) in waiting.iter_mut().zip(found).zip(&mut outcomes) {
                *outcome = found.map(|found| {
                    let found = found?;
                    let figures = [found.per_period()[0], found.standard_error()[0]];
                    ended.row[layout.exponent()..][..figures.len()].copy_from_slice(&figures);
                    Ok(())
                });
            }
        }
        if let Some(shooting) = &sweep.multipliers {
            let multiples: Vec<usize> = waiting.iter().map(|ended| ended.multiple()).collect();
            let jobs = jobs.into_iter().zip(&multiples).filter(|(_, multiple)| **multiple > 0);
            let jobs: Vec<_> = jobs.map(|(job, multiple)| (job, *multiple)).collect();
            let repeating = waiting.iter_mut().zip(&mut outcomes).filter(|(ended, _)| ended.multiple() > 0);
            for ((ended, outcome), found) in repeating.zip(self.engine.multipliers(shooting, &jobs, &go_on)) {
                let place = &mut ended.row[layout.multiplier()..][..layout.multipliers];
                let found = found.map(|found| -> Result<(), PointError> {
                    write(&found?, place);
                    Ok(())
                });
                *outcome = outcome.take().zip(found).map(|(before, found)| before.and(found));
            }
        }
        for (ended, outcome) in waiting.into_iter().zip(outcomes) {
            if let Some(outcome) = outcome {
                self.store(ended.index, Ok(ended.row), outcome.err());
            }
        }
    }

    /// Stores a row, and the error of its exponent, and reports them.
    fn store(&self, index: usize, row: Result<Vec<f64>, PointError>, without: Option<PointError>) {
        let work = self.work;
        let mut rows = work.rows.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let made = if self.checking {
            rows.put_check(index, row);
            None
        } else {
            rows.put(index, &row);
            rows.exponent_errors.extend(without.map(|error| (index, error)));
            row.ok()
        };
        // The functions that watch may be slow: they must not block other threads.
        drop(rows);
        if let (Some((show, rows)), Some(data)) = (&work.show, &made) {
            show(&Row { rows, index, data });
        }
        work.progress.add(1);
    }

    /// The next point of the line; `None` at the end of the line or without a warm start.
    fn neighbour(&self, index: usize) -> Option<usize> {
        let length = self.work.length;
        match self.work.sweep.warm_start {
            WarmStart::No => None,
            WarmStart::Up => Some(index + 1).filter(|i| !i.is_multiple_of(length)),
            WarmStart::Down => index.checked_sub(1).filter(|_| !index.is_multiple_of(length)),
        }
    }
}

impl<M: Periodic, E: SweepEngine<M>> Source<M> for Worker<'_, '_, M, E> {
    fn next(&mut self, after: Option<(usize, &[f64])>) -> Option<Job<M>> {
        let mut state = after.map(|(_, state)| state).filter(|state| !state.is_empty());
        let mut next = after.and_then(|(index, _)| self.neighbour(index));
        loop {
            if self.is_cancelled() {
                return None;
            }
            let index = match next {
                Some(index) => index,
                None => {
                    let line = *self.lines.get(self.taken.fetch_add(1, Ordering::Relaxed))?;
                    state = None;
                    let length = self.work.length;
                    if self.work.sweep.warm_start == WarmStart::Down {
                        (line + 1) * length - 1
                    } else {
                        line * length
                    }
                }
            };
            match self.job(index, state) {
                Ok(job) => return Some(job),
                Err(error) => {
                    self.put(index, Err(error));
                    // The next point of the line starts from the last state that is available.
                    next = self.neighbour(index);
                }
            }
        }
    }

    fn put(&mut self, index: usize, run: Result<(Vec<f64>, &[f64]), PointError>) {
        match run {
            Err(error) => self.store(index, Err(error), None),
            Ok((row, state)) if self.work.plan.layout.strobe(0) > self.work.plan.layout.exponent() => {
                self.ended.push(EndedRun { index, row, state: state.to_vec() });
                if self.ended.len() >= self.engine.exponents_at_once() {
                    self.add_exponents();
                }
            }
            Ok((row, _)) => self.store(index, Ok(row), None),
        }
    }

    fn with_model(&self, index: usize, read: &mut dyn FnMut(&dyn Periodic)) {
        if let Ok(model) = (self.work.family)(&self.work.sweep.points.point(index)) {
            read(&model);
        }
    }

    fn is_cancelled(&self) -> bool {
        self.work.watch.is_cancelled()
    }

    fn alone(&mut self, points: usize) {
        if !self.checking {
            self.work.rows.lock().unwrap_or_else(std::sync::PoisonError::into_inner).alone += points;
        }
    }
}
