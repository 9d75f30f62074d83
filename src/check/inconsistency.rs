//! The findings of a check.

use crate::excitation::Side;

/// An inconsistency between two parts of a model. Its text names the part, the values and the requirement.
///
/// ```
/// use gear_dynamics::{check::{Inconsistency, check_model}, contact::Piece, Model, State};
/// use gear_dynamics::model::{Jacobian, Offers};
/// struct Wrong;
/// impl Model for Wrong {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) { a[0] = -q[0]; }
///     fn offers(&self) -> Offers<'_> { Offers { jacobian: true, ..Offers::default() } }
///     fn jacobian(&self, _: Option<&[Piece]>, _: &[f64], _: &[f64], _: &[f64], out: &mut Jacobian) {
///         out.q[(0, 0)] = 1.0; // correct: -1
///     }
/// }
/// let findings = check_model(&Wrong, &State::new(0.0, &[1.0], &[0.5]));
/// assert_eq!(findings.len(), 1);
/// assert!(matches!(findings[0], Inconsistency::Jacobian { row: 0, column: 0, .. }));
/// let text = findings[0].to_string();
/// assert!(text.starts_with("jacobian: row 0, column 0 (coordinates, then velocities) is 1"));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Inconsistency {
    /// A drive that is NaN, an acceleration that is NaN or infinite, or a contact with such a deflection,
    /// rate or force or with a NaN edge.
    NotFinite {
        /// "drive", "acceleration" or "contact".
        what: &'static str,
        /// Index of the drive, the acceleration or the contact.
        index: usize,
        /// Time.
        t: f64,
    },
    /// A part that [`Model::offers`](crate::Model::offers) declares and the model does not implement, or that
    /// the model implements and does not declare.
    Offers {
        /// Name of the method: "accel_on_pieces", "jacobian" or "impact".
        method: &'static str,
        /// Whether the part is declared.
        declared: bool,
    },
    /// [`Offers::stops`](crate::model::Offers::stops) lists more contacts than the model has.
    StopsOfNoContact {
        /// Length of the list.
        stops: usize,
        /// Number of contacts.
        contacts: usize,
    },
    /// An entry of the Jacobian differs from finite differences of `accel`.
    Jacobian {
        /// Row: index of the acceleration.
        row: usize,
        /// Column: coordinates, then velocities.
        column: usize,
        /// Value of the model.
        given: f64,
        /// Value by differences.
        differences: f64,
    },
    /// `accel_on_pieces` on the pieces on which the contacts stand differs from `accel`.
    Pieces {
        /// Index of the acceleration.
        component: usize,
        /// Value of `accel_on_pieces`.
        on_pieces: f64,
        /// Value of `accel`.
        accel: f64,
    },
    /// The rate of a contact is not the time derivative of its deflection along the motion.
    ContactRate {
        /// Index of the contact.
        contact: usize,
        /// Value of the model.
        given: f64,
        /// Value by differences.
        differences: f64,
    },
    /// The rate of an edge of a contact is not the time derivative of the edge.
    EdgeRate {
        /// Index of the contact.
        contact: usize,
        /// Value of the model.
        given: f64,
        /// Value by differences.
        differences: f64,
    },
    /// `accel_on_pieces` returns the values of `accel`, although a contact was given the piece beyond its
    /// edge.
    PiecesIgnored {
        /// Index of the contact.
        contact: usize,
        /// Deflection at the edge.
        edge: f64,
    },
    /// The acceleration has neither a kink nor a jump at an edge of a contact.
    Kink {
        /// Index of the contact.
        contact: usize,
        /// Deflection at the edge.
        edge: f64,
    },
    /// After an impact on a rigid stop the contact still approaches the stop, or leaves it faster than it
    /// approached it.
    Rebound {
        /// Index of the contact.
        contact: usize,
        /// Deflection at the stop.
        edge: f64,
        /// Speed towards the stop before the impact, relative to the stop.
        approach: f64,
        /// Speed away from the stop after the impact, relative to the stop.
        leaves: f64,
    },
    /// The acceleration has a kink or a jump where no contact has an edge.
    UndeclaredKink {
        /// Index of the acceleration.
        component: usize,
        /// Coordinates at the kink.
        q: Vec<f64>,
    },
    /// The acceleration has a kink at an edge of a contact, but the force of the contact has none.
    NoForce {
        /// Index of the contact.
        contact: usize,
        /// Deflection at the edge.
        edge: f64,
    },
    /// The changes of force and acceleration at an edge of a contact have another ratio than at its other
    /// edge, or another ratio for the jump than for the slope.
    Force {
        /// Index of the contact.
        contact: usize,
        /// Deflection at the edge.
        edge: f64,
        /// Change of the force of the contact.
        given: f64,
        /// Change of the force that corresponds to the change of the acceleration.
        expected: f64,
    },
    /// The lower edge of a contact lies above its upper edge.
    NegativeGap {
        /// Index of the contact.
        contact: usize,
        /// Lower edge.
        lower: f64,
        /// Upper edge.
        upper: f64,
    },
    /// `next_edge` returns an instant that is not later than its argument.
    DriveEdgeBehind {
        /// Argument of `next_edge`.
        t: f64,
        /// Result of `next_edge`.
        edge: f64,
    },
    /// A drive jumps at an instant that `next_edge` does not return.
    UnannouncedJump {
        /// Index of the drive.
        drive: usize,
        /// Approximate instant of the jump.
        t: f64,
    },
    /// A drive does not have the value of the requested side at a drive edge: it ignores `side`.
    SideIgnored {
        /// Index of the drive.
        drive: usize,
        /// The drive edge.
        t: f64,
        /// The side that was requested.
        side: Side,
    },
    /// `redrive` writes another value than `drive`.
    Redrive {
        /// Index of the drive.
        drive: usize,
        /// The instant.
        t: f64,
        /// Value by `redrive`.
        found: f64,
        /// Value by `drive`.
        expected: f64,
    },
    /// The lengths of the typical state do not fit the model.
    State {
        /// Numbers of coordinates and velocities of the typical state.
        given: [usize; 2],
        /// Degrees of freedom of the model.
        dof: usize,
    },
    /// A period that is not positive and finite.
    BadPeriod {
        /// Value of the period.
        period: f64,
    },
    /// An acceleration, or the distance of a contact from an edge, does not repeat with the period. The
    /// finding with the largest deviation is reported, accelerations first.
    Period {
        /// "acceleration", or "gap" for the distance from an edge.
        what: &'static str,
        /// Index of the acceleration. For a distance: twice the index of the contact, plus 1 for its upper
        /// edge.
        index: usize,
        /// Time t.
        t: f64,
        /// Value at t.
        first: f64,
        /// Value one period later.
        second: f64,
    },
}
