//! Multilevel splitting: the probability of a rare event.

use crate::error::{ParameterError, check};
use crate::model::{Machine, Shape, State};
use crate::numeric::split_mix::CounterRng;
use crate::random::rare::particles::{Limits, Particle, follow};
use crate::random::rare::score::Event;
use crate::random::white::error::NoiseError;
use crate::random::white::estimate::Estimate;
use crate::random::white::solver::{NoisySteps, Ready};
use crate::sweep::watch::Watch;
use rand::Rng;
use std::ops::Range;

/// The probability of a rare event by multilevel splitting: that a score reaches a level before a time has
/// passed and before it falls to a floor.
///
/// Between start and level stand further levels. In stage k all particles start from states in which others
/// entered level k; a share p_k of them enters level k + 1 before the time or the floor ends them. The
/// probability is the product of all p_k. A pilot run chooses the levels so that each p_k is near 0.2. Then
/// the levels are fixed, and the whole is repeated with other random numbers: the estimate is the mean of the
/// repeats, without bias for any number of particles, and its error follows from their scatter.
///
/// Default: 1000 particles, 16 repeats, no floor.
///
/// The better the score predicts the event, the smaller the error; the mean is right for any score. For a
/// vibration the amplitude predicts, a coordinate alone does not: it returns in each cycle.   Source:
/// Garvels, The splitting method in rare event simulation, Twente 2000 (fixed effort).
///
/// ```
/// use gear_dynamics::random::{Event, NoisySteps, Splitting, WhiteNoise};
/// use gear_dynamics::{models::Oscillator, State};
/// // The particle v' = -v + √2 ξ reaches 3 before -3 from v = 0 with the probability 1/2.
/// let free = Oscillator::new(&[("speed", 1.0)])?;
/// let solver = NoisySteps::new(200, &[WhiteNoise::bath(0, 1.0, 2.0)?]);
/// let event = Event::new(3.0, |at| at.v[0]);
/// let splitting = Splitting::new(1e4)?.floor(-3.0).particles(100);
/// let seen = splitting.run(&solver, &free, &State::at_rest(1), &event)?;
/// let [low, high] = seen.probability().confidence(0.999)?;
/// assert!(low < 0.5 && 0.5 < high && high - low < 0.4, "{low} {high}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[must_use = "a setting returns a new value"]
pub struct Splitting<'w> {
    periods: f64,
    floor: f64,
    particles: usize,
    repeats: usize,
    watch: Watch<'w>,
}

/// The probability of a rare event, made by [`Splitting`].
///
/// ```
/// use gear_dynamics::random::{Event, NoisySteps, Splitting, WhiteNoise};
/// use gear_dynamics::{models::Oscillator, State};
/// let free = Oscillator::new(&[("speed", 1.0), ("linear stiffness", 1.0)])?;
/// let solver = NoisySteps::new(40, &[WhiteNoise::bath(0, 0.2, 0.4)?]); // mean square 1
/// let event = Event::new(5.0, |at| at.q[0].hypot(at.v[0])); // the amplitude reaches 5
/// let seen = Splitting::new(5.0)?.particles(200).run(&solver, &free, &State::at_rest(1), &event)?;
/// assert_eq!(*seen.levels().last().unwrap(), 5.0);
/// assert!(seen.probability().mean() < 1e-3 && seen.probability().relative_error() < 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct RareEvent {
    probability: Estimate,
    levels: Vec<f64>,
    shares: Vec<f64>,
    steps: u64,
}

/// Share of the particles that shall enter the next level.
const SHARE: f64 = 0.2;

/// Maximum number of stages: 0.2²⁵⁵ is 10⁻¹⁷⁸.
const STAGES: usize = 255;

/// Maximum numbers of particles and of repeats: what the number of a member holds beside the stage.
const MAX_PARTICLES: usize = 1 << 26;
const MAX_REPEATS: usize = 1 << 24;

impl<'w> Splitting<'w> {
    /// Splitting within a time of `periods` periods of the model.
    ///
    /// # Errors
    /// A time that is not positive.
    pub fn new(periods: f64) -> Result<Self, ParameterError> {
        let periods = check::positive("periods of the event", periods)?;
        Ok(Splitting {
            periods,
            floor: f64::NEG_INFINITY,
            particles: 1000,
            repeats: 16,
            watch: Watch::default(),
        })
    }
    /// Score at which a particle ends without the event. Default: none.
    pub fn floor(self, floor: f64) -> Self {
        Splitting { floor, ..self }
    }
    /// Particles in each stage. Default: 1000.
    pub fn particles(self, particles: usize) -> Self {
        Splitting { particles, ..self }
    }
    /// Number of repeats, at least 8. Default: 16.
    pub fn repeats(self, repeats: usize) -> Self {
        Splitting { repeats, ..self }
    }
    /// Progress by repeats, and a flag. If cancelled, the result contains the repeats that were complete.
    pub fn watch(self, watch: Watch<'w>) -> Self {
        Splitting { watch, ..self }
    }

    /// Runs pilot and repeats from one start at time 0. `None`: from the
    /// [static state](crate::linear::static_state).
    ///
    /// # Errors
    /// [`NoiseError`]. [`NoiseError::Extinct`] if the pilot does not find the way to the event;
    /// [`NoiseError::Exhausted`] if cancelled before 8 repeats.
    pub fn run<'s, G: Shape, const W: usize>(
        &self,
        solver: &NoisySteps<W>,
        machine: &Machine<G>,
        start: impl Into<Option<&'s State>>,
        event: &Event,
    ) -> Result<RareEvent, NoiseError> {
        check::at_least("particles", self.particles, 20)?;
        check::count("particles", &[self.particles], MAX_PARTICLES)?;
        check::count("particles × coordinates", &[self.particles, machine.size().dof], check::NUMBERS)?;
        check::at_least("repeats", self.repeats, Estimate::BATCHES)?;
        check::count("repeats", &[self.repeats], MAX_REPEATS)?;
        check::finite("level of the event", event.level())?;
        if self.floor.is_nan() || self.floor >= event.level() {
            let (name, value) = ("floor of the score".into(), self.floor);
            let must = format!("be below {:?}, the level of the event", event.level());
            return Err(ParameterError::Wrong { name, value, must }.into());
        }
        let ready = solver.ready(machine, start.into())?;
        let last = ready.steps_in(self.periods)?;
        let stages = Stages { of: self, ready: &ready, event, last };
        let levels = stages.pilot()?.ok_or(NoiseError::cancelled(0, self.repeats))?;
        let repeat = |repeats: Range<usize>| stages.repeat(repeats.end as u64, &levels);
        let repeats = self.watch.begin(0, self.repeats).blocks(0..self.repeats, 1, repeat)?;
        if repeats.len() < Estimate::BATCHES {
            return Err(NoiseError::cancelled(repeats.len(), self.repeats));
        }
        let products: Vec<f64> = repeats.iter().map(|repeat| repeat.shares.iter().product()).collect();
        let mean = |stage: usize| {
            repeats.iter().map(|repeat| repeat.shares[stage]).sum::<f64>() / repeats.len() as f64
        };
        Ok(RareEvent {
            probability: Estimate::of(&products)?,
            shares: (0..levels.len()).map(mean).collect(),
            steps: repeats.iter().map(|repeat| repeat.steps).sum(),
            levels,
        })
    }
}

/// The shares of a repeat, and the steps of all particles.
struct Repeat {
    shares: Vec<f64>,
    steps: u64,
}

/// What all stages of a splitting need.
struct Stages<'a, 'm, 'w, G, const W: usize> {
    of: &'a Splitting<'w>,
    ready: &'a Ready<'m, G, W>,
    event: &'a Event,
    last: u64,
}

impl<G: Shape, const W: usize> Stages<'_, '_, '_, G, W> {
    fn limits(&self, level: f64) -> Limits {
        Limits { level, floor: self.of.floor, last: self.last }
    }

    /// The particles of a stage: copies of the states that entered it. Each state is copied as often as any
    /// other, up to one copy, beginning at a random one.
    fn enter(&self, repeat: u64, stage: usize, from: &[Particle]) -> Vec<Particle> {
        let seed = self.ready.seed;
        let draw = CounterRng::new(seed, repeat, u64::MAX, stage as u64).next_u64();
        let share = (draw >> 11) as f64 / (1u64 << 53) as f64;
        let count = self.of.particles;
        let copy = |i: usize| {
            let source = ((i as f64 + share) * from.len() as f64 / count as f64) as usize;
            let member = (repeat << 34) | ((stage as u64) << 26) | i as u64;
            Particle { member, ..from[source.min(from.len() - 1)].clone() }
        };
        (0..count).map(copy).collect()
    }

    fn start(&self) -> Vec<Particle> {
        let State { q, v, .. } = self.ready.start.clone();
        vec![Particle { member: 0, number: 0, score: f64::NEG_INFINITY, q, v }]
    }

    /// Levels from a run of its own: the next one is reached by a share of 0.2 of the particles.
    fn pilot(&self) -> Result<Option<Vec<f64>>, NoiseError> {
        let (mut levels, mut from) = (Vec::new(), self.start());
        let (top, go_on) = (self.event.level(), || !self.of.watch.is_cancelled());
        for stage in 0..STAGES {
            let particles = self.enter(0, stage, &from);
            let Some(ends) = follow(self.ready, self.event, self.limits(top), &particles, &go_on)? else {
                return Ok(None);
            };
            let mut tops: Vec<f64> = ends.iter().map(|end| end.top).collect();
            tops.sort_by(f64::total_cmp);
            let level = tops[((1.0 - SHARE) * tops.len() as f64) as usize].min(top);
            let below = levels.last().copied().unwrap_or(self.of.floor);
            if level <= below || level == f64::NEG_INFINITY {
                return Err(NoiseError::Extinct { stage, score: level });
            }
            levels.push(level);
            if level >= top {
                return Ok(Some(levels));
            }
            // The same particles with the same random numbers, up to the level.
            let Some((entered, _)) = self.pass(particles, level)? else { return Ok(None) };
            from = entered;
        }
        Err(NoiseError::Extinct { stage: STAGES, score: levels[STAGES - 1] })
    }

    /// The states in which particles entered a level, and the number of steps; `None` if cancelled.
    fn pass(&self, particles: Vec<Particle>, level: f64) -> Result<Option<(Vec<Particle>, u64)>, NoiseError> {
        // A state that entered the last level far enough has entered this one, too.
        let (mut entered, rest): (Vec<_>, Vec<_>) =
            particles.into_iter().partition(|particle| particle.score >= level);
        if rest.is_empty() {
            return Ok(Some((entered, 0)));
        }
        let go_on = || !self.of.watch.is_cancelled();
        let ends = follow(self.ready, self.event, self.limits(level), &rest, &go_on)?;
        Ok(ends.map(|ends| {
            let steps = ends.iter().zip(&rest).map(|(end, start)| end.at.number - start.number).sum();
            entered.extend(ends.into_iter().filter(|end| end.reached).map(|end| end.at));
            (entered, steps)
        }))
    }

    /// The shares of one repeat, counted from 1; 0 from the stage on in which no particle reached the next
    /// level.
    fn repeat(&self, repeat: u64, levels: &[f64]) -> Result<Option<Repeat>, NoiseError> {
        let mut from = self.start();
        let mut seen = Repeat { shares: vec![0.0; levels.len()], steps: 0 };
        for (stage, &level) in levels.iter().enumerate() {
            let particles = self.enter(repeat, stage, &from);
            let Some((entered, steps)) = self.pass(particles, level)? else { return Ok(None) };
            seen.shares[stage] = entered.len() as f64 / self.of.particles as f64;
            seen.steps += steps;
            if entered.is_empty() {
                break;
            }
            from = entered;
        }
        Ok(Some(seen))
    }
}

impl RareEvent {
    /// The probability. Its batches are the repeats.
    pub fn probability(&self) -> Estimate {
        self.probability
    }
    /// The levels of the score that the pilot chose, the level of the event last.
    pub fn levels(&self) -> &[f64] {
        &self.levels
    }
    /// The mean share of particles that entered each level from the one before.
    pub fn shares(&self) -> &[f64] {
        &self.shares
    }
    /// Number of steps of all particles of all repeats.
    pub fn steps(&self) -> u64 {
        self.steps
    }
}
