//! First passages: when an event happens for the first time.

use crate::error::{ParameterError, check};
use crate::model::{Machine, Shape, State};
use crate::random::rare::particles::{End, Limits, Particle, follow};
use crate::random::rare::score::Event;
use crate::random::white::error::NoiseError;
use crate::random::white::solver::NoisySteps;
use crate::sweep::Distribution;
use crate::sweep::watch::Watch;
use std::ops::Range;

/// First passage: the time at which an [`Event`] happens for the first time, for many members from one start.
///
/// ```
/// use gear_dynamics::random::{Event, FirstPassage, NoisySteps, WhiteNoise};
/// use gear_dynamics::{models::Oscillator, State};
/// // q' = q'(0) + t under a mean force 1, with little noise: q reaches 2 near t = 2.
/// let pushed = Oscillator::new(&[("speed", 1.0), ("mean force", 1.0)])?;
/// let solver = NoisySteps::new(200, &[WhiteNoise::bath(0, 0.0, 1e-4)?]);
/// let event = Event::new(2.0, |at| at.q[0]);
/// let seen = FirstPassage::new(1.0)?.members(200).run(&solver, &pushed, &State::at_rest(1), &event)?;
/// assert!((seen.times().mean() - 2.0).abs() < 0.01 && seen.reached() == 200);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "a setting returns a new value"]
pub struct FirstPassage<'w> {
    periods: f64,
    members: usize,
    watch: Watch<'w>,
}

/// Times of first passage, made by [`FirstPassage`].
///
/// ```
/// use gear_dynamics::random::{Event, FirstPassage, NoisySteps, WhiteNoise};
/// use gear_dynamics::{models::Oscillator, State};
/// let free = Oscillator::new(&[("speed", 1.0), ("linear stiffness", 1.0)])?;
/// let solver = NoisySteps::new(30, &[WhiteNoise::bath(0, 0.1, 0.01)?]);
/// let event = Event::new(9.0, |at| at.q[0]); // 40 standard deviations
/// let seen = FirstPassage::new(2.0)?.members(64).run(&solver, &free, &State::at_rest(1), &event)?;
/// assert_eq!((seen.reached(), seen.members()), (0, 64));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PassageTimes {
    times: Distribution,
    members: u64,
}

/// Particles of one block: several fillings of the lanes.
const BLOCK: usize = 256;

impl<'w> FirstPassage<'w> {
    /// First passages within a time of `periods` periods of the model. Default: 1024 members.
    ///
    /// # Errors
    /// A time that is not positive.
    pub fn new(periods: f64) -> Result<Self, ParameterError> {
        let periods = check::positive("periods of the first passage", periods)?;
        Ok(FirstPassage { periods, members: 1024, watch: Watch::default() })
    }
    /// Number of members. Default: 1024.
    pub fn members(self, members: usize) -> Self {
        FirstPassage { members, ..self }
    }
    /// Progress by blocks of 256 members, and a flag. If cancelled, the result contains the blocks that were
    /// complete.
    pub fn watch(self, watch: Watch<'w>) -> Self {
        FirstPassage { watch, ..self }
    }

    /// Runs all members from one start at time 0. `None`: from the
    /// [static state](crate::linear::static_state).
    ///
    /// # Errors
    /// [`NoiseError`].
    pub fn run<'s, G: Shape, const W: usize>(
        &self,
        solver: &NoisySteps<W>,
        machine: &Machine<G>,
        start: impl Into<Option<&'s State>>,
        event: &Event,
    ) -> Result<PassageTimes, NoiseError> {
        check::at_least("members", self.members, 1)?;
        check::count("members", &[self.members], check::NUMBERS)?;
        check::finite("level of the event", event.level())?;
        let ready = solver.ready(machine, start.into())?;
        let last = ready.steps_in(self.periods)?;
        let limits = Limits { level: event.level(), floor: f64::NEG_INFINITY, last };
        let block = |members: Range<usize>| {
            let particle = |member: usize| Particle {
                member: member as u64,
                number: 0,
                score: f64::NEG_INFINITY,
                q: ready.start.q.clone(),
                v: ready.start.v.clone(),
            };
            let particles: Vec<Particle> = members.map(particle).collect();
            follow(&ready, event, limits, &particles, &|| !self.watch.is_cancelled())
        };
        let ends = self.watch.begin(0, self.members).blocks(0..self.members, BLOCK, block)?;
        let mut seen = PassageTimes { times: Distribution::new(), members: 0 };
        for end in ends.into_iter().flatten() {
            seen.members += 1;
            if end.reached {
                seen.times.add(instant(&end, event.level()) * ready.h);
            }
        }
        if seen.members == 0 {
            return Err(NoiseError::cancelled(0, self.members));
        }
        Ok(seen)
    }
}

/// The instant at which the score reaches the level, in steps: linear between the last two scores.
fn instant(end: &End, level: f64) -> f64 {
    let share = (level - end.before) / (end.at.score - end.before);
    (end.at.number - 1) as f64 + if (0.0..=1.0).contains(&share) { share } else { 1.0 }
}

impl PassageTimes {
    /// The times of the members that reached the event. Their [mean](Distribution::mean) has the [standard
    /// error](Distribution::standard_error) of independent members; it is that of all members only if all
    /// reached it.
    pub fn times(&self) -> &Distribution {
        &self.times
    }
    /// Number of members that reached the event within the time.
    pub fn reached(&self) -> u64 {
        self.times.count()
    }
    /// Number of members that were followed.
    pub fn members(&self) -> u64 {
        self.members
    }
}
