//! Many members of a random model, reduced as they come.

use super::error::PointError;
use super::moments::Distribution;
use super::watch::Watch;
use crate::analysis::Rattle;
use crate::channel::Probe;
use crate::error::{ParameterError, check};
use crate::model::{Model, State};
use crate::ode::{Integrator, Step, uniform_times};
use crate::piece::Side;
use rayon::prelude::*;
use std::fmt::Display;
use std::ops::ControlFlow;
use thiserror::Error;

/// Members of a random model: its channels over time and its impacts, seen once for each member and never stored.
///
/// A member is a function of its number: a [`Held`](crate::Held) process [with that member](crate::HeldProcess::with_member), parameters
/// [drawn for it](crate::Uncertain), or both. What comes out does not depend on threads; memory does not depend on the number of members.
///
/// ```
/// use gear_dynamics::{Ensemble, Model, ParameterError, Rk4, State};
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
    times: Vec<f64>,
    channels: Vec<String>,
    rattle: bool,
}

/// Why an ensemble has no result.
///
/// ```
/// use gear_dynamics::EnsembleError;
/// assert_eq!(EnsembleError::AllFailed { members: 3 }.to_string(), "all of 3 members failed");
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum EnsembleError {
    /// A channel that the model does not have, a number that cannot be used.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// No member came to its end.
    #[error("all of {members} members failed")]
    AllFailed {
        /// How many there were.
        members: u64,
    },
}

/// Members that are run one after the other before they are put together: a fixed number, so that sums do not depend on threads.
const BLOCK: u64 = 32;

impl Ensemble {
    /// Members 0, 1, ... from time 0 to `end`, seen at `spans + 1` equally spaced times.
    ///
    /// # Errors
    /// No members, no spans, an end that is not positive.
    pub fn new(members: u64, end: f64, spans: usize) -> Result<Self, ParameterError> {
        if members == 0 {
            return Err(ParameterError::TooFew { name: "members".into(), value: 0, least: 1 });
        }
        if spans == 0 {
            return Err(ParameterError::TooFew { name: "spans of time".into(), value: 0, least: 1 });
        }
        check::positive("end of the ensemble", end)?;
        Ok(Ensemble { members, times: uniform_times(0.0, end, spans), channels: Vec::new(), rattle: false })
    }
    /// Channels whose distribution at every time is wanted, and that of their largest magnitude in a run.
    pub fn channels(self, names: &[&str]) -> Self {
        Ensemble { channels: names.iter().map(|name| (*name).to_owned()).collect(), ..self }
    }
    /// The distribution of the impacts of each contact is wanted.
    pub fn rattle(self) -> Self {
        Ensemble { rattle: true, ..self }
    }

    /// Runs all members; the family gives each its model and its start, at time 0.
    ///
    /// # Errors
    /// [`EnsembleError`].
    pub fn run<M, I, X>(&self, solver: &I, family: impl Fn(u64) -> Result<(M, State), X> + Sync) -> Result<Bands, EnsembleError>
    where
        M: Model,
        I: Integrator + Sync,
        X: Display,
    {
        self.run_watched(solver, family, &Watch::new())
    }

    /// The same with somebody looking on; when cancelled, the members done so far make the result.
    ///
    /// # Errors
    /// [`EnsembleError`].
    pub fn run_watched<M, I, X>(
        &self,
        solver: &I,
        family: impl Fn(u64) -> Result<(M, State), X> + Sync,
        watch: &Watch<'_>,
    ) -> Result<Bands, EnsembleError>
    where
        M: Model,
        I: Integrator + Sync,
        X: Display,
    {
        let mut bands = Bands::new(self);
        let mut next = 0;
        // Some blocks at a time, put together in order.
        let abreast = 4 * rayon::current_num_threads() as u64;
        while next < self.members && !watch.is_cancelled() {
            let until = (next + BLOCK * abreast).min(self.members);
            let members: Vec<u64> = (next..until).collect();
            let seen: Vec<Result<Seen, PointError>> =
                members.par_iter().map(|&member| self.member(solver, &family, member, watch)).collect();
            for (member, seen) in members.into_iter().zip(seen) {
                match seen {
                    Ok(seen) => bands.add(&seen)?,
                    Err(_) if watch.is_cancelled() => {}
                    Err(error) => bands.fail(member, error),
                }
            }
            next = until;
            watch.show(next as usize, self.members as usize);
        }
        if bands.members() == 0 { Err(EnsembleError::AllFailed { members: self.members }) } else { Ok(bands) }
    }

    fn member<M: Model, I: Integrator, X: Display>(
        &self,
        solver: &I,
        family: &impl Fn(u64) -> Result<(M, State), X>,
        member: u64,
        watch: &Watch<'_>,
    ) -> Result<Seen, PointError> {
        let (model, start) = family(member).map_err(|e| PointError::Model(e.to_string()))?;
        start.check(model.dof()).map_err(PointError::Start)?;
        let mut probe = Probe::new(&model);
        let chosen = self.channels.iter().map(|name| probe.index(name)).collect::<Result<Vec<_>, _>>().map_err(PointError::Start)?;
        let mut seen = Seen { values: Vec::with_capacity(chosen.len() * self.times.len()), impacts: Vec::new() };
        let mut y = [&start.q[..], &start.v].concat();
        let mut left = &self.times[1..];
        let mut look = |t: f64, side: Side, y: &[f64], values: &mut Vec<f64>| {
            let (q, v) = y.split_at(y.len() / 2);
            let all = probe.read(t, side, q, v);
            values.extend(chosen.iter().map(|&c| all[c]));
        };
        look(0.0, Side::After, &y, &mut seen.values);
        let mut rattle = self.rattle.then(|| Rattle::new(&model));
        let mut observe = |step: &mut Step<'_>| {
            while let [t, rest @ ..] = left
                && *t <= step.t1()
            {
                step.at(*t, &mut y);
                look(*t, Side::Before, &y, &mut seen.values);
                left = rest;
            }
            if watch.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let end = self.times[self.times.len() - 1];
        let finish = match &mut rattle {
            Some(rattle) => solver.run(&model, &start, end, &mut (&mut observe, rattle))?,
            None => solver.run(&model, &start, end, &mut observe)?,
        };
        if finish.stopped {
            return Err(PointError::Model("cancelled".into()));
        }
        seen.impacts = rattle.iter().flat_map(|r| r.contacts()).map(|c| c.impact_count() as f64).collect();
        Ok(seen)
    }
}

/// One member: its channels, time by time, and the impacts of its contacts.
struct Seen {
    values: Vec<f64>,
    impacts: Vec<f64>,
}

/// What an ensemble did: the distribution of every channel at every time.
///
/// ```
/// use gear_dynamics::{Ensemble, Model, ParameterError, Rk4, State};
/// struct Fall(f64);
/// impl Model for Fall {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], _: &[f64], _: &[f64], a: &mut [f64]) { a[0] = -self.0; }
/// }
/// let family = |member: u64| Ok::<_, ParameterError>((Fall(member as f64), State::at_rest(1)));
/// let bands = Ensemble::new(5, 2.0, 2)?.channels(&["q1"]).run(&Rk4::new(0.5), family)?;
/// assert_eq!((bands.times()[2], bands.at("q1", 2)?.min(), bands.at("q1", 2)?.mean()), (2.0, -8.0, -4.0)); // exact: the fall is a parabola
/// assert!((bands.band("q1", 0.5)?[1] + 1.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Bands {
    times: Vec<f64>,
    names: Vec<String>,
    /// Time by time, channel by channel.
    values: Vec<Distribution>,
    peaks: Vec<Distribution>,
    impacts: Vec<Distribution>,
    /// Members, and mean and standard error of each channel's peak, at powers of two.
    convergence: Vec<(u64, Vec<[f64; 2]>)>,
    members: u64,
    failed: u64,
    first_failure: Option<(u64, PointError)>,
}

impl Bands {
    fn new(ensemble: &Ensemble) -> Self {
        let channels = ensemble.channels.len();
        Bands {
            times: ensemble.times.clone(),
            names: ensemble.channels.clone(),
            values: vec![Distribution::new(); channels * ensemble.times.len()],
            peaks: vec![Distribution::new(); channels],
            impacts: Vec::new(),
            convergence: Vec::new(),
            members: 0,
            failed: 0,
            first_failure: None,
        }
    }

    fn add(&mut self, seen: &Seen) -> Result<(), ParameterError> {
        for (distribution, &x) in self.values.iter_mut().zip(&seen.values) {
            distribution.add(x);
        }
        let n = self.names.len();
        for (c, peak) in self.peaks.iter_mut().enumerate() {
            peak.add(seen.values.iter().skip(c).step_by(n).fold(0.0, |m: f64, x| m.max(x.abs())));
        }
        self.impacts.resize(seen.impacts.len(), Distribution::new());
        self.impacts.iter_mut().zip(&seen.impacts).for_each(|(d, x)| d.add(*x));
        self.members += 1;
        if self.members.is_power_of_two() {
            self.convergence.push((self.members, self.peaks.iter().map(|p| [p.mean(), p.standard_error()]).collect()));
        }
        Ok(())
    }

    fn fail(&mut self, member: u64, error: PointError) {
        self.failed += 1;
        self.first_failure.get_or_insert((member, error));
    }

    /// The times.
    pub fn times(&self) -> &[f64] {
        &self.times
    }
    /// Members that came to their end.
    pub fn members(&self) -> u64 {
        self.members
    }
    /// Members that did not, with the number and the error of the first one.
    pub fn failed(&self) -> (u64, Option<&(u64, PointError)>) {
        (self.failed, self.first_failure.as_ref())
    }

    fn index(&self, channel: &str) -> Result<usize, ParameterError> {
        let place = self.names.iter().position(|name| name == channel);
        place.ok_or_else(|| ParameterError::NoSuchChannel { name: channel.into(), known: self.names.join(", ") })
    }

    /// The distribution of a channel at the `i`-th time.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`], and a time that there is not.
    pub fn at(&self, channel: &str, i: usize) -> Result<&Distribution, ParameterError> {
        let at = i * self.names.len() + self.index(channel)?;
        let most = self.times.len();
        self.values.get(at).ok_or(ParameterError::Length { name: "times".into(), expected: i + 1, found: most })
    }
    /// Quantile `p` of a channel over time.
    ///
    /// # Errors
    /// [`ParameterError`] as of [`at`](Bands::at) and [`Distribution::quantile`].
    pub fn band(&self, channel: &str, p: f64) -> Result<Vec<f64>, ParameterError> {
        (0..self.times.len()).map(|i| self.at(channel, i)?.quantile(p)).collect()
    }
    /// Mean of a channel over time.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`].
    pub fn mean(&self, channel: &str) -> Result<Vec<f64>, ParameterError> {
        (0..self.times.len()).map(|i| Ok(self.at(channel, i)?.mean())).collect()
    }
    /// The distribution of the largest magnitude of a channel among the times of a run.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`].
    pub fn peak(&self, channel: &str) -> Result<&Distribution, ParameterError> {
        Ok(&self.peaks[self.index(channel)?])
    }
    /// The distribution of the number of impacts of contact `i` in a run, if [`rattle`](Ensemble::rattle) was asked for.
    pub fn impacts(&self, i: usize) -> Option<&Distribution> {
        self.impacts.get(i)
    }
    /// How the mean peak of a channel came to rest: members, mean and standard error, at powers of two.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`].
    pub fn convergence(&self, channel: &str) -> Result<Vec<(u64, f64, f64)>, ParameterError> {
        let i = self.index(channel)?;
        Ok(self.convergence.iter().map(|(members, peaks)| (*members, peaks[i][0], peaks[i][1])).collect())
    }
}
