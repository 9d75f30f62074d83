//! Particles in lanes, each until its own end.

use crate::model::Shape;
use crate::random::rare::score::{Event, OneLane};
use crate::random::white::error::NoiseError;
use crate::random::white::noisy_lanes::{Gauge, Look};
use crate::random::white::solver::{Ready, STEPS_UNCHECKED};

/// A particle: a state after a number of steps, and the member whose random numbers it has from there on.
#[derive(Clone, Debug)]
pub(crate) struct Particle {
    pub(crate) member: u64,
    pub(crate) number: u64,
    /// Score at this state; -∞ if it is not known.
    pub(crate) score: f64,
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
}

/// Where a particle ends.
#[derive(Clone, Debug)]
pub(crate) struct End {
    /// Whether the score reached the level.
    pub(crate) reached: bool,
    /// Largest score on the way.
    pub(crate) top: f64,
    /// Score one step before the end.
    pub(crate) before: f64,
    /// The state at the end, with its score.
    pub(crate) at: Particle,
}

/// The ends of a particle: a level from below, a floor from above, a number of steps since time 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    pub(crate) level: f64,
    pub(crate) floor: f64,
    pub(crate) last: u64,
}

/// Follows particles until each has ended. Their ends, in their order; `None` if cancelled.
///
/// # Errors
/// [`NoiseError::Diverged`].
pub(crate) fn follow<G: Shape, const W: usize>(
    ready: &Ready<'_, G, W>,
    event: &Event,
    limits: Limits,
    particles: &[Particle],
    go_on: &dyn Fn() -> bool,
) -> Result<Option<Vec<End>>, NoiseError> {
    let size = ready.machine.size();
    let mut lanes = ready.empty();
    let mut ends: Vec<Option<End>> = vec![None; particles.len()];
    let mut gauge = EventGauge::<W> {
        event,
        limits,
        lane: OneLane::new(size.dof, size.contacts - size.kinks),
        running: [false; W],
        ended: [false; W],
        score: [0.0; W],
        before: [0.0; W],
        top: [0.0; W],
        any: false,
    };
    let (mut slots, mut next, mut open) = ([usize::MAX; W], 0, 0);
    loop {
        for (lane, held) in slots.iter_mut().enumerate() {
            if gauge.ended[lane] {
                let slot = *held;
                let state = |x: &[crate::sweep::bounds::Lanes<W>]| x.iter().map(|x| x.0[lane]).collect();
                let at = Particle {
                    member: particles[slot].member,
                    number: lanes.number[lane],
                    score: gauge.score[lane],
                    q: state(&lanes.q),
                    v: state(&lanes.v),
                };
                if !lanes.is_finite(lane) || at.score.is_nan() {
                    let t = at.number as f64 * ready.h;
                    return Err(NoiseError::Diverged { member: at.member, t });
                }
                let reached = at.score >= limits.level;
                ends[slot] = Some(End { reached, top: gauge.top[lane], before: gauge.before[lane], at });
                (gauge.ended[lane], gauge.running[lane]) = (false, false);
                open -= 1;
            }
            if !gauge.running[lane] {
                // Idle lanes run a copy of a particle, so that they do not diverge.
                let from = &particles[next.min(particles.len() - 1)];
                lanes.load(lane, from.member, from.number, &from.q, &from.v);
                (gauge.score[lane], gauge.top[lane]) = (from.score, from.score);
                gauge.running[lane] = next < particles.len();
                *held = next;
                if gauge.running[lane] {
                    (next, open) = (next + 1, open + 1);
                }
            }
        }
        if open == 0 {
            return Ok(ends.into_iter().collect());
        }
        if !go_on() {
            return Ok(None);
        }
        gauge.any = false;
        lanes.run(STEPS_UNCHECKED, ready.set, &mut gauge);
    }
}

/// Watches the scores of all lanes and ends the steps as soon as one lane has ended.
struct EventGauge<'a, const W: usize> {
    event: &'a Event,
    limits: Limits,
    lane: OneLane<W>,
    running: [bool; W],
    ended: [bool; W],
    score: [f64; W],
    before: [f64; W],
    top: [f64; W],
    any: bool,
}

impl<G: Shape, const W: usize> Gauge<G, W> for EventGauge<'_, W> {
    #[inline(always)]
    fn look(&mut self, step: &Look<'_, G, W>) -> bool {
        self.lane.look(step);
        for lane in 0..W {
            if !self.running[lane] {
                continue;
            }
            let score = self.lane.score(step, lane, self.event);
            (self.before[lane], self.score[lane]) = (self.score[lane], score);
            if score > self.top[lane] {
                self.top[lane] = score;
            }
            let Limits { level, floor, last } = self.limits;
            // A score that is NaN ends the particle, too.
            if !(floor < score && score < level) || step.number[lane] >= last {
                (self.ended[lane], self.any) = (true, true);
            }
        }
        !self.any
    }
}
