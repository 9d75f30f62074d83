//! Rigid stops: impacts at the end of a step, and contacts that come to rest.

use crate::contact::piece::Piece;
use crate::model::equations::Model;
use crate::model::rigid_stops::rigid_edges;
use crate::ode::edges::exit::Exit;

/// Impacts at one instant, per contact, before they count as without end.
const ROUNDS: usize = 16;

/// A contact still approaches its stop, after an impact, at more than this share of the greatest speed of approach.
pub(crate) const APPROACHES: f64 = 1e-9;

/// A start may lie beyond a stop by this share of what its distance is made of.
pub(crate) const ROUNDING: f64 = 1e-12;

/// A step behind an impact is at most this many flights long: roots are known to a share of the step.
pub(crate) const LONGER: f64 = 4.0;

/// ... or this many times what the clock resolves.
pub(crate) const SHORTEST: f64 = 1e4;

/// Flights in a row no higher than an edge is met by, before a contact is said to rest.
const LOW: u8 = 4;

/// The last impact of a contact.
#[derive(Clone, Copy)]
pub(crate) struct Flight {
    pub(crate) since: f64,
    /// Speed over the stop at which it left.
    pub(crate) speed: f64,
    /// Flights in a row that were too low.
    pub(crate) low: u8,
    /// Height of the highest flight.
    pub(crate) highest: f64,
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
    pub(crate) rigid: Vec<[bool; 2]>,
    /// Velocities behind the impacts at the end of the step, if there are any.
    pub(crate) v: Vec<f64>,
    pub(crate) met: bool,
    pub(crate) flights: Vec<Flight>,
    /// The shortest flight that has just ended: the next is no longer by orders.
    pub(crate) flew: f64,
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
    pub(crate) fn exits(&self) -> impl Iterator<Item = Exit> + '_ {
        self.rigid.iter().enumerate().flat_map(|(contact, rigid)| {
            let ways = [(rigid[0], Piece::Lower), (rigid[1], Piece::Upper)];
            ways.into_iter().filter(|(rigid, _)| *rigid).map(move |(_, to)| Exit { contact, to })
        })
    }
}
