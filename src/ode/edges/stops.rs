//! Rigid stops: velocities after impacts, flights between impacts, and contacts that come to rest.

use crate::model::Model;
use crate::ode::edges::collisions::{Collisions, stops};
use crate::ode::edges::exit::Exit;
use crate::ode::stepping::vector::Vector;

/// Allowed distance beyond a stop at the start of a step, as a share of |d| + |d' t| with the distance rate
/// d' `[1]`.
pub(crate) const ROUNDING: f64 = 1e-12;

/// Maximum length of the step after an impact, in durations of the flight before it. The limit is necessary
/// because roots are accurate relative to the step.
pub(crate) const LONGER: f64 = 4.0;

/// Minimum value of this limit, in units of the resolution of the time.
pub(crate) const SHORTEST: f64 = 1e4;

/// Maximum number of consecutive low flights. With one more the contact is at rest.
const LOW: u8 = 4;

/// The flight of a contact since its last impact.
#[derive(Clone, Copy)]
pub(crate) struct Flight {
    /// Time of the last impact.
    pub(crate) since: f64,
    /// Speed relative to the stop after the last impact.
    pub(crate) speed: f64,
    /// Number of consecutive low flights.
    pub(crate) low: u8,
    /// Height of the highest flight.
    pub(crate) highest: f64,
}

impl Flight {
    /// No impact yet.
    pub(crate) const NONE: Flight =
        Flight { since: f64::NEG_INFINITY, speed: f64::NAN, low: 0, highest: 0.0 };

    /// Starts a new flight after an impact at `t` that was passed on by others: the contact did not fall onto
    /// its stop.
    pub(crate) fn leaves(&mut self, t: f64, speed: f64) {
        (self.since, self.speed) = (t, speed);
    }

    /// Ends the flight with an impact at `t`, after which the contact leaves the stop at `speed`. Returns
    /// whether the contact is at rest: more than `LOW` consecutive flights were low. A flight is low if its
    /// height is at most `slack`, or at most the rounding of the highest flight.
    pub(crate) fn lands(&mut self, t: f64, speed: f64, slack: f64) -> bool {
        // Height of a parabola with initial speed v and duration T: v T/4.
        let height = 0.25 * self.speed * (t - self.since);
        self.highest = self.highest.max(height);
        self.low = match self.since == t {
            true => self.low,
            false if height <= slack.max(f64::EPSILON * self.highest) => self.low + 1,
            false => 0,
        };
        self.leaves(t, speed);
        self.low > LOW
    }
}

/// The rigid stops of one run. All lists are empty for a model without rigid stops.
pub(crate) struct Stops {
    /// Whether the lower and the upper edge of each contact are rigid stops.
    pub(crate) rigid: Vec<[bool; 2]>,
    /// Velocities after the impacts at the end of the step; valid if `met`.
    pub(crate) v: Vec<f64>,
    /// Whether the step ends with an impact.
    pub(crate) met: bool,
    /// The impacts at one instant.
    pub(crate) collisions: Collisions,
    /// The current flight of each contact.
    pub(crate) flights: Vec<Flight>,
    /// Duration of the shortest flight that ended with the last impacts. The next flight has the same order
    /// of magnitude.
    pub(crate) flew: f64,
}

impl Stops {
    /// The rigid stops of `model`; none if edges are not located.
    pub(crate) fn new(model: &dyn Model, locate: bool) -> Self {
        let rigid = if locate { model.offers().rigid_edges(model.contacts()) } else { Vec::new() };
        let contacts = rigid.len();
        Stops {
            collisions: Collisions::new(&rigid, model.dof()),
            v: vec![0.0; if contacts > 0 { model.dof() } else { 0 }],
            met: false,
            flew: f64::INFINITY,
            flights: vec![Flight::NONE; contacts],
            rigid,
        }
    }

    /// Writes the velocities after the impacts at the end of the step into a state, if there are any.
    pub(crate) fn write<V: Vector>(&self, y: &mut V) {
        if self.met {
            let n = self.v.len();
            y.slice_mut()[n..].copy_from_slice(&self.v);
        }
    }
    /// Maximum number of stops that are struck at one instant.
    pub(crate) fn room(&self) -> usize {
        2 * self.rigid.len()
    }

    /// Whether contact `i` has a rigid stop.
    #[inline]
    pub(crate) fn any(&self, i: usize) -> bool {
        self.rigid.get(i).is_some_and(|[lower, upper]| *lower || *upper)
    }

    /// All rigid stops, as exits of their contacts.
    pub(crate) fn exits(&self) -> impl Iterator<Item = Exit> + '_ {
        stops(&self.rigid)
    }
}
