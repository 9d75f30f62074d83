//! Rigid stops: impacts at the end of a step, and contacts that come to rest.

use crate::contact::piece::Piece;
use crate::contact::tooth::Contact;
use crate::model::equations::Model;
use crate::model::rigid_stops::rigid_edges;
use crate::ode::edges::exit::Exit;
use crate::ode::edges::locate::Locator;
use crate::ode::error::IntegrateError;
use crate::ode::step::Crossing;
use crate::ode::stepping::control::RESOLUTION;
use crate::ode::stepping::engine::{Engine, halves};
use crate::ode::stepping::vector::Vector;

/// Impacts at one instant, per contact, before they count as without end.
const ROUNDS: usize = 16;

/// A contact still approaches its stop, after an impact, at more than this share of the greatest speed of approach.
const APPROACHES: f64 = 1e-9;

/// A start may lie beyond a stop by this share of what its distance is made of.
const ROUNDING: f64 = 1e-12;

/// A step behind an impact is at most this many flights long: roots are known to a share of the step.
const LONGER: f64 = 4.0;

/// ... or this many times what the clock resolves.
const SHORTEST: f64 = 1e4;

/// Flights in a row no higher than an edge is met by, before a contact is said to rest.
const LOW: u8 = 4;

/// The last impact of a contact.
#[derive(Clone, Copy)]
pub(crate) struct Flight {
    since: f64,
    /// Speed over the stop at which it left.
    speed: f64,
    /// Flights in a row that were too low.
    low: u8,
    /// Height of the highest flight.
    highest: f64,
}

impl Flight {
    pub(crate) const NONE: Flight =
        Flight { since: f64::NEG_INFINITY, speed: f64::NAN, low: 0, highest: 0.0 };

    /// The next impact, behind which the contact leaves at `speed`: whether it rests, since it no longer flies any higher than `slack`, or than
    /// rounding of its highest flight.
    pub(crate) fn lands(&mut self, t: f64, speed: f64, slack: f64) -> bool {
        // The height of a parabola of this duration and speed.
        let height = 0.25 * self.speed * (t - self.since);
        self.highest = self.highest.max(height);
        self.low = match self.since == t {
            true => self.low,
            false if height <= slack.max(f64::EPSILON * self.highest) => self.low + 1,
            false => 0,
        };
        (self.since, self.speed) = (t, speed);
        self.low > LOW
    }
}

/// The rigid stops of one run; empty for a model without.
pub(crate) struct Stops {
    rigid: Vec<[bool; 2]>,
    /// Velocities behind the impacts at the end of the step, if there are any.
    v: Vec<f64>,
    met: bool,
    flights: Vec<Flight>,
    /// The shortest flight that has just ended: the next is no longer by orders.
    flew: f64,
}

impl Stops {
    /// None where edges are not located.
    pub(crate) fn new<M: Model + ?Sized, const LOCATE: bool>(model: &M) -> Self {
        let rigid = if LOCATE { rigid_edges(model) } else { Vec::new() };
        let contacts = rigid.len();
        Stops {
            v: vec![0.0; if contacts > 0 { model.dof() } else { 0 }],
            met: false,
            flew: f64::INFINITY,
            flights: vec![Flight::NONE; contacts],
            rigid,
        }
    }

    /// Room for the crossings of one instant.
    pub(crate) fn room(&self) -> usize {
        (ROUNDS + 1) * self.rigid.len()
    }

    /// Whether contact `i` has a stop on that flank.
    #[inline]
    pub(crate) fn rigid(&self, i: usize, on: Piece) -> bool {
        self.rigid
            .get(i)
            .is_some_and(|[lower, upper]| (on == Piece::Lower && *lower) || (on == Piece::Upper && *upper))
    }

    /// Whether contact `i` has a stop.
    #[inline]
    pub(crate) fn any(&self, i: usize) -> bool {
        self.rigid.get(i).is_some_and(|[lower, upper]| *lower || *upper)
    }

    /// All stops.
    fn exits(&self) -> impl Iterator<Item = Exit> + '_ {
        self.rigid.iter().enumerate().flat_map(|(contact, rigid)| {
            let ways = [(rigid[0], Piece::Lower), (rigid[1], Piece::Upper)];
            ways.into_iter().filter(|(rigid, _)| *rigid).map(move |(_, to)| Exit { contact, to })
        })
    }
}

impl Locator {
    /// No contact may lie beyond a stop at the start of a step.
    pub(crate) fn check_stops(&self, t: f64) -> Result<(), IntegrateError> {
        for exit in self.stops.exits() {
            let c = &self.start[exit.contact];
            let d = exit.distance(Piece::Gap, c, 1.0);
            // Impacts far from time zero are met no closer than the clock tells.
            let rounding = ROUNDING * (c.deflection.abs() + d.rate.abs() * t.abs());
            if d.value < -self.slack(exit.contact, c).max(rounding) {
                return Err(IntegrateError::BeyondStop { t, contact: exit.contact, depth: -d.value });
            }
        }
        Ok(())
    }

    /// Impacts of the contacts that met their stops at the end of the step.
    #[inline]
    pub(crate) fn strike_at_end<M: Model + ?Sized, V: Vector>(
        &mut self,
        e: &mut Engine<'_, M, V>,
        crossings: &mut Vec<Crossing>,
    ) -> Result<(), IntegrateError> {
        self.stops.met = crossings.iter().any(|c| c.rebounds);
        if !self.stops.met {
            return Ok(());
        }
        let (t, (q, v)) = (e.t1, halves(&e.y1));
        self.stops.v.copy_from_slice(v);
        self.strike(e.model, &e.u1, q, &mut e.contacts, crossings, t)?;
        self.land(t, &e.contacts, crossings)?;
        // The step ends before its impacts.
        e.contacts_at_end();
        Ok(())
    }

    /// A contact on its stop at the start of a step would move into it: it rebounds or, if it does not get away, rests.
    pub(crate) fn strike_at_start<M: Model + ?Sized, V: Vector>(
        &mut self,
        e: &mut Engine<'_, M, V>,
        exit: Exit,
        crossings: &mut Vec<Crossing>,
    ) -> Result<(), IntegrateError> {
        let t = e.t;
        self.still[exit.contact] += 1;
        if self.still[exit.contact] > Self::STILL {
            return Err(IntegrateError::RestsOnStop { t, contact: exit.contact });
        }
        e.contacts_at_start();
        if exit.distance(Piece::Gap, &e.contacts[exit.contact], 1.0).rate < 0.0 {
            let (q, v) = halves(&e.y);
            self.stops.v.copy_from_slice(v);
            crossings.push(Crossing { contact: exit.contact, from: Piece::Gap, to: exit.to, rebounds: true });
            self.strike(e.model, &e.u_stage, q, &mut e.contacts, crossings, t)?;
            crossings.clear();
            self.stops.met = true;
            self.rebound(e);
        }
        Ok(())
    }

    /// Puts the velocities behind the impacts into the start of the next step, which may be as long as is said.
    #[inline]
    pub(crate) fn rebound<M: Model + ?Sized, V: Vector>(&mut self, e: &mut Engine<'_, M, V>) -> f64 {
        if self.stops.met {
            let n = self.stops.v.len();
            e.y.slice_mut()[n..].copy_from_slice(&self.stops.v);
            e.contacts_at_start();
            self.start.copy_from_slice(&e.contacts);
            self.stops.met = false;
            return (LONGER * self.stops.flew).max(SHORTEST * RESOLUTION * e.t.abs());
        }
        f64::INFINITY
    }

    /// Velocities behind the impacts, one after the other, until no contact on its stop approaches it. Impacts that follow are added.
    fn strike<M: Model + ?Sized>(
        &mut self,
        model: &M,
        u: &[f64],
        q: &[f64],
        contacts: &mut [Contact],
        crossings: &mut Vec<Crossing>,
        t: f64,
    ) -> Result<(), IntegrateError> {
        let approach = |c: &Crossing, contacts: &[Contact]| {
            -Exit { contact: c.contact, to: c.to }.distance(Piece::Gap, &contacts[c.contact], 1.0).rate
        };
        let mut fastest = 0.0f64;
        for crossing in crossings.iter().filter(|c| c.rebounds) {
            fastest = fastest.max(approach(crossing, contacts));
            model.impact(crossing.contact, crossing.to, u, q, &mut self.stops.v);
        }
        loop {
            model.contact(u, q, &self.stops.v, contacts);
            let next = self.stops.exits().find(|exit| {
                let met =
                    crossings.iter().any(|c| c.rebounds && (c.contact, c.to) == (exit.contact, exit.to));
                let c = &contacts[exit.contact];
                let d = exit.distance(Piece::Gap, c, 1.0);
                d.rate < -APPROACHES * fastest && (met || d.value <= self.slack(exit.contact, c))
            });
            let Some(Exit { contact, to }) = next else { return Ok(()) };
            if crossings.len() >= self.stops.room() {
                return Err(IntegrateError::EdgeStall { t, contact });
            }
            let crossing = Crossing { contact, from: Piece::Gap, to, rebounds: true };
            fastest = fastest.max(approach(&crossing, contacts));
            model.impact(contact, to, u, q, &mut self.stops.v);
            crossings.push(crossing);
        }
    }

    /// Notes how high each contact flew since its last impact: one that no longer leaves its stop by what edges are met to rests there.
    fn land(&mut self, t: f64, behind: &[Contact], crossings: &[Crossing]) -> Result<(), IntegrateError> {
        self.stops.flew = f64::INFINITY;
        for &Crossing { contact, to, .. } in crossings.iter().filter(|c| c.rebounds) {
            let slack = self.slack(contact, &behind[contact]);
            let flight = &mut self.stops.flights[contact];
            if t > flight.since {
                self.stops.flew = self.stops.flew.min(t - flight.since);
            }
            if flight.lands(t, Exit { contact, to }.distance(Piece::Gap, &behind[contact], 1.0).rate, slack) {
                return Err(IntegrateError::RestsOnStop { t, contact });
            }
        }
        Ok(())
    }
}
