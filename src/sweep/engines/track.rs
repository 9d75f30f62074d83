//! One run of a sweep, period by period: settling, measuring and its row.

use crate::analysis::motion_size::MotionSize;
use crate::analysis::returns::Return;
use crate::contact::{Contact, Piece};
use crate::excitation::Side;
use crate::model::structure::drifts::Drifts;
use crate::model::{Periodic, State};
use crate::numeric::moments::Moments;
use crate::ode::probe::Probe;
use crate::ode::stepping::ends::LARGEST;
use crate::sweep::lanes::flanks::ContactMeter;
use crate::sweep::lanes::meter::ChannelMeter;
use crate::sweep::rows::layout::Layout;
use std::collections::VecDeque;

/// The settings of a sweep that every run needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    pub(crate) settle: usize,
    pub(crate) measure: usize,
    /// Tolerance `[1]` of the strobed state that ends settling early; `None`: no early end.
    pub(crate) repeat: Option<f64>,
    /// Tolerance `[1]` within which a motion must repeat to be periodic.
    pub(crate) tolerance: f64,
    pub(crate) layout: Layout,
}

/// Maximum period multiple that is recognised.
pub(crate) const LONGEST: usize = 16;

/// A run in progress.
pub(crate) struct Track {
    plan: Plan,
    /// Number of completed periods.
    pub(crate) periods: usize,
    /// Number of steps of the last period.
    steps: u64,
    /// Number of measured periods among them.
    measured: usize,
    measuring: bool,
    /// The last strobed states (coordinates, then velocities), one after the other, the newest last.
    section: Vec<f64>,
    /// States within the current period, or within the last one if the current one has none yet.
    samples: Vec<f64>,
    /// Whether `samples` are states of the current period.
    under_way: bool,
    /// The drifts of the model, computed at the first use.
    drifts: Option<Drifts>,
    row: Vec<f64>,
    /// Total weight of the measured periods: their duration or their number of samples.
    weight: f64,
    /// The moments of each channel over the measured periods.
    moments: Vec<Moments>,
    /// Minimum and maximum over the measured periods of the range (max - min) of each channel, then of the
    /// contact loss of each contact.
    spread: Vec<[f64; 2]>,
    /// For each contact over the measured periods: maximum penetration of the lower and of the upper flank,
    /// minimum of the larger of both.
    depths: Vec<[f64; 3]>,
    /// The extremes of the channels and the strobed state of each of the last measured periods.
    strobes: Vec<f64>,
    /// The period multiple whose repetition ended settling; 0 if none did.
    cycle: usize,
    /// The measured values of the current period.
    readings: Readings,
    /// Those of the last `cycle` periods, which count again for the periods that are not run.
    kept: VecDeque<Readings>,
}

/// The results of one period: each with its channel or contact and its weight.
#[derive(Clone, Default)]
struct Readings {
    channels: Vec<(usize, ChannelMeter<f64>, f64)>,
    contacts: Vec<(usize, ContactMeter, f64)>,
    state: Vec<f64>,
    weight: f64,
}

/// Calls a function with the model of the run.
pub(crate) type WithModel<'f> = dyn Fn(&mut dyn FnMut(&dyn Periodic)) + 'f;

/// The next task of a run after a period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Next {
    /// A settling period.
    Settle,
    /// The first measured period.
    StartMeasuring,
    /// A further measured period.
    Measure,
    /// None: the run is complete.
    Done,
    /// None: the state exceeds 1e100, or it or a sum of the row is infinite or NaN.
    Diverged,
}

impl Track {
    /// A run from a start state.
    pub(crate) fn new(plan: &Plan, q: &[f64], v: &[f64]) -> Self {
        let mut row = vec![0.0; plan.layout.stride()];
        for channel in 0..plan.layout.channels {
            let [_, _, min, max, _] = Layout::group_mut(&mut row, plan.layout.channel(channel));
            (*min, *max) = (f64::MAX, f64::MIN);
        }
        Track {
            plan: plan.clone(),
            periods: 0,
            steps: 1,
            measured: 0,
            measuring: plan.settle == 0,
            section: [q, v].concat(),
            samples: Vec::new(),
            under_way: false,
            drifts: None,
            row,
            weight: 0.0,
            moments: vec![Moments::NONE; plan.layout.channels],
            spread: vec![[f64::INFINITY, f64::NEG_INFINITY]; plan.layout.channels + plan.layout.contacts],
            depths: vec![[f64::NEG_INFINITY, f64::NEG_INFINITY, f64::INFINITY]; plan.layout.contacts],
            strobes: Vec::new(),
            cycle: 0,
            readings: Readings::default(),
            kept: VecDeque::new(),
        }
    }

    /// Number of measured channels.
    pub(crate) fn channels(&self) -> usize {
        self.plan.layout.channels
    }

    /// Whether the current period is measured.
    pub(crate) fn measuring(&self) -> bool {
        self.measuring
    }

    /// Whether the meters must run. They start one period before the first measured one, so that an impact at
    /// its start is counted.
    pub(crate) fn watching(&self) -> bool {
        self.measuring || self.plan.repeat.is_some() || self.periods + 1 >= self.plan.settle
    }

    /// Whether states within the current period must be sampled for the range of the motion: in the last
    /// measured period, and in all settling periods if settling may end early.
    pub(crate) fn ranging(&self) -> bool {
        if self.measuring { self.measured + 1 == self.runs() } else { self.plan.repeat.is_some() }
    }

    /// Number of measured periods that are run. After settling has ended by repetition after p periods they
    /// are p + 1, and the last p of them count again for the others: the first one may begin at an impact.
    fn runs(&self) -> usize {
        if self.cycle == 0 { self.plan.measure } else { self.plan.measure.min(self.cycle + 1) }
    }

    /// Adds a state within the current period: coordinates, then velocities.
    pub(crate) fn see_state(&mut self, state: impl Iterator<Item = f64>) {
        if !self.under_way {
            self.under_way = true;
            self.samples.clear();
        }
        self.samples.extend(state);
    }

    /// Adds the values of channel `i` in the current period. `weight`: duration of the period, or its number
    /// of samples.
    pub(crate) fn add_channel(&mut self, i: usize, meter: &ChannelMeter<f64>, weight: f64) {
        if self.cycle > 0 {
            self.readings.channels.push((i, *meter, weight));
        }
        self.moments[i].merge(&meter.moments(weight));
        let [sum, square, min, max, deviation] =
            Layout::group_mut(&mut self.row, self.plan.layout.channel(i));
        *deviation = self.moments[i].deviation();
        *sum += meter.sum;
        *square += meter.square;
        (*min, *max) = (min.min(meter.min), max.max(meter.max));
        self.strobes.extend([meter.min, meter.max]);
        self.see(i, meter.max - meter.min);
    }

    /// Updates the minimum and the maximum of entry `i` of `spread`.
    fn see(&mut self, i: usize, x: f64) {
        let [least, largest] = &mut self.spread[i];
        (*least, *largest) = (least.min(x), largest.max(x));
    }

    /// Adds the times and impacts of contact `i` in the current period. `weight`: duration of the period or
    /// its number of samples, as in `meter.samples`; the part on neither flank is the time in the gap.
    pub(crate) fn add_contact(&mut self, i: usize, meter: &ContactMeter, weight: f64) {
        if self.cycle > 0 {
            self.readings.contacts.push((i, *meter, weight));
        }
        let ([lower, upper], [on_lower, on_upper]) = (meter.samples, meter.impacts);
        let added = [lower, weight - lower - upper, upper, on_lower, on_upper];
        let sums = Layout::group_mut(&mut self.row, self.plan.layout.contact(i));
        sums.iter_mut().zip(added).for_each(|(sum, x)| *sum += x);
        self.see(self.plan.layout.channels + i, 1.0 - (lower + upper) / weight);
        let depth = &mut self.depths[i];
        *depth =
            [depth[0].max(meter.deepest[0]), depth[1].max(meter.deepest[1]), depth[2].min(meter.loosest)];
    }

    /// Ends a period of `steps` steps. `weight`: its duration or number of samples; `q`: coordinates and
    /// velocities at its end.
    pub(crate) fn period(
        &mut self,
        steps: u64,
        weight: f64,
        q: impl Iterator<Item = f64>,
        with_model: &WithModel<'_>,
    ) -> Next {
        let m = 2 * self.plan.layout.dof;
        self.periods += 1;
        self.steps = steps.max(1);
        self.under_way = false;
        self.section.extend(q);
        let kept = (2 * LONGEST + 1) * m;
        if self.section.len() > 2 * kept {
            self.section.drain(..self.section.len() - kept);
        }
        let state = &self.section[self.section.len() - m..];
        let is_small = |x: &f64| x.abs() <= LARGEST; // NaN is not
        if !(state.iter().all(is_small) && self.row.iter().all(|x| x.is_finite())) {
            return Next::Diverged;
        }
        if self.measuring {
            self.measured += 1;
            let state = state.to_vec();
            self.count(&state, weight);
            if self.cycle > 0 {
                self.kept.push_back(Readings { state, weight, ..std::mem::take(&mut self.readings) });
                if self.kept.len() > self.cycle {
                    self.kept.pop_front();
                }
            }
            if self.measured < self.runs() {
                return Next::Measure;
            }
            self.repeat_cycle();
            return Next::Done;
        }
        // A call of the family may cost as much as a period: rounding is weighed after 1, 2, 4, 8, ..
        // periods.
        let weighs = self.periods.is_power_of_two();
        self.cycle = self.plan.repeat.map_or(0, |at| {
            let found = self.multiple(at, weighs, with_model);
            if found.left <= at { found.multiple } else { 0 }
        });
        if self.periods >= self.plan.settle || self.cycle > 0 {
            self.measuring = true;
            return Next::StartMeasuring;
        }
        Next::Settle
    }

    /// Adds a measured period to the row: its strobed state and its weight.
    fn count(&mut self, state: &[f64], weight: f64) {
        self.weight += weight;
        self.strobes.extend(state);
        let (each, most) = (self.plan.layout.strobe_width(), self.plan.layout.strobes);
        if self.strobes.len() > each * most {
            self.strobes.drain(..each);
        }
    }

    /// Counts the periods of a cycle again, in turn, for the measured periods that are not run.
    fn repeat_cycle(&mut self) {
        self.cycle = 0;
        let kept = std::mem::take(&mut self.kept);
        let again = self.plan.measure - self.measured;
        for Readings { channels, contacts, state, weight } in kept.iter().cycle().take(again) {
            channels.iter().for_each(|(i, meter, weight)| self.add_channel(*i, meter, *weight));
            contacts.iter().for_each(|(i, meter, weight)| self.add_contact(*i, meter, *weight));
            self.count(state, *weight);
        }
    }

    /// As [`repeats`](Track::repeats). If the motion as a whole does not repeat, it is compared without
    /// drifts and, if `weighs` is set, above the rounding errors of its equations.
    fn multiple(&mut self, tolerance: f64, weighs: bool, with_model: &WithModel<'_>) -> Return {
        let n = self.plan.layout.dof;
        let mut whole = MotionSize::new(n, &Drifts::default());
        self.measure(&mut whole);
        let found = self.repeats(tolerance, &mut whole);
        if found.multiple > 0 {
            return found;
        }
        let is_whole = |drifts: &Drifts| n < 2 && drifts.count() == 0;
        if let (false, Some(drifts)) = (weighs, &self.drifts) {
            if is_whole(drifts) {
                return found;
            }
            let mut relative = MotionSize::new(n, drifts);
            self.measure(&mut relative);
            return self.repeats(tolerance, &mut relative);
        }
        let mut relative = None;
        with_model(&mut |model| {
            let drifts = self.drifts.get_or_insert_with(|| Drifts::of(model, model.period()));
            if is_whole(drifts) {
                return;
            }
            let (q, v) = self.section[self.section.len() - 2 * n..].split_at(n);
            let mut motion = MotionSize::new(n, drifts);
            let mut probe = Probe::new(model);
            let step = model.period() / self.steps as f64;
            for (q, v) in self.states().map(|state| state.split_at(n)).chain([(q, v)]) {
                let contacts = probe.read_contacts(0.0, Side::After, q, v);
                let pieces: Vec<Piece> = contacts.iter().map(Contact::piece).collect();
                motion.keep(&pieces, step, 0.0, q, v);
            }
            motion.weigh_kept(model, &State::new(0.0, q, v));
            relative = Some(motion);
        });
        let Some(mut relative) = relative else { return found };
        self.measure(&mut relative);
        self.repeats(tolerance, &mut relative)
    }

    /// The known states of the last period.
    fn states(&self) -> impl Iterator<Item = &[f64]> {
        let width = 2 * self.plan.layout.dof;
        self.section.rchunks_exact(width).take(2).chain(self.samples.chunks_exact(width))
    }

    /// Adds the states of the last period.
    fn measure(&self, motion: &mut MotionSize) {
        let n = self.plan.layout.dof;
        self.states().for_each(|state| motion.see(0.0, &state[..n], &state[n..]));
    }

    /// The last [`Return`] of the strobed states. Distances are the maximum over the coordinates and
    /// velocities, each as a share of its range over the last period.
    fn repeats(&self, tolerance: f64, motion: &mut MotionSize) -> Return {
        let n = self.plan.layout.dof;
        let states: Vec<&[f64]> = self.section.rchunks_exact(2 * n).take(2 * LONGEST + 1).collect();
        motion.steps = self.steps as usize;
        let found = Return::of(&states, LONGEST, tolerance, |a, b| motion.distance(a, b, tolerance));
        match found.multiple {
            0 => found,
            p => Return { change: motion.change(states[0], states[p]), ..found },
        }
    }

    /// Maximum difference between the measured periods: (max - min)/max of the range of a channel, max - min
    /// of a contact loss. Infinite with fewer than two measured periods, or without channels and contacts.
    fn scatter(&self) -> f64 {
        let channels = self.plan.layout.channels;
        let apart = |(i, [least, largest]): (usize, &[f64; 2])| match largest - least {
            apart if i < channels && apart > 0.0 => apart / largest,
            apart => apart,
        };
        let scatter = self.spread.iter().enumerate().map(apart).reduce(f64::max);
        scatter.filter(|_| self.measured > 1).unwrap_or(f64::INFINITY)
    }

    /// Returns the row and the last state (coordinates, then velocities).
    pub(crate) fn finish(mut self, with_model: &WithModel<'_>) -> (Vec<f64>, Vec<f64>) {
        let Return { multiple, change, .. } = self.multiple(self.plan.tolerance, true, with_model);
        let layout = &self.plan.layout;
        let margin = self.depths.iter().map(margin).fold(f64::INFINITY, f64::min);
        let settled = (self.periods - self.measured) as f64;
        *Layout::group_mut(&mut self.row, Layout::HEAD) =
            [multiple as f64, change, settled, margin, self.scatter()];
        for channel in 0..layout.channels {
            let [mean, rms, ..] = Layout::group_mut(&mut self.row, layout.channel(channel));
            *mean /= self.weight;
            *rms = (*rms / self.weight).max(0.0).sqrt();
        }
        for contact in 0..layout.contacts {
            let [times @ .., _, _] = Layout::group_mut(&mut self.row, layout.contact(contact));
            times.iter_mut().for_each(|time| *time /= self.weight);
        }
        let at = layout.strobe(0);
        self.row[at..at + self.strobes.len()].copy_from_slice(&self.strobes);
        let state = self.section[self.section.len() - 2 * layout.dof..].to_vec();
        (self.row, state)
    }
}

/// Margin to grazing: the minimum |penetration| over three extreme penetrations (see `depths` in [`Track`]),
/// as a share of the range of the penetration `[1]`. Infinite without penetrations, as with the engines
/// `Located` and `LaneTaylor`.
fn margin(&[lower, upper, loosest]: &[f64; 3]) -> f64 {
    let range = lower.max(upper) - loosest;
    if !(range.is_finite() && range > 0.0) {
        return f64::INFINITY;
    }
    [lower, upper, loosest].iter().fold(f64::INFINITY, |m: f64, x| m.min(x.abs())) / range
}
