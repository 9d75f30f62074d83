//! Location of edges: the contact that leaves its piece first, and the instant.

use crate::contact::edge::Edge;
use crate::contact::{Contact, Piece};
use crate::numeric::search::extremes::larger;
use crate::numeric::search::hermite::Hermite;
use crate::ode::edges::exit::{Exit, Found, SLACK, Share, WIDE, first_way, is_wide, scale};
use crate::ode::edges::first_root::{DOUBT, first_root};
use crate::ode::edges::gaps::{Gaps, Resolved};
use crate::ode::edges::stops::Stops;
use crate::ode::step::Crossing;
use crate::ode::stepping::ends::Ends;
use crate::ode::stepping::engine::{Engine, Tableau};
use crate::ode::stepping::vector::Vector;

/// Slack and accuracy of location for contacts with a rigid stop, where velocities jump, as a share of the
/// gap `[1]`.
const STOP: f64 = 1e-14;

/// Accuracy of the location of an edge, as a share of the gap `[1]`.
const CLOSE: f64 = 1e-13;

/// Factor by which an earlier step counts less with each later one: the steps of a motion that has settled
/// move contacts less than the first ones.
const FADING: f64 = 0.8;

/// Minimum slack, in units of the effect of rounding on the deflection.
const NOISE: f64 = 4.0;

/// Accepted steps between two measurements of the effect of rounding on the deflections.
const STEPS_BETWEEN: u8 = 31;

/// Largest distance from its edge, as a share of the gap `[1]`, at which a contact may cross together with
/// the located one.
const WITH: f64 = 1e-6;

/// A contact within the slack at the end of a step crosses there if its distance decreases faster than this
/// number of slacks per step.
pub(crate) const PLAIN: f64 = 1e3;

/// A contact rests on its edge while its distance and its rate stay below this number of effects of the
/// absolute tolerances on them. Its crossings in this time are errors of the integration.
const REST: f64 = 16.0;

/// A motion this many times larger than these effects is resolved.
const FAR: f64 = 1e3;

/// A crossing at the start of a step that no step has reported. The shortest step reports it at its end.
#[derive(Clone, Copy)]
pub(crate) struct Late {
    /// Time from the start of the step to the edge.
    pub(crate) after: f64,
    /// Whether it is an impact on a rigid stop. The step then ends in the state in which it starts, so that
    /// all that touch there touch at its end.
    pub(crate) strikes: bool,
}

/// The contacts of one run at the ends of the current step, and the data for the location of their edges.
pub(crate) struct Locator {
    /// Contacts at the start of the step.
    pub(crate) start: Vec<Contact>,
    /// Contacts at the end of the step.
    end: Vec<Contact>,
    pub(crate) stops: Stops,
    /// Whether the acceleration jumped at the first crossing of each contact, taken for both edges; `None`:
    /// no crossing yet.
    pub(crate) jumps: Vec<Option<bool>>,
    /// Number of changes of piece, or of impacts, of each contact since the time last advanced.
    pub(crate) still: Vec<u8>,
    /// Whether each contact took its piece at the start of the step.
    pub(crate) fresh: Vec<bool>,
    /// Twice the distance from its edge at which each contact has crossed it at the end of the step.
    pub(crate) missed: Vec<f64>,
    gaps: Gaps,
    /// Effect of rounding of the coordinates and velocities on each deflection.
    pub(crate) noise: Vec<f64>,
    /// The effect before it was last measured.
    before: Vec<f64>,
    /// Effect of the absolute tolerances on each deflection and its rate. Empty without tolerances.
    tolerated: Vec<[f64; 2]>,
    /// Whether the motion of each contact has exceeded these effects by far.
    resolved: Vec<bool>,
    /// Scratch of the measurement.
    here: Vec<Contact>,
    /// The largest change of the distance of each contact from its edges in one step. Earlier steps count
    /// less, by [`FADING`] for each later one.
    ways: Vec<f64>,
    /// Number of steps until `noise` is measured again.
    countdown: u8,
    /// Maximum ratio of the next step to the current one.
    pub(crate) growth: f64,
}

impl Locator {
    /// Maximum number of changes of piece of one contact at one instant. A passage through the gap takes two.
    pub(crate) const STILL: u8 = 4;

    pub(crate) fn new(contacts: usize, stops: Stops) -> Self {
        Locator {
            stops,
            start: vec![Contact::default(); contacts],
            end: vec![Contact::default(); contacts],
            jumps: vec![None; contacts],
            still: vec![0; contacts],
            fresh: vec![true; contacts],
            missed: vec![0.0; contacts],
            gaps: Gaps::new(contacts),
            noise: vec![0.0; contacts],
            before: vec![0.0; contacts],
            tolerated: Vec::new(),
            resolved: vec![false; contacts],
            here: Vec::new(),
            ways: vec![0.0; contacts],
            countdown: 0,
            growth: f64::INFINITY,
        }
    }

    /// Determines the piece of every contact at the start of a step from its deflection; on an edge, from its
    /// rate. A contact within the slack of its present piece keeps this piece, unless `afresh` is set. A
    /// contact that has just crossed to its piece keeps it up to [`missed`](Locator::missed) beyond the edge.
    /// A contact does not enter the flank of a rigid stop. A contact at rest in a gap without width is on its
    /// upper flank.
    pub(crate) fn classify<V: Vector>(&mut self, e: &mut Ends<'_, V>, afresh: bool) {
        e.contacts_at_start();
        self.start.copy_from_slice(&e.contacts);
        for (i, (piece, c)) in e.pieces.iter_mut().zip(&self.start).enumerate() {
            if self.ways[i] == 0.0 {
                self.ways[i] = first_way(c);
            }
            let rates = [c.rate - c.lower_rate, c.rate - c.upper_rate];
            let slack = self.slack(i, c).max(self.rest(i, rates)).max(self.missed[i]);
            let inside = match Edge::of(*piece) {
                Some(edge) => edge.depth(c) >= -slack,
                None => Edge::BOTH.into_iter().all(|edge| edge.depth(c) <= slack),
            };
            if inside && !afresh {
                continue;
            }
            let enters = |edge: Edge| {
                let (depth, rate) = (edge.depth(c), edge.depth_rate(c));
                !edge.is_stop(&self.stops.rigid, i) && (depth > slack || (depth >= -slack && rate > 0.0))
            };
            let before = *piece;
            *piece = if enters(Edge::Upper) {
                Piece::Upper
            } else if enters(Edge::Lower) {
                Piece::Lower
            } else if !self.stops.any(i) && c.upper <= c.lower {
                // A gap without width has no inside: at rest in it, both flanks carry the same slope.
                Piece::Upper
            } else {
                Piece::Gap
            };
            self.fresh[i] |= afresh || *piece != before;
        }
    }

    /// Makes the end of the step the start of the next one.
    #[inline(always)]
    pub(crate) fn accept<V: Vector>(&mut self, e: &mut Ends<'_, V>) {
        for ((start, longest), end) in self.start.iter_mut().zip(&mut self.ways).zip(&e.contacts) {
            // NaN at an edge that is infinite.
            let way = |edge: Edge| (edge.distance(end) - edge.distance(start)).abs();
            *longest = larger(way(Edge::Upper), larger(way(Edge::Lower), *longest));
            *start = *end;
        }
        self.advance();
        if self.countdown == 0 {
            self.measure_noise(e);
        } else {
            self.countdown -= 1;
        }
    }

    /// Notes a way of contact `i` from an edge in one step. NaN is ignored.
    #[inline(always)]
    pub(crate) fn goes(&mut self, i: usize, way: f64) {
        self.ways[i] = larger(way, self.ways[i]);
    }

    /// The time has advanced.
    #[inline(always)]
    pub(crate) fn advance(&mut self) {
        let lists = self.ways.iter_mut().zip(&mut self.still).zip(&mut self.fresh);
        for (i, ((way, still), fresh)) in lists.enumerate() {
            // Rebounds that become smaller end in rest: they are resolved as far as the first ones.
            if !self.stops.any(i) {
                *way *= FADING;
            }
            (*still, *fresh) = (0, false);
        }
    }

    /// The crossing of a contact that leaves its piece at the start of the step, if no step has reported it:
    /// the contact was on this piece before, and the last step ended within the slack of the edge. A contact
    /// that approaches a rigid stop at the start of the step has not struck it yet.
    #[cold]
    pub(crate) fn crosses_late<V: Vector>(&self, e: &mut Ends<'_, V>, exit: Exit) -> Option<Late> {
        let i = exit.contact;
        let strikes = exit.edge.is_stop(&self.stops.rigid, i);
        if !strikes && (self.fresh[i] || self.still[i] > 0) {
            return None;
        }
        e.contacts_at_start();
        let d = exit.distance(e.pieces[i], &e.contacts[i], 1.0);
        if strikes && d.rate >= 0.0 {
            return None;
        }
        let after = if !strikes && d.value > 0.0 && d.rate < 0.0 { d.value / -d.rate } else { 0.0 };
        Some(Late { after, strikes })
    }

    /// Measures the effect of rounding on the deflections. It grows with the coordinates.
    #[cold]
    pub(crate) fn measure_noise<V: Vector>(&mut self, e: &mut Ends<'_, V>) {
        self.countdown = STEPS_BETWEEN;
        e.rounding_of_contacts(&mut self.noise);
        if e.atol.slice().iter().all(|atol| *atol == 0.0) {
            return;
        }
        self.tolerated.resize(self.noise.len(), [0.0; 2]);
        self.here.resize(self.noise.len(), Contact::default());
        e.tolerances_of_contacts(&mut self.tolerated, &mut self.here);
        for ((resolved, c), tolerated) in self.resolved.iter_mut().zip(&e.contacts).zip(&self.tolerated) {
            let far = |edge: Edge| edge.depth(c).abs().min(scale(c)) > FAR * tolerated[0];
            *resolved |= Edge::BOTH.into_iter().all(far) && tolerated[1] > 0.0;
        }
    }

    /// Measures the effect of rounding anew at the end of the step. Returns whether it is twice as large
    /// there: a motion from rest at 0 grows by many orders in a step.
    #[cold]
    fn noise_has_grown<V: Vector>(&mut self, e: &mut Ends<'_, V>) -> bool {
        self.before.clone_from(&self.noise);
        e.rounding_of_contacts_at_end(&mut self.noise);
        self.before.iter().zip(&self.noise).any(|(before, now)| *now > 2.0 * before)
    }

    /// The distance past its edge at which a contact rests that moves at `rates` at both ends of a step: 0,
    /// or [`REST`] times the effect of the tolerances, if its rates are as small. A contact whose whole
    /// motion is as small does not rest: it is not resolved.
    #[inline]
    fn rest(&self, i: usize, rates: [f64; 2]) -> f64 {
        match self.tolerated.get(i) {
            Some([distance, rate]) if self.resolved[i] && !self.stops.any(i) => {
                let slow = rates[0].abs().max(rates[1].abs()) <= REST * rate;
                if slow { REST * distance } else { 0.0 }
            }
            _ => 0.0,
        }
    }

    /// Slack: the distance past its edge up to which contact `i` still counts as on its piece.
    #[inline]
    pub(crate) fn slack(&self, i: usize, c: &Contact) -> f64 {
        self.slack_of(i, scale(c))
    }

    /// The slack of contact `i` with this [`scale`].
    #[inline(always)]
    pub(crate) fn slack_of(&self, i: usize, scale: f64) -> f64 {
        (self.share(i, SLACK) * self.length(i, scale)).max(NOISE * self.noise[i])
    }

    /// The length to which the slack and the accuracy of the location of contact `i` are relative.
    #[inline(always)]
    fn length(&self, i: usize, scale: f64) -> f64 {
        let way = self.ways[i];
        if way > 0.0 && is_wide(scale, way) { WIDE * way } else { scale }
    }

    /// Returns `share`, or `STOP` for a contact with a rigid stop.
    #[inline]
    fn share(&self, i: usize, share: f64) -> f64 {
        if self.stops.any(i) { STOP } else { share }
    }

    /// Moves a contact to another piece. `false`: more than `STILL` changes at this instant.
    pub(crate) fn change(&mut self, pieces: &mut [Piece], exit: Exit) -> bool {
        pieces[exit.contact] = exit.edge.beyond(pieces[exit.contact]);
        self.still[exit.contact] += 1;
        self.still[exit.contact] <= Self::STILL
    }

    /// Whether one of the crossings is the first of its contact: whether the acceleration jumps there is not
    /// known.
    pub(crate) fn has_unknown_jump(&self, crossings: &[Crossing]) -> bool {
        crossings.iter().any(|c| !c.rebounds && self.jumps[c.contact].is_none())
    }

    /// The exits of all other contacts that reach their edges together with the located one: within the
    /// slack, or within twice the time |d/d'| by which the location of its edge is off. In the latter case
    /// the distance is at most `WITH` times the gap.
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
            let exits = Edge::around(pieces[i]).iter().map(move |&edge| Exit { contact: i, edge });
            exits.filter(move |exit| {
                let d = exit.distance(pieces[i], &contacts[i], 1.0);
                let length = self.length(i, scale(&contacts[i]));
                d.rate < 0.0
                    && d.value <= self.slack(i, &contacts[i]).max((time * d.rate.abs()).min(WITH * length))
            })
        })
    }

    /// The first exit inside the current step. On entry and on return of [`Found::Nothing`] or [`Found::At`],
    /// the contacts of `e` are those at the end of the step, otherwise those at some instant inside it.
    ///
    /// `Err`: the step does not resolve the gaps and must be repeated with this factor times its length.
    #[inline(never)]
    pub(crate) fn find<T: Tableau, V: Vector>(&mut self, e: &mut Engine<'_, V>) -> Result<Found<Share>, f64> {
        let mut limit = 1.0;
        let mut first = Found::Nothing;
        // The search evaluates contacts inside the step in `e.contacts`.
        std::mem::swap(&mut self.end, &mut e.ends.contacts);
        let mut resolved = self.gaps.look::<T, V>(e, &self.start, &self.end, &self.noise);
        if matches!(resolved, Resolved::No(_)) && self.noise_has_grown(&mut e.ends) {
            resolved = self.gaps.look::<T, V>(e, &self.start, &self.end, &self.noise);
        }
        match resolved {
            Resolved::Yes(growth) => self.growth = growth,
            Resolved::No(share) => return Err(share),
        }
        for (i, (seen, end)) in self.gaps.seen.iter().zip(&self.end).enumerate() {
            let piece = e.ends.pieces[i];
            for (seen, &edge) in seen.iter().zip(Edge::around(piece)) {
                let (d0, d1, doubt) = (seen.start, seen.end, DOUBT * seen.off);
                if Hermite::is_clear(d0, d1, doubt) {
                    continue;
                }
                let exit = Exit { contact: i, edge };
                let slack =
                    self.slack(i, end).max(self.rest(i, [d0.rate, d1.rate].map(|rate| rate / e.ends.h())));
                let hermite = Hermite::new(d0, d1);
                // The crossing is at the end of the step: the next step would start past the edge and not
                // report it.
                let met = d0.value > slack && d1.value.abs() <= slack && d1.rate < -PLAIN * slack;
                if met && matches!(first, Found::Nothing) {
                    first = Found::At(Share(1.0), exit);
                }
                let clear = d1.value >= -slack
                    && !hermite.may_dip(d0, d1)
                    && (doubt <= slack
                        || hermite.stays_above(doubt)
                        || (d0.value >= -slack && hermite.rises(doubt)));
                if d1.value == f64::INFINITY || clear {
                    continue;
                }
                let close = (self.share(i, CLOSE) * self.length(i, scale(end))).max(self.noise[i]);
                match first_root::<T, V>(e, exit, [d0, d1], &hermite, limit, [slack, close]) {
                    Some(0.0) => return Ok(Found::AtOnce(exit)),
                    Some(theta) => {
                        limit = theta;
                        first = Found::At(Share(theta), exit);
                    }
                    None => {}
                }
            }
        }
        std::mem::swap(&mut self.end, &mut e.ends.contacts);
        Ok(first)
    }

    /// The time after which the motion lies behind every edge that it has crossed `[s]`. The crossing may
    /// have been located before its edge, within the slack. 0 without a crossing, infinite without a rate.
    pub(crate) fn behind(&self, crossings: &[Crossing], contacts: &[Contact], t: f64) -> f64 {
        let time = |i: usize| 2.0 * self.slack(i, &contacts[i]) / contacts[i].rate.abs();
        let crossed = crossings.iter().filter(|c| !c.rebounds).map(|c| time(c.contact));
        crossed.reduce(f64::max).map_or(0.0, |longest| longest + 4.0 * f64::EPSILON * t.abs())
    }

    /// Distance of a contact from the edge of an exit, its rate in time, and its slack.
    pub(crate) fn miss(&self, pieces: &[Piece], contacts: &[Contact], exit: Exit) -> (f64, f64, f64) {
        let c = &contacts[exit.contact];
        let d = exit.distance(pieces[exit.contact], c, 1.0);
        (d.value, d.rate, self.slack(exit.contact, c))
    }
}
