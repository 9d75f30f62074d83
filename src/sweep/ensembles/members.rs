//! Many members of a random model, reduced as they come.

use crate::analysis::rattle::Rattle;
use crate::analysis::statistics::Statistics;
use crate::error::{ParameterError, check};
use crate::excitation::side::Side;
use crate::model::equations::{Model, State};
use crate::ode::integrator::Integrator;
use crate::ode::probe::Probe;
use crate::ode::step::{Observer, Step};
use crate::ode::trajectory::uniform_times;
use crate::sweep::ensembles::bands::{Bands, Seen};
use crate::sweep::error::PointError;
use crate::sweep::monitor::Monitor;
use rayon::prelude::*;
use std::fmt::Display;
use std::ops::ControlFlow;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering;
use thiserror::Error;

/// Members of a random model: its channels over time and its impacts, seen once for each member and never stored.
///
/// A member is a function of its number: a [`Held`](crate::drives::Held) process [with that member](crate::drives::HeldProcess::with_member), parameters
/// [drawn for it](crate::sweep::RandomParameters), or both. What comes out does not depend on threads; memory does not depend on the number of members.
///
/// ```
/// use gear_dynamics::{sweep::Ensemble, Model, ParameterError, Rk4, State};
/// struct Spring(f64);
/// impl Model for Spring {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) { a[0] = -self.0 * q[0]; }
/// }
/// let family = |member: u64| Ok::<_, ParameterError>((Spring(1.0 + 0.01 * member as f64), State::new(0.0, &[1.0], &[0.0])));
/// let bands = Ensemble::new(10, 1.0, 4)?.channels(&["q1"]).run(&Rk4::new(0.05), family)?;
/// assert!((bands.at("q1", 4)?.mean() - 0.52).abs() < 0.01); // near cos 1, the springs being stiffer
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Ensemble {
    members: u64,
    pub(crate) times: Vec<f64>,
    pub(crate) channels: Vec<String>,
    pub(crate) peaks: Vec<String>,
    rattle: bool,
}

/// Why an ensemble has no result.
///
/// ```
/// use gear_dynamics::sweep::{EnsembleError, PointError};
/// let error = EnsembleError::AllFailed { members: 3, first: PointError::Model("no torque".into()) };
/// assert_eq!(error.to_string(), "all of 3 members failed, the first one: no model: no torque");
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum EnsembleError {
    /// A channel that the model does not have, a number that cannot be used.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// No member came to its end.
    #[error("all of {members} members failed, the first one: {first}")]
    AllFailed {
        /// How many there were.
        members: u64,
        /// Why member 0 did.
        first: PointError,
    },
    /// Cancelled before a member was done.
    #[error("cancelled before one of {members} members was done")]
    Cancelled {
        /// How many there were.
        members: u64,
    },
}

/// For each thread, members that are run before all are added up, in the order of their numbers: sums do not depend on threads.
const WAITING: u64 = 128;

/// Most members: more than an hour at a microsecond each.
const MOST_MEMBERS: u64 = u32::MAX as u64;

/// Most distributions, a channel at a time each: two gigabytes when all are full.
const MOST_FIGURES: usize = 1 << 18;

impl Ensemble {
    /// Members 0, 1, ... from time 0 to `end`, seen at `spans + 1` equally spaced times.
    ///
    /// # Errors
    /// No members or more than 2³² - 1; no spans or more than 2¹⁸; an end that is not positive and finite.
    pub fn new(members: u64, end: f64, spans: usize) -> Result<Self, ParameterError> {
        if members == 0 {
            return Err(ParameterError::TooFew { name: "members".into(), value: 0, least: 1 });
        }
        if spans == 0 {
            return Err(ParameterError::TooFew { name: "spans of time".into(), value: 0, least: 1 });
        }
        if members > MOST_MEMBERS {
            let value = usize::try_from(members).unwrap_or(usize::MAX);
            return Err(ParameterError::TooMany {
                name: "members".into(),
                value,
                most: MOST_MEMBERS as usize,
            });
        }
        check::count("spans of time", &[spans], MOST_FIGURES)?;
        check::positive("end of the ensemble", end)?;
        Ok(Ensemble {
            members,
            times: uniform_times(0.0, end, spans)?,
            channels: Vec::new(),
            peaks: Vec::new(),
            rattle: false,
        })
    }
    /// Channels whose distribution at every time is wanted: at most 2¹⁸ distributions.
    pub fn channels(self, names: &[&str]) -> Self {
        Ensemble { channels: names.iter().map(|name| (*name).to_owned()).collect(), ..self }
    }
    /// Channels of which the distribution of the largest magnitude in a run is wanted: that of the whole run, found inside the steps as by
    /// [`Statistics`], not among the times.
    pub fn peaks(self, names: &[&str]) -> Self {
        Ensemble { peaks: names.iter().map(|name| (*name).to_owned()).collect(), ..self }
    }
    /// The distribution of the impacts of each contact is wanted.
    pub fn rattle(self) -> Self {
        Ensemble { rattle: true, ..self }
    }

    /// Runs all members; the family gives each its model and its start, at time 0.
    ///
    /// # Errors
    /// [`EnsembleError`].
    pub fn run<M, I, X>(
        &self,
        solver: &I,
        family: impl Fn(u64) -> Result<(M, State), X> + Sync,
    ) -> Result<Bands, EnsembleError>
    where
        M: Model,
        I: Integrator + Sync,
        X: Display,
    {
        self.run_watched(solver, family, &Monitor::new())
    }

    /// The same with somebody looking on, after every member; there are no rows to show. When cancelled, the members done so far make the result.
    ///
    /// # Errors
    /// [`EnsembleError`].
    pub fn run_watched<M, I, X>(
        &self,
        solver: &I,
        family: impl Fn(u64) -> Result<(M, State), X> + Sync,
        watch: &Monitor<'_>,
    ) -> Result<Bands, EnsembleError>
    where
        M: Model,
        I: Integrator + Sync,
        X: Display,
    {
        let figures = check::count(
            "distributions, one for each channel and time",
            &[self.channels.len(), self.times.len() - 1],
            MOST_FIGURES,
        )?;
        let mut failure = None;
        let model =
            (0..self.members).take_while(|_| !watch.is_cancelled()).find_map(|member| match family(member) {
                Ok((model, _)) => Some(model),
                Err(error) => {
                    failure.get_or_insert_with(|| PointError::Model(error.to_string()));
                    None
                }
            });
        // A name that the first model does not have is a mistake of the whole.
        if let Some(model) = &model {
            let probe = Probe::new(model);
            self.channels.iter().chain(&self.peaks).try_for_each(|name| probe.index(name).map(|_| ()))?;
        } else if let Some(first) = failure.filter(|_| !watch.is_cancelled()) {
            return Err(EnsembleError::AllFailed { members: self.members, first });
        }
        let mut bands = Bands::new(self);
        let (mut next, shown) = (0, AtomicUsize::new(0));
        while next < self.members && !watch.is_cancelled() {
            // Few members with many figures wait as long as many with few.
            let waiting = ((1 << 20) / (figures as u64 + 1)).clamp(1, WAITING);
            let until = (next + waiting * rayon::current_num_threads() as u64).min(self.members);
            let run = |member| {
                let seen = self.member(solver, &family, member, watch).transpose();
                if seen.is_some() {
                    watch.show(1 + shown.fetch_add(1, Ordering::Relaxed), self.members as usize);
                }
                seen
            };
            let seen: Vec<Option<Result<Seen, PointError>>> =
                (next..until).into_par_iter().map(run).collect();
            for (member, seen) in (next..until).zip(seen) {
                match seen {
                    Some(Ok(seen)) => bands.add(&seen),
                    Some(Err(error)) => bands.fail(member, error),
                    None => {}
                }
            }
            next = until;
        }
        match bands.first_failure {
            _ if bands.members > 0 => Ok(bands),
            Some((_, first)) if bands.failed == self.members => {
                Err(EnsembleError::AllFailed { members: self.members, first })
            }
            _ => Err(EnsembleError::Cancelled { members: self.members }),
        }
    }

    /// One member, or nothing when cancelled.
    fn member<M: Model, I: Integrator, X: Display>(
        &self,
        solver: &I,
        family: &impl Fn(u64) -> Result<(M, State), X>,
        member: u64,
        watch: &Monitor<'_>,
    ) -> Result<Option<Seen>, PointError> {
        let (model, start) = family(member).map_err(|e| PointError::Model(e.to_string()))?;
        start.check(model.dof()).map_err(PointError::Start)?;
        if start.t != 0.0 {
            let (name, value) = ("start.t".into(), start.t);
            return Err(PointError::Start(ParameterError::OutOfRange {
                name,
                value,
                allowed: "0: members begin at time 0",
            }));
        }
        let mut probe = Probe::new(&model);
        let chosen = self
            .channels
            .iter()
            .map(|name| probe.index(name))
            .collect::<Result<Vec<_>, _>>()
            .map_err(PointError::Start)?;
        let peaks: Vec<&str> = self.peaks.iter().map(String::as_str).collect();
        let mut statistics = Statistics::new(&model, &peaks).map_err(PointError::Start)?;
        let mut rattle = self.rattle.then(|| Rattle::new(&model));
        let mut values = Vec::with_capacity(chosen.len() * self.times.len());
        let mut y = [&start.q[..], &start.v].concat();
        let mut left = &self.times[1..];
        let mut look = |t: f64, side: Side, y: &[f64]| {
            let (q, v) = y.split_at(y.len() / 2);
            let all = probe.read(t, side, q, v);
            values.extend(chosen.iter().map(|&c| all[c]));
        };
        look(0.0, Side::After, &y);
        let mut observe = |step: &mut Step<'_>| {
            while let [t, rest @ ..] = left
                && *t <= step.t1()
            {
                step.at(*t, &mut y);
                look(*t, Side::Before, &y);
                left = rest;
            }
            // Neither stops a run.
            if !peaks.is_empty() {
                let _ = statistics.step(step);
            }
            if let Some(rattle) = &mut rattle {
                let _ = rattle.step(step);
            }
            if watch.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let end = self.times[self.times.len() - 1];
        let finish = solver.run(&model, &start, end, &mut observe)?;
        if finish.stopped {
            return Ok(None);
        }
        let peak = |name: &&str| statistics.summary(name).map(|x| x.max.abs().max(x.min.abs()));
        let peaks = peaks.iter().map(peak).collect::<Result<_, _>>().map_err(PointError::Figure)?;
        let impacts = rattle.iter().flat_map(|r| r.contacts()).map(|c| c.impact_count() as f64).collect();
        Ok(Some(Seen { values, peaks, impacts }))
    }
}
