//! Scores: numbers that measure how far a state is on its way to an event.

use crate::contact::Contact;
use crate::model::Shape;
use crate::random::white::noisy_lanes::Look;
use crate::sweep::lanes::number::Lanes;
use std::fmt;
use std::sync::Arc;

type Of = Arc<dyn Fn(&StepEnd<'_>) -> f64 + Send + Sync>;

/// A state at the end of a step, with what a score may read.
///
/// ```
/// use gear_dynamics::random::StepEnd;
/// let loss = |at: &StepEnd<'_>| -at.contacts[0].penetration(); // positive in the gap
/// let energy = |at: &StepEnd<'_>| 0.5 * (at.v[0] * at.v[0] + at.q[0] * at.q[0]);
/// let at = StepEnd { t: 0.0, q: &[1.0], v: &[2.0], contacts: &[] };
/// assert_eq!(energy(&at), 2.5);
/// # let _ = loss;
/// ```
#[derive(Clone, Copy, Debug)]
pub struct StepEnd<'a> {
    /// Time.
    pub t: f64,
    /// Coordinates.
    pub q: &'a [f64],
    /// Velocities.
    pub v: &'a [f64],
    /// Contacts.
    pub contacts: &'a [Contact],
}

/// An event: a score of the state reaches a level. The score is any function of the state that is continuous
/// along the motion.
///
/// The score is read at the end of each step. An excursion above the level between two steps is missed. For a
/// score of coordinates and deflections such excursions are rare. A score of velocities that are noisy
/// themselves is rough: excursions between steps shift the level by 0.5826 √(D h) (Broadie, Glasserman and
/// Kou 1997).
///
/// ```
/// use gear_dynamics::random::Event;
/// let deep = Event::new(2.0, |at| at.q[0]); // q0 reaches 2
/// assert_eq!(deep.level(), 2.0);
/// ```
#[derive(Clone)]
pub struct Event {
    score: Of,
    level: f64,
}

impl fmt::Debug for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Event").field("level", &self.level).finish_non_exhaustive()
    }
}

impl Event {
    /// The event that `score` reaches `level`.
    pub fn new(level: f64, score: impl Fn(&StepEnd<'_>) -> f64 + Send + Sync + 'static) -> Self {
        Event { score: Arc::new(score), level }
    }
    /// Loss of contact: contact `i` reaches the edge of its gap from either flank.
    ///
    /// ```
    /// use gear_dynamics::random::{Event, FirstPassage, NoisySteps, WhiteNoise};
    /// use gear_dynamics::{models::Oscillator, State};
    /// // q'' = 1 - (q - 0.5) - 0.2 q' + √0.2 ξ on the upper flank: from rest at 1.5 to the edge at 0.5.
    /// let pair = [("speed", 1.0), ("mesh stiffness", 1.0), ("half backlash", 0.5), ("mean force", 1.0)];
    /// let pair = Oscillator::new(&pair)?;
    /// let solver = NoisySteps::new(60, &[WhiteNoise::bath(0, 0.2, 0.2)?]);
    /// let start = State::new(0.0, &[1.5], &[0.0]);
    /// let seen = FirstPassage::new(500.0)?.run(&solver, &pair, &start, &Event::contact_loss(0))?;
    /// assert_eq!(seen.reached(), 1024);
    /// assert!((seen.times().mean() - 21.3).abs() < 2.5, "{}", seen.times().mean()); // standard error 0.7
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn contact_loss(i: usize) -> Self {
        Event::new(0.0, move |at| at.contacts.get(i).map_or(f64::NAN, |contact| -contact.penetration()))
    }
    /// The level.
    pub fn level(&self) -> f64 {
        self.level
    }
    pub(crate) fn score(&self, at: &StepEnd<'_>) -> f64 {
        (self.score)(at)
    }
}

/// Memory for the state of one lane.
pub(crate) struct OneLane<const W: usize> {
    all: Vec<Contact<Lanes<W>>>,
    q: Vec<f64>,
    v: Vec<f64>,
    contacts: Vec<Contact>,
}

impl<const W: usize> OneLane<W> {
    pub(crate) fn new(dof: usize, contacts: usize) -> Self {
        OneLane {
            all: vec![Contact::default(); contacts],
            q: vec![0.0; dof],
            v: vec![0.0; dof],
            contacts: vec![Contact::default(); contacts],
        }
    }

    /// Evaluates the contacts of all lanes at the end of a step.
    #[inline(always)]
    pub(crate) fn look<G: Shape>(&mut self, step: &Look<'_, G, W>) {
        for (i, contact) in self.all.iter_mut().enumerate() {
            *contact = step.contact(i);
        }
    }

    /// Score of a lane at the end of a step.
    pub(crate) fn score<G: Shape>(&mut self, step: &Look<'_, G, W>, lane: usize, event: &Event) -> f64 {
        self.q.iter_mut().zip(step.q).for_each(|(to, q)| *to = q.0[lane]);
        self.v.iter_mut().zip(step.v).for_each(|(to, v)| *to = v.0[lane]);
        for (to, all) in self.contacts.iter_mut().zip(&self.all) {
            *to = Contact {
                deflection: all.deflection.0[lane],
                rate: all.rate.0[lane],
                lower: all.lower.0[lane],
                upper: all.upper.0[lane],
                lower_rate: all.lower_rate.0[lane],
                upper_rate: all.upper_rate.0[lane],
                force: all.force.0[lane],
            };
        }
        let t = step.number[lane] as f64 * step.h;
        event.score(&StepEnd { t, q: &self.q, v: &self.v, contacts: &self.contacts })
    }
}
