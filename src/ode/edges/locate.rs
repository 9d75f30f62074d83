//! Tooth edges: which contact leaves its piece first, and when.

use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::model::equations::Model;
use crate::ode::edges::exit::{Exit, SLACK, scale};
use crate::ode::edges::first_root::{DOUBT, first_root};
use crate::ode::edges::gaps::{Gaps, Resolved};
use crate::ode::edges::hermite::Hermite;
use crate::ode::edges::stops::Stops;
use crate::ode::stepping::engine::{Engine, Tableau};
use crate::ode::stepping::vector::Vector;

/// The same of a rigid stop, where velocities jump.
const STOP: f64 = 1e-14;

/// How closely an edge is met: this share of the gap.
const CLOSE: f64 = 1e-13;

/// Slack, in units of what rounding of the coordinates moves the deflection by.
const NOISE: f64 = 4.0;

/// Accepted steps between two measurements of what rounding moves the deflections by.
const LOOKS: u8 = 31;

/// Contacts this close to their edges, in shares of the gap, may cross together with the one located.
const WITH: f64 = 1e-6;

/// An edge within the slack at the end of a step is met there when the distance falls by this many slacks in a step as long.
const PLAIN: f64 = 1e3;

/// The contacts of one run: where they stood at the start of the step, and on which piece.
pub(crate) struct Locator {
    pub(crate) start: Vec<Contact>,
    end: Vec<Contact>,
    pub(crate) stops: Stops,
    /// Which contacts are known to jump in force at their edges.
    pub(crate) jumps: Vec<Option<bool>>,
    /// Changes of piece since time last moved.
    pub(crate) still: Vec<u8>,
    gaps: Gaps,
    /// What rounding of large coordinates moves each deflection by.
    noise: Vec<f64>,
    /// Steps until it is measured again.
    countdown: u8,
    /// How many times as long as this step the next may be.
    pub(crate) growth: f64,
}

/// What was found in a step.
pub(crate) enum Found {
    /// No contact leaves its piece.
    Nothing,
    /// This one does, at θ.
    At(f64, Exit),
    /// This one left already when the step began.
    AtOnce(Exit),
    /// The gaps move too fast for the step: it is to be made again, this many times as long.
    TooLong(f64),
}

impl Locator {
    /// How often a contact may change its piece without time moving: once through the gap and back would be two.
    pub(crate) const STILL: u8 = 4;

    pub(crate) fn new(contacts: usize, stops: Stops) -> Self {
        Locator {
            stops,
            start: vec![Contact::default(); contacts],
            end: vec![Contact::default(); contacts],
            jumps: vec![None; contacts],
            still: vec![0; contacts],
            gaps: Gaps::new(contacts),
            noise: vec![0.0; contacts],
            countdown: 0,
            growth: f64::INFINITY,
        }
    }

    /// Reads off the pieces at the start: by the deflection, on an edge by the rate. A contact that still lies on its own
    /// piece within the slack stays there.
    pub(crate) fn classify<M: Model + ?Sized, V: Vector>(&mut self, e: &mut Engine<'_, M, V>, afresh: bool) {
        e.contacts_at_start();
        self.start.copy_from_slice(&e.contacts);
        for (i, (piece, c)) in e.pieces.iter_mut().zip(&self.start).enumerate() {
            let slack = self.slack(i, c);
            let (above, below) = (c.deflection - c.upper, c.lower - c.deflection);
            let inside = match *piece {
                Piece::Lower => below >= -slack,
                Piece::Gap => above <= slack && below <= slack,
                Piece::Upper => above >= -slack,
            };
            if inside && !afresh {
                continue;
            }
            let [lower, upper] = [Piece::Lower, Piece::Upper].map(|on| !self.stops.rigid(i, on));
            *piece = if upper && (above > slack || (above >= -slack && c.rate > c.upper_rate)) {
                Piece::Upper
            } else if lower && (below > slack || (below >= -slack && c.rate < c.lower_rate)) {
                Piece::Lower
            } else {
                Piece::Gap
            };
        }
    }

    /// The end of the step becomes the start of the next.
    #[inline(always)]
    pub(crate) fn accept<M: Model + ?Sized, V: Vector>(&mut self, e: &mut Engine<'_, M, V>) {
        self.start.copy_from_slice(&e.contacts);
        self.still.fill(0);
        if self.countdown == 0 {
            self.measure_noise(e);
        } else {
            self.countdown -= 1;
        }
    }

    /// Measures what rounding moves the deflections by: coordinates may have grown.
    #[cold]
    pub(crate) fn measure_noise<M: Model + ?Sized, V: Vector>(&mut self, e: &mut Engine<'_, M, V>) {
        self.countdown = LOOKS;
        e.rounding_of_contacts(&mut self.noise);
    }

    /// How far contact `i` may lie past its edge before it counts.
    #[inline]
    pub(crate) fn slack(&self, i: usize, c: &Contact) -> f64 {
        (self.share(i, SLACK) * scale(c)).max(NOISE * self.noise[i])
    }

    /// A share of the gap, or that for rigid stops.
    #[inline]
    fn share(&self, i: usize, share: f64) -> f64 {
        if self.stops.any(i) { STOP } else { share }
    }

    /// Moves a contact to another piece; `false` when it has done so too often at this instant.
    pub(crate) fn change(&mut self, pieces: &mut [Piece], exit: Exit) -> bool {
        pieces[exit.contact] = exit.to;
        self.still[exit.contact] += 1;
        self.still[exit.contact] <= Self::STILL
    }

    /// Every other contact that reaches its edge together with the located one: within the slack, or within the time by which that
    /// one's edge was missed.
    pub(crate) fn together<'a>(
        &'a self,
        pieces: &'a [Piece],
        contacts: &'a [Contact],
        located: Exit,
    ) -> impl Iterator<Item = Exit> + 'a {
        let (value, rate, _) = self.miss(pieces, contacts, located);
        let time = if rate == 0.0 { 0.0 } else { 2.0 * (value / rate).abs() };
        let others = (0..contacts.len()).filter(move |&i| i != located.contact);
        others.flat_map(move |i| {
            Exit::of(i, pieces[i]).into_iter().flatten().filter(move |exit| {
                let d = exit.distance(pieces[i], &contacts[i], 1.0);
                let length = scale(&contacts[i]);
                d.rate < 0.0
                    && d.value <= self.slack(i, &contacts[i]).max((time * d.rate.abs()).min(WITH * length))
            })
        })
    }

    /// The first exit inside the step just made; its end contacts are in `e.contacts`.
    pub(crate) fn find<T: Tableau, M: Model + ?Sized, V: Vector>(
        &mut self,
        e: &mut Engine<'_, M, V>,
    ) -> Found {
        let h = e.h();
        let mut limit = 1.0;
        let mut first = Found::Nothing;
        self.end.copy_from_slice(&e.contacts);
        match self.gaps.look::<T, M, V>(e, &self.start, &self.end, &self.noise) {
            Resolved::Yes(growth) => self.growth = growth,
            Resolved::No(share) => return Found::TooLong(share),
        }
        for (i, (start, end)) in self.start.iter().zip(&self.end).enumerate() {
            for way in 0..2 {
                let Some(exit) = Exit::of(i, e.pieces[i])[way] else { break };
                let (d0, d1) = (exit.distance(e.pieces[i], start, h), exit.distance(e.pieces[i], end, h));
                let doubt = DOUBT * self.gaps.off(i, way);
                if Hermite::is_clear(d0, d1, doubt) {
                    continue;
                }
                let slack = self.slack(i, end);
                let hermite = Hermite::new(d0, d1);
                // Met just where the step ends: the next one would begin behind it and never tell of it.
                let met = d0.value > slack && d1.value.abs() <= slack && d1.rate < -PLAIN * slack;
                if met && matches!(first, Found::Nothing) {
                    first = Found::At(1.0, exit);
                }
                let clear = d1.value >= -slack
                    && !hermite.may_dip(d0, d1)
                    && (doubt <= slack || hermite.stays_above(doubt));
                if d1.value == f64::INFINITY || clear {
                    continue;
                }
                let close = (self.share(i, CLOSE) * scale(end)).max(self.noise[i]);
                match first_root::<T, M, V>(e, exit, [d0, d1], &hermite, limit, [slack, close]) {
                    Some(0.0) => return Found::AtOnce(exit),
                    Some(theta) => {
                        limit = theta;
                        first = Found::At(theta, exit);
                    }
                    None => {}
                }
            }
        }
        // Looking inside the step overwrote these.
        e.contacts.copy_from_slice(&self.end);
        first
    }

    /// Distance of an exit's contact from its edge, its rate in time, and the distance that counts as none.
    pub(crate) fn miss(&self, pieces: &[Piece], contacts: &[Contact], exit: Exit) -> (f64, f64, f64) {
        let c = &contacts[exit.contact];
        let d = exit.distance(pieces[exit.contact], c, 1.0);
        (d.value, d.rate, self.slack(exit.contact, c))
    }
}
