//! Ensembles: many runs of a random model, reduced to distributions.

use crate::analysis::{Rattle, Statistics};
use crate::error::{ParameterError, check};
use crate::excitation::Side;
use crate::model::{Model, State};
use crate::ode::probe::Probe;
use crate::ode::{Exhausted, Integrator, Observer, Step, uniform_times};
use crate::sweep::ensembles::bands::{Bands, FailedMember, MemberResults};
use crate::sweep::sweep_error::{FamilyError, PointError};
use crate::sweep::watch::Watch;
use std::convert::Infallible;
use std::error::Error as AnyError;
use std::ops::{ControlFlow, Range};
use thiserror::Error;

/// Runs many members of a random model and keeps the distributions of channels, peaks and impact counts. The
/// runs themselves are not stored.
///
/// A member is a function of its number: a [random process](crate::drives::Noisy) [with that
/// member](crate::processes::HeldProcess::member), parameters [drawn for
/// it](crate::sweep::RandomParameters), or both. The results do not depend on the number of threads. The
/// memory does not depend on the number of members.
///
/// ```
/// use gear_dynamics::{sweep::Ensemble, ParameterError, Rk4, State, model::from_fn};
/// let family = |member: u64| {
///     let k = 1.0 + 0.01 * member as f64;
///     let spring = from_fn(1, move |_, q, _, a| a[0] = -k * q[0])?;
///     Ok::<_, ParameterError>((spring, State::new(0.0, &[1.0], &[0.0])))
/// };
/// let bands = Ensemble::new(10, 1.0, 4)?.channels(&["q0"]).run(&Rk4::new(0.05), family)?;
/// // A little below cos 1 = 0.54, since the stiffnesses are 1 to 1.09.
/// assert!((bands.at("q0", 4)?.mean() - 0.52).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "a setting returns a new value"]
pub struct Ensemble<'w> {
    members: u64,
    pub(crate) times: Vec<f64>,
    pub(crate) channels: Vec<String>,
    pub(crate) peaks: Vec<String>,
    rattle: bool,
    watch: Watch<'w>,
}

/// Calls a function with the model and the start of a member.
type Family<'f> = dyn Fn(u64, See<'_>) -> Result<(), PointError> + Sync + 'f;

/// What is done with a model and its start.
type See<'s> = &'s mut dyn FnMut(&dyn Model, &State) -> Result<(), PointError>;

/// Errors of an [`Ensemble`] as a whole.
///
/// ```
/// use gear_dynamics::sweep::{EnsembleError, FamilyError, PointError};
/// let error = EnsembleError::AllFailed { members: 3, first: PointError::Model(FamilyError::new("no torque")) };
/// assert_eq!(error.to_string(), "all 3 members failed; error of member 0: no model: no torque");
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum EnsembleError {
    /// A channel that the model does not have, or more than 2¹⁸ distributions.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// No member reached the end time.
    #[error("all {members} members failed; error of member 0: {first}")]
    AllFailed {
        /// Number of members.
        members: u64,
        /// Error of member 0.
        first: PointError,
    },
    /// The ensemble was cancelled before any member finished.
    #[error("the ensemble stopped before any of its {members} members finished: {exhausted}")]
    Exhausted {
        /// The reason, [`Exhausted::Cancelled`].
        exhausted: Exhausted,
        /// Number of members.
        members: u64,
    },
}

/// Maximum number of members per thread in one batch. The results of a batch are added in the order of the
/// member numbers, so that sums do not depend on the number of threads.
const WAITING: usize = 128;

/// Maximum number of members. At 1 µs for each member they take more than an hour.
const MAX_MEMBERS: u64 = u32::MAX as u64;

/// Maximum number of distributions, channels × spans: two gigabytes if all their bins are in use.
const MAX_DISTRIBUTIONS: usize = 1 << 18;

impl<'w> Ensemble<'w> {
    /// Members 0, 1, ... from time 0 to `end`, sampled at `spans + 1` equally spaced times, both ends
    /// included.
    ///
    /// Default: no channels, no peaks, no impacts.
    ///
    /// # Errors
    /// No members or more than 2³² - 1; no spans or more than 2¹⁸; an end that is not positive and finite.
    pub fn new(members: u64, end: f64, spans: usize) -> Result<Self, ParameterError> {
        if members == 0 {
            return Err(ParameterError::TooFew { name: "members".into(), value: 0, min: 1 });
        }
        check::at_least("spans of time", spans, 1)?;
        if members > MAX_MEMBERS {
            let value = usize::try_from(members).unwrap_or(usize::MAX);
            return Err(ParameterError::TooMany { name: "members".into(), value, max: MAX_MEMBERS as usize });
        }
        check::count("spans of time", &[spans], MAX_DISTRIBUTIONS)?;
        check::positive("end of the ensemble", end)?;
        let mut times = uniform_times(0.0, end, spans)?;
        times.push(end);
        Ok(Ensemble {
            members,
            times,
            channels: Vec::new(),
            peaks: Vec::new(),
            rattle: false,
            watch: Watch::default(),
        })
    }
    /// Requests the distribution of these channels at every time. Maximum: channels × spans = 2¹⁸.
    pub fn channels(self, names: &[&str]) -> Self {
        Ensemble { channels: names.iter().map(|name| (*name).to_owned()).collect(), ..self }
    }
    /// Requests the distribution of the peak of these channels: the maximum of |x| over the whole run, found
    /// inside the steps by [`Statistics`], not among the sampled times.
    pub fn peaks(self, names: &[&str]) -> Self {
        Ensemble { peaks: names.iter().map(|name| (*name).to_owned()).collect(), ..self }
    }
    /// Requests, for each contact, the distribution of the number of impacts and the shares of the rattle
    /// states.
    pub fn rattle(self) -> Self {
        Ensemble { rattle: true, ..self }
    }
    /// Progress by members, and a flag, checked after every step. If cancelled, the result holds the members
    /// that finished.
    pub fn watch(self, watch: Watch<'w>) -> Self {
        Ensemble { watch, ..self }
    }

    /// Runs all members. `family` maps a member number to the model and its start state at time 0.
    ///
    /// # Errors
    /// [`EnsembleError`]. If at least one member succeeds, members that fail are counted in
    /// [`Bands::failed`] instead. [`EnsembleError::Exhausted`] if cancelled before any member
    /// finished.
    pub fn run<M, X>(
        &self,
        solver: &(dyn Integrator + Sync),
        family: impl Fn(u64) -> Result<(M, State), X> + Sync,
    ) -> Result<Bands, EnsembleError>
    where
        M: Model,
        X: Into<Box<dyn AnyError + Send + Sync>>,
    {
        self.run_members(solver, &|member, see| {
            let (model, start) = family(member).map_err(|e| PointError::Model(FamilyError::new(e)))?;
            see(&model, &start)
        })
    }

    fn run_members(
        &self,
        solver: &(dyn Integrator + Sync),
        family: &Family<'_>,
    ) -> Result<Bands, EnsembleError> {
        let watch = &self.watch;
        let figures = check::count(
            "distributions, one for each channel and time",
            &[self.channels.len(), self.times.len() - 1],
            MAX_DISTRIBUTIONS,
        )?;
        let mut failure = None;
        // A channel that the first model does not have is an error of the whole ensemble.
        let mut channels = None;
        for member in (0..self.members).take_while(|_| !watch.is_cancelled()) {
            let known = family(member, &mut |model, _| {
                channels = Some(Probe::new(model).indices(self.channels.iter().chain(&self.peaks)));
                Ok(())
            });
            match known {
                Ok(()) => break,
                Err(error) => drop(failure.get_or_insert(error)),
            }
        }
        if let Some(channels) = channels {
            channels?;
        } else if let Some(first) = failure.filter(|_| !watch.is_cancelled()) {
            return Err(EnsembleError::AllFailed { members: self.members, first });
        }
        let mut bands = Bands::new(&self.times, &self.channels, &self.peaks);
        let all = self.members as usize;
        let (mut next, progress) = (0, watch.begin(0, all));
        let run = |members: Range<usize>| {
            let member = members.start as u64;
            let mut seen = None;
            let made = family(member, &mut |model, start| {
                seen = self.member(solver, model, start)?;
                Ok(())
            });
            let seen = made.map(|()| seen).transpose();
            Ok::<_, Infallible>(seen.map(|seen| (member, seen)))
        };
        while next < all && !watch.is_cancelled() {
            // A batch has fewer members if there are more distributions. This bounds the memory of the
            // results that are not added yet.
            let waiting = ((1 << 20) / (figures + 1)).clamp(1, WAITING);
            let until = (next + waiting * rayon::current_num_threads()).min(all);
            let Ok(seen) = progress.blocks(next..until, 1, run);
            for (member, seen) in seen {
                match seen {
                    Ok(seen) => bands.add(&seen),
                    Err(error) => bands.fail(member, error),
                }
            }
            next = until;
        }
        match bands.first_failure {
            _ if bands.members > 0 => Ok(bands),
            Some(FailedMember { error: first, .. }) if bands.failed == self.members => {
                Err(EnsembleError::AllFailed { members: self.members, first })
            }
            _ => {
                let exhausted = Exhausted::Cancelled;
                Err(EnsembleError::Exhausted { exhausted, members: self.members })
            }
        }
    }

    /// The results of one member; `None` if cancelled.
    fn member(
        &self,
        solver: &dyn Integrator,
        model: &dyn Model,
        start: &State,
    ) -> Result<Option<MemberResults>, PointError> {
        start.check_at_zero(model.dof()).map_err(PointError::Parameter)?;
        let mut probe = Probe::new(model);
        let chosen = probe.indices(&self.channels).map_err(PointError::Parameter)?;
        let peaks: Vec<&str> = self.peaks.iter().map(String::as_str).collect();
        let mut statistics = Statistics::new(model, &peaks).map_err(PointError::Parameter)?;
        let mut rattle = self.rattle.then(|| Rattle::new(model));
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
            step.sample(&mut left, &mut y, |t, y| look(t, Side::Before, y));
            // `Statistics` and `Rattle` always continue: their return values are ignored.
            if !peaks.is_empty() {
                let _ = statistics.step(step);
            }
            if let Some(rattle) = &mut rattle {
                let _ = rattle.step(step);
            }
            if self.watch.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let end = self.times[self.times.len() - 1];
        let finish = solver.run(model, start, end, &mut observe)?.checked(model.dof(), end)?;
        if finish.stopped {
            return Ok(None);
        }
        let peak = |name: &&str| statistics.summary(name).map(|x| x.max.abs().max(x.min.abs()));
        let peaks = peaks.iter().map(peak).collect::<Result<_, _>>().map_err(PointError::Value)?;
        let contacts = rattle.iter().flat_map(|r| r.contacts());
        let impacts = contacts.clone().map(|c| c.impact_count() as f64).collect();
        Ok(Some(MemberResults {
            values,
            peaks,
            impacts,
            states: contacts.map(|c| c.rattle_state()).collect(),
        }))
    }
}
