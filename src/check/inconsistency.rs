//! What a check may find.

/// Something that does not fit together in a model.
///
/// ```
/// use gear_dynamics::{check::{Inconsistency, check_model}, Model, State};
/// struct Wrong;
/// impl Model for Wrong {
///     fn dof(&self) -> usize { 1 }
///     fn accel(&self, _: &[f64], q: &[f64], _: &[f64], a: &mut [f64]) { a[0] = -q[0]; }
///     fn jacobian(&self, _: Option<&[gear_dynamics::contact::Piece]>, _: &[f64], _: &[f64], _: &[f64], out: &mut gear_dynamics::model::Jacobian) -> bool {
///         out.q[(0, 0)] = 1.0; // the sign is wrong
///         true
///     }
/// }
/// let findings = check_model(&Wrong, &State::new(0.0, &[1.0], &[0.5]));
/// assert_eq!(findings.len(), 1);
/// assert!(matches!(findings[0], Inconsistency::Jacobian { row: 0, column: 0, .. }));
/// assert!(findings[0].to_string().starts_with("jacobian: row 0, column 0 (coordinates, then velocities) is 1"));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Inconsistency {
    /// A drive, an acceleration or a contact that is not a number.
    NotFinite {
        /// What it is.
        what: &'static str,
        /// Its index.
        index: usize,
        /// When.
        t: f64,
    },
    /// An entry of the Jacobian that differences contradict; columns are coordinates, then velocities.
    Jacobian {
        /// Row.
        row: usize,
        /// Column.
        column: usize,
        /// What the model says.
        given: f64,
        /// What differences say.
        differences: f64,
    },
    /// The acceleration on the pieces where the contacts stand differs from the acceleration itself.
    Pieces {
        /// Component.
        component: usize,
        /// With pieces held.
        held: f64,
        /// Without.
        free: f64,
    },
    /// The rate of a contact is not the derivative of its deflection along the motion.
    ContactRate {
        /// Which contact.
        contact: usize,
        /// What the model says.
        given: f64,
        /// What differences say.
        differences: f64,
    },
    /// An edge of a contact moves otherwise than its rate says.
    EdgeRate {
        /// Which contact.
        contact: usize,
        /// What the model says.
        given: f64,
        /// What differences say.
        differences: f64,
    },
    /// The acceleration held on other pieces is the acceleration itself.
    PiecesIgnored {
        /// Which contact was held on the piece beyond its edge.
        contact: usize,
        /// That edge.
        edge: f64,
    },
    /// The acceleration neither bends nor jumps where the contact has an edge.
    Kink {
        /// Which contact.
        contact: usize,
        /// The deflection at the edge that was looked at.
        edge: f64,
    },
    /// After an impact on a rigid stop the contact still approaches it, or leaves it faster than it came.
    Rebound {
        /// Which contact.
        contact: usize,
        /// The deflection at the stop.
        edge: f64,
        /// Speed over the stop before the impact.
        approach: f64,
        /// Speed away from it behind the impact.
        leaves: f64,
    },
    /// The acceleration bends or jumps where no contact has an edge.
    UntoldKink {
        /// Component.
        component: usize,
        /// The coordinates there.
        q: Vec<f64>,
    },
    /// The acceleration bends at the edge of a contact, and its force does not.
    NoForce {
        /// Which contact.
        contact: usize,
        /// The edge.
        edge: f64,
    },
    /// At one edge of a contact its force and the acceleration change in another proportion than at the other, or jump otherwise than they
    /// bend.
    Force {
        /// Which contact.
        contact: usize,
        /// The edge.
        edge: f64,
        /// Change of the force told.
        given: f64,
        /// The change that the acceleration asks for.
        expected: f64,
    },
    /// A contact whose lower edge lies above its upper one.
    NegativeGap {
        /// Which contact.
        contact: usize,
        /// Its lower edge.
        lower: f64,
        /// Its upper edge.
        upper: f64,
    },
    /// An edge of the drives that does not lie ahead.
    EdgeBehind {
        /// Asked at.
        t: f64,
        /// The answer.
        edge: f64,
    },
    /// A drive jumps where no edge is announced.
    UnannouncedJump {
        /// Which drive.
        drive: usize,
        /// Close to.
        t: f64,
    },
    /// The typical state does not fit the model.
    State {
        /// Coordinates and velocities given.
        given: [usize; 2],
        /// Degrees of freedom.
        dof: usize,
    },
    /// A period that is not positive and finite.
    BadPeriod {
        /// What it was.
        period: f64,
    },
    /// An acceleration, or how far a contact is from an edge, does not repeat with the period; of all that does not, what is off the most.
    Period {
        /// What it is.
        what: &'static str,
        /// Its index.
        index: usize,
        /// At this time.
        t: f64,
        /// Its value there.
        first: f64,
        /// A period later.
        second: f64,
    },
}
