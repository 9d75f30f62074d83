//! The results of long runs under white noise.

use crate::error::{ParameterError, check};
use crate::random::white::crossings::LaneCrossings;
use crate::random::white::estimate::Estimate;
use crate::sweep::Distribution;
use crate::sweep::lanes::flanks::ContactMeter;
use crate::sweep::lanes::meter::ChannelMeter;

/// The figures of one member: a row for each span, extremes and distributions over the whole run.
///
/// A row has the mean and the mean square of each channel, then for each contact the shares of the flanks,
/// the rates of impacts, and over time the sums of the impact speeds, of the flights, and the number of
/// flights.
pub(crate) struct MemberFigures {
    rows: Vec<f64>,
    /// Minimum and maximum of each channel.
    extremes: Vec<[f64; 2]>,
    events: Vec<Events>,
}

/// Impacts and flights of one contact.
#[derive(Clone, Debug, PartialEq)]
struct Events {
    speeds: [Distribution; 2],
    flights: Distribution,
}

impl Events {
    fn none() -> Self {
        Events { speeds: [Distribution::new(), Distribution::new()], flights: Distribution::new() }
    }
}

impl MemberFigures {
    /// Figures of a contact in a row.
    pub(crate) const OF_CONTACT: usize = 8;

    pub(crate) fn new(channels: usize, contacts: usize) -> Self {
        let extremes = vec![[f64::INFINITY, f64::NEG_INFINITY]; channels];
        MemberFigures { rows: Vec::new(), extremes, events: vec![Events::none(); contacts] }
    }
    /// Adds a channel of a span to the row.
    pub(crate) fn channel(&mut self, i: usize, meter: &ChannelMeter<f64>, steps: f64) {
        self.rows.extend([meter.sum / steps, meter.square / steps]);
        let [low, high] = &mut self.extremes[i];
        (*low, *high) = (low.min(meter.min), high.max(meter.max));
    }
    /// Adds a contact of a span to the row, and starts its next span.
    pub(crate) fn contact(&mut self, meter: &ContactMeter, seen: &mut LaneCrossings, steps: f64, time: f64) {
        let [lower, upper] = meter.samples;
        self.rows.extend([lower / steps, upper / steps]);
        self.rows.extend(meter.impacts.iter().chain(&seen.batch).map(|sum| sum / time));
        seen.batch = [0.0; 4];
    }
    /// Whether squares of the figures are finite, as the errors of the estimates need.
    pub(crate) fn has_squares(&self) -> bool {
        self.rows.iter().all(|x| x.abs() < 1e140)
    }
    /// Takes the distributions of contact `i`.
    pub(crate) fn finish(&mut self, i: usize, seen: &mut LaneCrossings) {
        self.events[i] = Events {
            speeds: seen.speeds.each_mut().map(std::mem::take),
            flights: std::mem::take(&mut seen.flights),
        };
    }
}

/// Estimates from long runs under white noise, made by [`LongRun`](crate::random::LongRun).
///
/// ```
/// use gear_dynamics::random::{LongRun, NoisySteps, WhiteNoise};
/// use gear_dynamics::{models::Oscillator, State};
/// let free = Oscillator::new(&[("speed", 1.0), ("linear stiffness", 4.0), ("mean force", 2.0)])?;
/// let solver = NoisySteps::new(60, &[WhiteNoise::bath(0, 0.5, 0.5)?]);
/// let seen = LongRun::new(10.0, 100.0)?.channels(&["q0"]).run(&solver, &free, None)?;
/// let mean = seen.mean("q0")?; // 2/4, mean square 0.25 + D/(2 c k) = 0.375
/// assert!((mean.mean() - 0.5).abs() < 4.0 * mean.standard_error() && mean.standard_error() < 0.01);
/// assert!((seen.mean_square("q0")?.mean() - 0.375).abs() < 0.02);
/// assert_eq!((seen.members(), seen.batches()), (64, 64));
/// assert!(seen.largest("q0")?.min() > 1.0); // the smallest of the 64 maxima
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseStatistics {
    channels: Vec<String>,
    contacts: usize,
    span: f64,
    members: usize,
    rows: Vec<f64>,
    least: Vec<Distribution>,
    largest: Vec<Distribution>,
    events: Vec<Events>,
}

/// Estimates of one contact.
///
/// ```
/// use gear_dynamics::random::{LongRun, NoisySteps, WhiteNoise};
/// use gear_dynamics::{models::Oscillator, State};
/// let pair = Oscillator::new(&[("speed", 1.0), ("mesh stiffness", 1.0), ("half backlash", 0.5)])?;
/// let solver = NoisySteps::new(40, &[WhiteNoise::bath(0, 0.5, 0.5)?]);
/// let long = LongRun::new(10.0, 100.0)?;
/// let contact = long.run(&solver, &pair, &State::at_rest(1))?.contact(0)?;
/// let shares = contact.flanks[0].mean() + contact.gap.mean() + contact.flanks[1].mean();
/// assert!((shares - 1.0).abs() < 1e-12);
/// // Impact speeds have a Rayleigh distribution of mean √(π/(2 β)), β = 2.
/// let speed = contact.speed[1].mean();
/// assert!((speed - 0.886).abs() < 0.03, "{speed}");
/// // The mean flight is the time in the gap over the number of impacts.
/// let impacts = contact.impacts[0].mean() + contact.impacts[1].mean();
/// assert!((contact.flight.mean() * impacts / contact.gap.mean() - 1.0).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactEstimates {
    /// Share of time in the gap `[1]`.
    pub gap: Estimate,
    /// Share of time on the lower and the upper flank `[1]`.
    pub flanks: [Estimate; 2],
    /// Impacts on the lower and the upper flank over time: the rate at which the edge is crossed from the
    /// gap. It is the rate of the separations from the flank, too. Two crossings within one step of length h
    /// are not seen: with the acceleration a at the edge and the mean square ⟨v²⟩ of the rate there, the rate
    /// is too small by the share (a h)²/(24 ⟨v²⟩), to second order in h.
    pub impacts: [Estimate; 2],
    /// Mean speed of approach at the impacts on each flank. NaN without impacts.
    pub speed: [Estimate; 2],
    /// Mean flight: the time from a separation to the next impact. NaN without flights.
    pub flight: Estimate,
    /// Speeds of approach on each flank, one value for each impact.
    pub speeds: [Distribution; 2],
    /// Distribution of the flights. Flights shorter than a step are too few: noise makes very short ones.
    pub flights: Distribution,
}

impl NoiseStatistics {
    pub(crate) fn new(channels: &[String], contacts: usize, span: f64) -> Self {
        NoiseStatistics {
            channels: channels.to_vec(),
            contacts,
            span,
            members: 0,
            rows: Vec::new(),
            least: vec![Distribution::new(); channels.len()],
            largest: vec![Distribution::new(); channels.len()],
            events: vec![Events::none(); contacts],
        }
    }

    pub(crate) fn add(&mut self, member: MemberFigures) {
        self.rows.extend(member.rows);
        for (i, [least, largest]) in member.extremes.into_iter().enumerate() {
            self.least[i].add(least);
            self.largest[i].add(largest);
        }
        for (all, one) in self.events.iter_mut().zip(&member.events) {
            all.speeds.iter_mut().zip(&one.speeds).for_each(|(all, one)| all.merge(one));
            all.flights.merge(&one.flights);
        }
        self.members += 1;
    }

    fn width(&self) -> usize {
        2 * self.channels.len() + MemberFigures::OF_CONTACT * self.contacts
    }

    fn column(&self, i: usize) -> impl Iterator<Item = f64> + Clone + '_ {
        self.rows.iter().skip(i).step_by(self.width()).copied()
    }

    fn estimate(&self, i: usize) -> Estimate {
        Estimate::ratio(self.column(i).map(|x| [x, 1.0]))
    }

    /// Number of members that were complete.
    pub fn members(&self) -> usize {
        self.members
    }
    /// Number of batches: members × spans.
    pub fn batches(&self) -> usize {
        self.rows.len().checked_div(self.width()).unwrap_or(0)
    }
    /// Length of a span, in the time unit of the model.
    pub fn span(&self) -> f64 {
        self.span
    }

    /// Mean of a channel.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchChannel`] for a channel that was not requested.
    pub fn mean(&self, channel: &str) -> Result<Estimate, ParameterError> {
        Ok(self.estimate(2 * check::channel_index(&self.channels, channel)?))
    }
    /// Mean of the square of a channel.
    ///
    /// # Errors
    /// As [`mean`](NoiseStatistics::mean).
    pub fn mean_square(&self, channel: &str) -> Result<Estimate, ParameterError> {
        Ok(self.estimate(2 * check::channel_index(&self.channels, channel)? + 1))
    }
    /// The maximum of a channel in the measured time of a member, as a distribution over the members.
    ///
    /// # Errors
    /// As [`mean`](NoiseStatistics::mean).
    pub fn largest(&self, channel: &str) -> Result<&Distribution, ParameterError> {
        Ok(&self.largest[check::channel_index(&self.channels, channel)?])
    }
    /// The minimum of a channel in the measured time of a member, as a distribution over the members.
    ///
    /// # Errors
    /// As [`mean`](NoiseStatistics::mean).
    pub fn least(&self, channel: &str) -> Result<&Distribution, ParameterError> {
        Ok(&self.least[check::channel_index(&self.channels, channel)?])
    }

    /// Estimates of contact `i`.
    ///
    /// # Errors
    /// [`ParameterError::NoSuchContact`].
    pub fn contact(&self, i: usize) -> Result<ContactEstimates, ParameterError> {
        let events = self.events.get(i);
        let events =
            events.ok_or(ParameterError::NoSuchContact { contact: i, contacts: self.contacts })?.clone();
        let first = 2 * self.channels.len() + MemberFigures::OF_CONTACT * i;
        let of = |figure: usize| self.column(first + figure);
        let over = |x: usize, y: usize| Estimate::ratio(of(x).zip(of(y)).map(|(x, y)| [x, y]));
        let gap = Estimate::ratio(of(0).zip(of(1)).map(|(lower, upper)| [1.0 - lower - upper, 1.0]));
        let each = [0, 1];
        Ok(ContactEstimates {
            gap,
            flanks: each.map(|flank| self.estimate(first + flank)),
            impacts: each.map(|flank| self.estimate(first + 2 + flank)),
            speed: each.map(|flank| over(4 + flank, 2 + flank)),
            flight: over(6, 7),
            speeds: events.speeds,
            flights: events.flights,
        })
    }
}
