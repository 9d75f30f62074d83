//! Long runs of many members under white noise, reduced to estimates.

use crate::contact::Contact;
use crate::error::{ParameterError, check};
use crate::model::{Machine, Shape, State};
use crate::ode::probe::{ChannelKind, Probe};
use crate::random::white::crossings::Crossings;
use crate::random::white::error::NoiseError;
use crate::random::white::estimate::Estimate;
use crate::random::white::noisy_lanes::{Gauge, Look};
use crate::random::white::solver::{NoisySteps, Ready};
use crate::random::white::statistics::{MemberFigures, NoiseStatistics};
use crate::sweep::engines::sweep_engine::kinds;
use crate::sweep::lanes::meter::{MeterReading, Meters};
use crate::sweep::lanes::number::Lanes;
use crate::sweep::watch::Watch;
use std::ops::Range;

/// Long runs under white noise: means, mean squares and largest values of channels, shares of time on the
/// flanks, rates and speeds of impacts, flights, all with their errors.
///
/// Each member settles, then it is measured for a number of spans of equal length. The spans of all members
/// are the batches of the estimates ([`Estimate`]). Default: 64 members, 1 span for each, no channels.
///
/// The averages over a span are those of a stationary motion. Under drives with a period they are averages
/// over the period, too, if a span has whole periods.
///
/// ```
/// use gear_dynamics::random::{LongRun, NoisySteps, WhiteNoise};
/// use gear_dynamics::{models::Oscillator, State};
/// // A dead zone of half backlash 0.5: P(gap) = 1/Z, Z = 1 + √(2π/β) with β = 2 c/D = 2.
/// let pair = Oscillator::new(&[("speed", 1.0), ("mesh stiffness", 1.0), ("half backlash", 0.5)])?;
/// let solver = NoisySteps::new(30, &[WhiteNoise::bath(0, 0.5, 0.5)?]);
/// // Settle for 10 periods, measure 200.
/// let long = LongRun::new(10.0, 200.0)?.members(32);
/// let seen = long.channels(&["v0"]).run(&solver, &pair, &State::at_rest(1))?;
/// let z = 1.0 + std::f64::consts::PI.sqrt();
/// let [low, high] = seen.contact(0)?.gap.confidence(0.999)?;
/// assert!(low < 1.0 / z && 1.0 / z < high && high - low < 0.02);
/// assert!((seen.mean_square("v0")?.mean() - 0.5).abs() < 0.02); // 1/β
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "a setting returns a new value"]
pub struct LongRun<'w> {
    settle: f64,
    measure: f64,
    members: usize,
    spans: usize,
    channels: Vec<String>,
    watch: Watch<'w>,
}

/// Maximum number of steps in a span: what the counters of the meters hold.
const MAX_SPAN: u64 = 1 << 26;

/// Maximum number of members. Each has distributions of some ten kilobytes for each contact.
const MAX_MEMBERS: usize = 1 << 16;

impl<'w> LongRun<'w> {
    /// Members that settle for `settle` periods of the model and are then measured for `measure` periods.
    ///
    /// # Errors
    /// A negative time to settle; a time to measure that is not positive; times above 1e50.
    pub fn new(settle: f64, measure: f64) -> Result<Self, ParameterError> {
        Ok(LongRun {
            settle: check::not_negative("periods to settle", settle)?,
            measure: check::positive("periods to measure", measure)?,
            members: 64,
            spans: 1,
            channels: Vec::new(),
            watch: Watch::default(),
        })
    }
    /// Number of members. Default: 64. A multiple of the lanes uses them best.
    pub fn members(self, members: usize) -> Self {
        LongRun { members, ..self }
    }
    /// Number of spans into which the measured time of a member is divided. Default: 1. Members × spans must
    /// be at least 8.
    pub fn spans(self, spans: usize) -> Self {
        LongRun { spans, ..self }
    }
    /// The channels to measure: coordinates, velocities, deflections and mesh forces, as in a
    /// [`Sweep`](crate::Sweep) in lanes. They are sampled at the end of every step, and
    /// on both sides of a jump of the drives.
    pub fn channels(self, names: &[&str]) -> Self {
        LongRun { channels: names.iter().map(|name| (*name).to_owned()).collect(), ..self }
    }
    /// Progress by groups of members, and a flag, checked every 4096 steps. If cancelled, the result contains
    /// the members that were complete.
    pub fn watch(self, watch: Watch<'w>) -> Self {
        LongRun { watch, ..self }
    }

    /// Runs all members from one start at time 0. `None`: from the
    /// [static state](crate::linear::static_state).
    ///
    /// # Errors
    /// [`NoiseError`]. [`NoiseError::Exhausted`] if cancelled before 8 spans were complete.
    pub fn run<'s, G: Shape, const W: usize>(
        &self,
        solver: &NoisySteps<W>,
        machine: &Machine<G>,
        start: impl Into<Option<&'s State>>,
    ) -> Result<NoiseStatistics, NoiseError> {
        check::at_least("members", self.members, 1)?;
        check::at_least("spans of a member", self.spans, 1)?;
        check::count("members", &[self.members], MAX_MEMBERS)?;
        check::at_least("members × spans", self.members.saturating_mul(self.spans), Estimate::BATCHES)?;
        let probe = Probe::new(machine);
        let chosen = probe.indices(&self.channels)?;
        let kinds = kinds(machine, &chosen)?;
        let contacts = machine.size().contacts - machine.size().kinks;
        let figures = 2 * kinds.len() + MemberFigures::OF_CONTACT * contacts;
        check::count(
            "members × spans × figures",
            &[self.members, self.spans, figures.max(1)],
            check::NUMBERS,
        )?;
        let ready = solver.ready(machine, start.into())?;
        let settle = if self.settle > 0.0 { ready.steps_in(self.settle)? } else { 0 };
        let span = ready.steps_in(self.measure / self.spans as f64)?;
        check::count("steps in a span", &[usize::try_from(span).unwrap_or(usize::MAX)], MAX_SPAN as usize)?;
        let group = |members: Range<usize>| {
            let group = (members.start / W) as u64;
            self.group(&GroupWork { ready: &ready, group, settle, span, kinds: &kinds, contacts })
        };
        let groups = self.watch.begin(0, self.members).blocks(0..self.members, W, group)?;
        let mut statistics = NoiseStatistics::new(&self.channels, contacts, span as f64 * ready.h);
        groups.into_iter().flatten().for_each(|member| statistics.add(member));
        if statistics.batches() < Estimate::BATCHES {
            return Err(NoiseError::cancelled(statistics.members(), self.members));
        }
        Ok(statistics)
    }

    /// The figures of the members of one group; `None` if cancelled.
    fn group<G: Shape, const W: usize>(
        &self,
        work: &GroupWork<'_, '_, G, W>,
    ) -> Result<Option<Vec<MemberFigures>>, NoiseError> {
        let GroupWork { ready, group, .. } = *work;
        let (members, go_on) = (self.members as u64, || !self.watch.is_cancelled());
        let mut lanes = ready.lanes(group);
        let mut gauge = LongGauge::<W>::new(work.kinds, work.contacts);
        if !ready.advance(&mut lanes, group, work.settle, &mut gauge, members, &go_on)? {
            return Ok(None);
        }
        gauge.meters.finish();
        (0..W).for_each(|lane| gauge.meters.clear(lane));
        gauge.crossings.iter_mut().for_each(Crossings::clear);
        let here = W.min((members - group * W as u64) as usize);
        let mut figures: Vec<MemberFigures> =
            (0..here).map(|_| MemberFigures::new(work.kinds.len(), work.contacts)).collect();
        for _ in 0..self.spans {
            if !ready.advance(&mut lanes, group, work.span, &mut gauge, members, &go_on)? {
                return Ok(None);
            }
            gauge.meters.finish();
            let steps = work.span as f64;
            for (lane, figures) in figures.iter_mut().enumerate() {
                gauge.meters.read(lane, |reading| match reading {
                    MeterReading::Channel(i, meter) => figures.channel(i, &meter, steps),
                    MeterReading::Contact(i, meter) => {
                        figures.contact(&meter, gauge.crossings[i].lane(lane), steps, steps * ready.h);
                    }
                });
            }
            if let Some(lane) = figures.iter().position(|figures| !figures.has_squares()) {
                let t = lanes.number[lane] as f64 * ready.h;
                return Err(NoiseError::Diverged { member: group * W as u64 + lane as u64, t });
            }
        }
        for (lane, figures) in figures.iter_mut().enumerate() {
            for (i, crossings) in gauge.crossings.iter_mut().enumerate() {
                figures.finish(i, crossings.lane(lane));
            }
        }
        Ok(Some(figures))
    }
}

/// What a group of members needs.
struct GroupWork<'a, 'm, G, const W: usize> {
    ready: &'a Ready<'m, G, W>,
    group: u64,
    /// Steps to settle, and in a span.
    settle: u64,
    span: u64,
    kinds: &'a [ChannelKind],
    contacts: usize,
}

/// Meters and crossings of all lanes.
struct LongGauge<const W: usize> {
    meters: Meters<Lanes<W>>,
    crossings: Vec<Crossings<W>>,
    contacts: Vec<Contact<Lanes<W>>>,
    /// The drives behind a jump.
    after: Vec<Lanes<W>>,
}

impl<const W: usize> LongGauge<W> {
    fn new(kinds: &[ChannelKind], contacts: usize) -> Self {
        let mut meters = Meters::new(kinds, contacts);
        (0..W).for_each(|lane| meters.restart(lane));
        LongGauge {
            meters,
            crossings: (0..contacts).map(Crossings::new).collect(),
            contacts: vec![Contact::default(); contacts],
            after: Vec::new(),
        }
    }
}

impl<G: Shape, const W: usize> Gauge<G, W> for LongGauge<W> {
    #[inline(always)]
    fn look(&mut self, step: &Look<'_, G, W>) -> bool {
        for (i, crossings) in self.crossings.iter_mut().enumerate() {
            self.contacts[i] = step.contact(i);
            crossings.look(step, &self.contacts[i]);
        }
        let jumps = step.jumps(&mut self.after);
        if jumps {
            self.meters.halve_next();
        }
        self.meters.sample(step.q, step.v, &self.contacts);
        if jumps {
            for (i, contact) in self.contacts.iter_mut().enumerate() {
                *contact = step.contact_under(i, &self.after);
            }
            self.meters.halve_next();
            self.meters.sample(step.q, step.v, &self.contacts);
        }
        true
    }
}
