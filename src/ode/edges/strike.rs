//! Impacts on rigid stops: velocities jump, contacts stay in their gaps.

use crate::contact::{Contact, Piece};
use crate::model::Model;
use crate::ode::edges::collisions::Next;
use crate::ode::edges::exit::Exit;
use crate::ode::edges::locate::Locator;
use crate::ode::edges::stops::{LONGER, ROUNDING, SHORTEST};
use crate::ode::integrate_error::IntegrateError;
use crate::ode::step::Crossing;
use crate::ode::stepping::control::RESOLUTION;
use crate::ode::stepping::ends::{Ends, halves};
use crate::ode::stepping::vector::Vector;

impl Locator {
    /// Checks that no contact lies beyond a rigid stop at the start of a step.
    ///
    /// # Errors
    /// [`IntegrateError::BeyondStop`].
    pub(crate) fn check_stops(&self, t: f64) -> Result<(), IntegrateError> {
        for exit in self.stops.exits() {
            let c = &self.start[exit.contact];
            let d = exit.distance(Piece::Gap, c, 1.0);
            // Rounding of a large time limits the accuracy of the instant of an impact.
            let rounding = ROUNDING * (c.deflection.abs() + d.rate.abs() * t.abs());
            if d.value < -self.slack(exit.contact, c).max(rounding) {
                return Err(IntegrateError::BeyondStop { t, contact: exit.contact, depth: -d.value });
            }
        }
        Ok(())
    }

    /// Computes the impacts of all contacts that reach their rigid stops at the end of the step.
    #[inline]
    pub(crate) fn strike_at_end<V: Vector>(
        &mut self,
        e: &mut Ends<'_, V>,
        crossings: &mut Vec<Crossing>,
    ) -> Result<(), IntegrateError> {
        self.stops.met = crossings.iter().any(|c| c.rebounds);
        if !self.stops.met {
            return Ok(());
        }
        let (t, (q, v)) = (e.t1, halves(&e.y1));
        self.stops.v.copy_from_slice(v);
        self.strike(e.model, e.nodes.end(), q, &mut e.contacts, crossings, t)?;
        self.land(t, &e.contacts, crossings)?;
        // The step ends with the velocities before the impacts.
        e.contacts_at_end();
        Ok(())
    }

    /// Treats a contact that is on its rigid stop at the start of a step and would move beyond it although it
    /// does not approach it.
    ///
    /// # Errors
    /// [`IntegrateError::RestsOnStop`] after more than `STILL` calls for one contact at one instant.
    pub(crate) fn presses(&mut self, t: f64, contact: usize) -> Result<(), IntegrateError> {
        self.still[contact] += 1;
        if self.still[contact] > Self::STILL {
            return Err(IntegrateError::RestsOnStop { t, contact });
        }
        Ok(())
    }

    /// Writes the velocities after the impacts into the start of the next step, if there were impacts.
    /// Returns the maximum length of that step; infinite without impacts.
    #[inline]
    pub(crate) fn rebound<V: Vector>(&mut self, e: &mut Ends<'_, V>) -> f64 {
        if self.stops.met {
            self.stops.write(&mut e.y);
            e.contacts_at_start();
            self.start.copy_from_slice(&e.contacts);
            self.stops.met = false;
            return (LONGER * self.stops.flew).max(SHORTEST * RESOLUTION * e.t.abs());
        }
        f64::INFINITY
    }

    /// Computes the velocities after all impacts of the instant; see
    /// [`collisions`](crate::ode::edges::collisions). Of the rebounds in `crossings`, those of stops that are
    /// struck remain, and stops that are struck besides are added, each once.
    ///
    /// # Errors
    /// [`IntegrateError::TooManyImpacts`].
    fn strike(
        &mut self,
        model: &dyn Model,
        u: &[f64],
        q: &[f64],
        contacts: &mut [Contact],
        crossings: &mut Vec<Crossing>,
        t: f64,
    ) -> Result<(), IntegrateError> {
        let mut collisions = std::mem::take(&mut self.stops.collisions);
        collisions.begin();
        let mut end = Ok(());
        loop {
            model.contact(u, q, &self.stops.v, contacts);
            let next = collisions.next(contacts, |exit, c| {
                let met = crossings.iter().any(|c| c.rebounds && Exit::of(c) == exit);
                met || exit.distance(Piece::Gap, c, 1.0).value <= self.slack(exit.contact, c)
            });
            if next == Next::Over {
                break;
            }
            if let (Some(limit), Some(exit)) = (collisions.exceeded(), collisions.chosen().next()) {
                end = Err(IntegrateError::TooManyImpacts { t, contact: exit.contact, limit });
                break;
            }
            collisions.resolve(model, next, [u, q], &mut self.stops.v, contacts);
        }
        let is = |c: &Crossing, exit: Exit| c.rebounds && Exit::of(c) == exit;
        crossings.retain(|c| !c.rebounds || collisions.struck().any(|exit| is(c, exit)));
        for exit in collisions.struck() {
            if !crossings.iter().any(|c| is(c, exit)) {
                crossings.push(exit.crossing(Piece::Gap, true));
            }
        }
        self.stops.collisions = collisions;
        end
    }

    /// Ends the flight of each contact with an impact. `after`: the contacts after the impacts.
    ///
    /// # Errors
    /// [`IntegrateError::RestsOnStop`] for a contact whose flights stay within the slack.
    fn land(&mut self, t: f64, after: &[Contact], crossings: &[Crossing]) -> Result<(), IntegrateError> {
        self.stops.flew = f64::INFINITY;
        for exit in crossings.iter().filter(|c| c.rebounds).map(Exit::of) {
            let contact = exit.contact;
            let slack = self.slack(contact, &after[contact]);
            let speed = exit.distance(Piece::Gap, &after[contact], 1.0).rate;
            let flight = &mut self.stops.flights[contact];
            if t > flight.since {
                self.stops.flew = self.stops.flew.min(t - flight.since);
            }
            if !self.stops.collisions.arrives(exit) {
                flight.leaves(t, speed);
            } else if flight.lands(t, speed, slack) {
                return Err(IntegrateError::RestsOnStop { t, contact });
            }
        }
        Ok(())
    }
}
