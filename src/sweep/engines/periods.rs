//! Engines that make a run period by period: those of one's own, and the loop that they share with `Located`.

use crate::analysis::{ContactStatistics, Summary};
use crate::error::{ParameterError, check};
use crate::model::{Channel, Periodic, State};
use crate::ode::Probe;
use crate::sweep::engines::sweep_engine::{Job, Source, SweepEngine};
use crate::sweep::engines::track::{Next, Plan, Track, WithModel};
use crate::sweep::lanes::flanks::ContactMeter;
use crate::sweep::lanes::meter::ChannelMeter;
use crate::sweep::sweep_error::{PointError, SweepError};
use std::collections::VecDeque;
use std::fmt;

/// An engine of one's own: advances a run of a sweep by one period and reports what it measured there.
/// [`ByPeriods`] makes a [`SweepEngine`] of it. The sweep itself chooses the starts, ends settling, finds
/// period multiples, writes the rows, and computes exponents and multipliers.
///
/// For another solver no engine is needed: [`Located`](crate::sweep::Located) takes every
/// [`Integrator`](crate::Integrator).
///
/// ```
/// use gear_dynamics::analysis::{ContactStatistics, Summary};
/// use gear_dynamics::models::Oscillator;
/// use gear_dynamics::sweep::{Axis, ByPeriods, EnginePeriod, Located, PeriodEngine, PointError};
/// use gear_dynamics::{Dop853, ParameterError, State, Sweep};
/// /// The steady motion of an oscillator without backlash in closed form: size cos(ωt - lag).
/// struct Exact;
/// impl PeriodEngine<Oscillator> for Exact {
///     fn period(
///         &self,
///         model: &Oscillator,
///         state: &mut State,
///         period: &mut EnginePeriod<'_>,
///     ) -> Result<(), PointError> {
///         let w = model.constant("speed").map_err(PointError::of_engine)?;
///         let (damping, force) = (0.1, 0.3);
///         let (lag, size) = ((damping * w).atan2(1.0 - w * w), force / (1.0 - w * w).hypot(damping * w));
///         *state = State::new(period.end(), &[size * lag.cos()], &[size * w * lag.sin()]);
///         if period.is_measured() {
///             let q0 = Summary::of_figures(0.0, size / 2f64.sqrt(), [-size, size]);
///             period.channel(0, &q0.map_err(PointError::of_engine)?);
///             period.contact(0, &ContactStatistics::default());
///         }
///         Ok(())
///     }
/// }
/// let given = [("damping", 0.1), ("mesh stiffness", 1.0), ("mean force", 0.0), ("force", 0.3)];
/// let rest = [("cubic stiffness", 0.0), ("half backlash", 0.0)];
/// let model = |w: f64| Oscillator::new(&[&given[..], &rest, &[("speed", w)]].concat());
/// let sweep = Sweep::new(Axis::linear("speed", 0.5, 1.5, 5)?).settle(60).measure(1).channels(&["q0"]);
/// let exact = sweep.of(&ByPeriods(Exact), |p| model(p["speed"])).run()?;
/// let located = sweep.of(&Located(Dop853::new()), |p| model(p["speed"])).run()?;
/// for i in 0..5 {
///     let (a, b) = (exact.get(i)?.channel("q0")?, located.get(i)?.channel("q0")?);
///     assert!((a.max / b.max - 1.0).abs() < 1e-2);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait PeriodEngine<M: Periodic>: Sync {
    /// Advances `state` to [`period.end()`](EnginePeriod::end). In a
    /// [measured](EnginePeriod::is_measured) period it reports every channel and every contact.
    ///
    /// # Errors
    /// Any: the point has this error in place of a row. [`PointError::of_engine`] takes an error of any type.
    fn period(&self, model: &M, state: &mut State, period: &mut EnginePeriod<'_>) -> Result<(), PointError>;
    /// Refuses channels that the engine does not measure. Default: it measures all.
    ///
    /// # Errors
    /// [`SweepError::Channel`] with the name of such a channel.
    fn accepts(&self, model: &M, channels: &[Channel]) -> Result<(), SweepError> {
        let _ = (model, channels);
        Ok(())
    }
    /// The engine with a quarter of the step or a hundredth of the tolerances, for
    /// [`check_every`](crate::Sweep::check_every). Default: `None`.
    fn finer(&self) -> Option<Self>
    where
        Self: Sized,
    {
        None
    }
}

/// The engine of a sweep whose runs a [`PeriodEngine`] makes, period by period. The page of `PeriodEngine`
/// has an example.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByPeriods<E>(pub E);

impl<M: Periodic, E: PeriodEngine<M>> SweepEngine<M> for ByPeriods<E> {
    fn accepts(&self, model: &M, channels: &[usize]) -> Result<(), SweepError> {
        self.0.accepts(model, &named(model, channels))
    }
    fn finer(&self) -> Option<Self> {
        self.0.finer().map(ByPeriods)
    }
    fn work(&self, plan: &Plan, channels: &[usize], source: &mut dyn Source<M>) {
        each_job(source, |job, cancelled| {
            let (model, channels) = (&job.model, named(&job.model, channels));
            run((plan, &channels), model, &job.start, cancelled, &mut |state, period| {
                self.0.period(model, state, period)?;
                period.finish(state)
            })
        });
    }
}

/// The channels with these indices among those of a [`Probe`].
fn named(model: &dyn Periodic, channels: &[usize]) -> Vec<Channel> {
    let probe = Probe::new(model);
    channels.iter().filter_map(|&i| probe.channels().get(i).cloned()).collect()
}

/// A row and the last state of its run; `None` if cancelled.
pub(crate) type RunOfPeriods = Option<(Vec<f64>, Vec<f64>)>;

/// Makes the runs of all jobs of a source, one after the other, with a function that also asks whether the
/// sweep is cancelled.
pub(crate) fn each_job<M>(
    source: &mut dyn Source<M>,
    one: impl Fn(&Job<M>, &dyn Fn() -> bool) -> Result<RunOfPeriods, PointError>,
) {
    let mut next = VecDeque::new();
    while !source.is_cancelled() {
        let Some(job) = next.pop_front().or_else(|| source.next(None)) else { return };
        let index = job.index;
        match one(&job, &|| source.is_cancelled()) {
            Ok(None) => return,
            Ok(Some((row, state))) => {
                source.put(index, Ok((row, &state)));
                next.extend(source.next(Some((index, &state))));
            }
            Err(error) => {
                source.put(index, Err(error));
                next.extend(source.next(Some((index, &[]))));
            }
        }
    }
}

/// One period of a run: what the engine must make, and where it reports.
pub struct EnginePeriod<'p> {
    track: &'p mut Track,
    end: f64,
    length: f64,
    channels: &'p [Channel],
    cancelled: &'p dyn Fn() -> bool,
    dof: usize,
    /// Number of contacts of the row.
    contacts: usize,
    /// Numbers of channels and contacts that were reported.
    reported: [usize; 2],
    steps: u64,
    wrong: Option<ParameterError>,
}

impl fmt::Debug for EnginePeriod<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("EnginePeriod").field("end", &self.end).finish_non_exhaustive()
    }
}

impl EnginePeriod<'_> {
    /// The time at which the period ends.
    pub fn end(&self) -> f64 {
        self.end
    }
    /// The channels of the sweep, in the order of their numbers in [`channel`](EnginePeriod::channel).
    pub fn channels(&self) -> &[Channel] {
        self.channels
    }
    /// Whether the period is measured; if not, the run settles.
    pub fn is_measured(&self) -> bool {
        self.track.measuring()
    }
    /// Whether the sweep is cancelled. A long period asks from time to time and returns; it leaves no row.
    pub fn is_cancelled(&self) -> bool {
        (self.cancelled)()
    }
    /// Shows a state within the period: coordinates, then velocities, 2 dof values. The range of the motion,
    /// against which its repetition is judged, comes from them. Some tens in every period are enough.
    pub fn see(&mut self, state: &[f64]) {
        if state.len() != 2 * self.dof {
            let (name, expected, found) = ("state that the engine shows".into(), 2 * self.dof, state.len());
            self.wrong.get_or_insert(ParameterError::Length { name, expected, found });
        } else if let Some(value) = state.iter().copied().find(|x| !x.is_finite()) {
            let name = "state that the engine shows".into();
            self.wrong.get_or_insert(ParameterError::NotFinite { name, value });
        } else if self.wants_states() {
            self.track.see_state(state.iter().copied());
        }
    }
    /// Whether [`see`](EnginePeriod::see) reads states in this period.
    pub fn wants_states(&self) -> bool {
        self.track.ranging()
    }
    /// Reports channel `i` over the period.
    pub fn channel(&mut self, i: usize, summary: &Summary) {
        match i < self.track.channels() && i == self.reported[0] {
            true => match summary.check(&format!("channel {i}")) {
                Ok(()) => self.add_channel(i, summary),
                Err(wrong) => {
                    self.wrong.get_or_insert(wrong);
                }
            },
            false => self.out_of_turn("channel", i, self.reported[0]),
        }
        self.reported[0] += 1;
    }
    /// Adds a summary of the period.
    pub(crate) fn add_channel(&mut self, i: usize, summary: &Summary) {
        self.track.add_channel(i, &ChannelMeter::of(summary, self.length), self.length);
    }
    /// Number of the period, counted from 1.
    pub fn number(&self) -> usize {
        self.track.periods + 1
    }
    /// Reports contact `i` over the period: the times on its flanks, the impacts. A sweep without
    /// [`rattle`](crate::Sweep::rattle) does not read it.
    pub fn contact(&mut self, i: usize, counted: &ContactStatistics) {
        if self.contacts == 0 {
            return;
        }
        let whole: f64 = counted.time.iter().sum();
        let is_whole =
            counted.time.iter().all(|time| *time >= 0.0) && (whole / self.length - 1.0).abs() < 1e-6;
        match i < self.contacts && i == self.reported[1] {
            true if is_whole => self.contact_since(i, *counted, &mut ContactStatistics::default()),
            true => {
                let name = format!("sum of the times of contact {i} that the engine reports");
                let must = format!("be {:?}, the period, of times that are not negative", self.length);
                self.wrong.get_or_insert(ParameterError::Wrong { name, value: whole, must });
            }
            false => self.out_of_turn("contact", i, self.reported[1]),
        }
        self.reported[1] += 1;
    }
    /// Reports what contact `i` did since `before`, which becomes `now`.
    pub(crate) fn contact_since(&mut self, i: usize, now: ContactStatistics, before: &mut ContactStatistics) {
        let (meter, time) = ContactMeter::since(now, before);
        self.track.add_contact(i, &meter, time);
    }
    /// Number of steps that the period took. Default: 1. Rounding errors of the motion are weighed with it.
    pub fn steps(&mut self, steps: u64) {
        self.steps = steps;
    }
    fn out_of_turn(&mut self, what: &str, i: usize, due: usize) {
        let (name, value) = (format!("{what} that the engine reports"), i as f64);
        let must = format!("be {due}, each one once in the order of their numbers");
        self.wrong.get_or_insert(ParameterError::Wrong { name, value, must });
    }
    /// Checks the report of an engine of one's own.
    fn finish(&self, state: &State) -> Result<(), PointError> {
        if let Some(wrong) = &self.wrong {
            return Err(PointError::Value(wrong.clone()));
        }
        if self.is_cancelled() {
            return Ok(());
        }
        check::length("coordinates of the state that the engine returns", state.q.len(), self.dof)
            .and_then(|()| {
                check::length("velocities of the state that the engine returns", state.v.len(), self.dof)
            })
            .map_err(PointError::Value)?;
        // A time of NaN is another one, too.
        let is_there = (state.t - self.end).abs() <= 1e-9 * self.length;
        if !is_there {
            let (name, value) = ("time at which the engine ends a period".into(), state.t);
            let must = format!("be {:?}", self.end);
            return Err(PointError::Value(ParameterError::Wrong { name, value, must }));
        }
        let due = if self.is_measured() { [self.track.channels(), self.contacts] } else { [0, 0] };
        let names = ["channels that the engine reports", "contacts that the engine reports"];
        for (name, (found, expected)) in names.into_iter().zip(self.reported.into_iter().zip(due)) {
            check::length(name, found, expected).map_err(PointError::Value)?;
        }
        Ok(())
    }
}

/// A run, period by period.
pub(crate) fn run(
    (plan, channels): (&Plan, &[Channel]),
    model: &dyn Periodic,
    start: &State,
    cancelled: &dyn Fn() -> bool,
    advance: &mut dyn FnMut(&mut State, &mut EnginePeriod<'_>) -> Result<(), PointError>,
) -> Result<RunOfPeriods, PointError> {
    let mut track = Track::new(plan, &start.q, &start.v);
    let mut state = start.clone();
    let length = model.period();
    let with_model: &WithModel<'_> = &|read| read(model);
    loop {
        let end = start.t + (track.periods + 1) as f64 * length;
        let contacts = plan.layout.contacts;
        let (reported, steps, wrong) = ([0; 2], 1, None);
        let mut period = EnginePeriod {
            track: &mut track,
            end,
            length,
            channels,
            cancelled,
            dof: model.dof(),
            contacts,
            reported,
            steps,
            wrong,
        };
        advance(&mut state, &mut period)?;
        let steps = period.steps;
        if cancelled() {
            return Ok(None);
        }
        state.check(model.dof()).map_err(|_| PointError::Diverged { period: track.periods + 1 })?;
        match track.period(steps, length, state.q.iter().chain(&state.v).copied(), with_model) {
            Next::Done => return Ok(Some(track.finish(with_model))),
            Next::Diverged => return Err(PointError::Diverged { period: track.periods }),
            _ => {}
        }
    }
}
