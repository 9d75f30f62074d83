//! Errors of parameters: the value, what it was, what is allowed.

pub(crate) mod check;

use thiserror::Error;

/// The reason why a parameter is not allowed.
///
/// Physical quantities must lie in [-1e50, 1e50], divisors (an inertia, a radius, a period, a frequency) in
/// [1e-50, 1e50]. Products of several of them then remain far below the largest `f64`.
///
/// ```
/// use gear_dynamics::{Backlash, ParameterError};
/// let error = Backlash::new(-1e-5).unwrap_err();
/// assert_eq!(error, ParameterError::Negative { name: "half backlash b".into(), value: -1e-5 });
/// assert_eq!(error.to_string(), "half backlash b is -1e-5: it must not be negative");
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ParameterError {
    /// The value is a NaN or an infinity.
    #[error("{name} is {value:?}: it must be a finite number")]
    NotFinite {
        /// Name of the parameter.
        name: String,
        /// The value given.
        value: f64,
    },
    /// The value is zero or negative; it must be positive.
    #[error("{name} is {value:?}: it must be positive")]
    NotPositive {
        /// Name of the parameter.
        name: String,
        /// The value given.
        value: f64,
    },
    /// The value is negative; it must be zero or positive.
    #[error("{name} is {value:?}: it must not be negative")]
    Negative {
        /// Name of the parameter.
        name: String,
        /// The value given.
        value: f64,
    },
    /// The value is outside its range.
    #[error("{name} is {value:?}: it must lie in {allowed}")]
    OutOfRange {
        /// Name of the parameter.
        name: String,
        /// The value given.
        value: f64,
        /// The range allowed, as an interval: `[0, 1)`.
        allowed: &'static str,
    },
    /// The value contradicts a condition that is not an interval: that of a neighbour in a list, of another
    /// setting, a whole number.
    #[error("{name} is {value:?}: it must {must}")]
    Wrong {
        /// Name of the parameter.
        name: String,
        /// The value given.
        value: f64,
        /// The condition, which begins with a verb: `be above 60.0, the speed before it`.
        must: String,
    },
    /// Bounds are reversed or equal, or the value lies outside them.
    #[error(
        "{name} has the bounds {low:?} .. {high:?} and the value {value:?}: the lower bound must be smaller, and \
         the value must lie between them"
    )]
    Bounds {
        /// Name of the parameter.
        name: String,
        /// Its value.
        value: f64,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
    /// A list is empty.
    #[error("{name} is empty: at least {min} entries are needed")]
    Empty {
        /// Name of the list.
        name: String,
        /// Minimum length.
        min: usize,
    },
    /// A list has the wrong length.
    #[error("{name} has {found} entries: {expected} are needed")]
    Length {
        /// Name of the list.
        name: String,
        /// Required length.
        expected: usize,
        /// Length given.
        found: usize,
    },
    /// An observer was made for a model of another shape than that of the run.
    #[error(
        "an observer of a model with {} coordinates and {} contacts cannot follow one with {} coordinates and {} \
         contacts: make the observer of the model of the run", .own[0], .own[1], .other[0], .other[1]
    )]
    OtherModel {
        /// Numbers of coordinates and of contacts of the model for which the observer was made.
        own: [usize; 2],
        /// The same two numbers of the model that the run integrates.
        other: [usize; 2],
    },
    /// A body that a machine does not name, or that does not turn evenly.
    #[error("the machine names no body \"{body}\" that turns evenly; there are: {known}")]
    NoSuchBody {
        /// The name given.
        body: String,
        /// The names of all bodies that turn evenly.
        known: String,
    },
    /// A name is given twice, or stands twice in a list.
    #[error("there is more than one \"{name}\": names must be different")]
    Twice {
        /// The name that occurs twice.
        name: String,
    },
    /// A count (of teeth, gears, samples) is below its minimum.
    #[error("{name} is {value}: at least {min} are needed")]
    TooFew {
        /// Name of the count.
        name: String,
        /// The count given.
        value: usize,
        /// Minimum count.
        min: usize,
    },
    /// A count exceeds its maximum, which limits memory and time.
    #[error("{name} is {value}: at most {max} are allowed")]
    TooMany {
        /// Name of the count.
        name: String,
        /// The count given; `usize::MAX` if it exceeds the range of `usize`.
        value: usize,
        /// Maximum count.
        max: usize,
    },
    /// A computed quantity exceeds the largest `f64`.
    #[error("{name} overflows: the largest of the values it is computed from is {value:?}")]
    Overflow {
        /// Name of the computed quantity.
        name: String,
        /// The value of largest magnitude among those it is computed from.
        value: f64,
    },
    /// A matrix does not determine an unknown.
    #[error(
        "the matrix is singular: its product with a vector that changes unknown {unknown} is 0; fix this unknown, or \
         leave it out"
    )]
    Singular {
        /// Index of the unknown, from 0.
        unknown: usize,
    },
    /// A ring has an odd number of ordinary external meshes and cannot turn.
    #[error(
        "a closed ring of {gears} ordinary external meshes cannot turn: each mesh reverses the rotation, so \
         an odd number locks; use an even number of gears, or Ring::as_printed for the equations of Yao \
         2020, in which one mesh of an odd ring does not reverse the rotation"
    )]
    OddRing {
        /// Number of gears in the ring.
        gears: usize,
    },
    /// A wave does not have the period that its shape states.
    #[error("{name} does not repeat after {period:?} rad")]
    NotPeriodic {
        /// Name of the wave.
        name: String,
        /// Required period `[rad]`.
        period: f64,
    },
    /// A value contradicts others that were given.
    #[error("{name} is {found:?}: it must be {expected:?}")]
    Inconsistent {
        /// Name of the value.
        name: String,
        /// The value given.
        found: f64,
        /// Required value.
        expected: f64,
    },
    /// The model has no drive with this slot.
    #[error("drive slot {slot} does not exist: the model has {drives} drives; slots count from 0")]
    NoSuchSlot {
        /// The slot given, from 0.
        slot: usize,
        /// Number of drives of the model.
        drives: usize,
    },
    /// The model has no named constants.
    #[error("the model has no named constants: build it as a `Machine`")]
    NoConstants,
    /// The shape has no constant with this name.
    #[error("no constant \"{name}\"; there are: {known}")]
    NoSuchConstant {
        /// The name given.
        name: String,
        /// The names of all constants of the shape.
        known: String,
    },
    /// A setting that this call requires was not given.
    #[error("{name} is not set")]
    NotSet {
        /// Name of the setting.
        name: &'static str,
    },
    /// A constant has no value.
    #[error("constant \"{name}\" has no value")]
    MissingConstant {
        /// Name of the constant.
        name: String,
    },
    /// A constant has no slot among the drives.
    #[error(
        "constant \"{name}\" has no slot among the drives: the algebra uses values derived from it, or it is \
         the speed of the angle (see VaryingSpeed)"
    )]
    NotADrive {
        /// Name of the constant.
        name: String,
    },
    /// White noise on these slots has no meaning.
    #[error("slot {slot} cannot take white noise: {why}")]
    NoWhiteNoise {
        /// The first slot of the source.
        slot: usize,
        /// What does not allow it.
        why: String,
    },
    /// The model has no contact with this index; for a shape, its algebra evaluates one beyond its `Size`.
    #[error("contact {contact} does not exist: the model has {contacts} contacts; contacts count from 0")]
    NoSuchContact {
        /// Index of the contact, from 0.
        contact: usize,
        /// Number of contacts of the model.
        contacts: usize,
    },
    /// A contact law lacks the flank that a positive load requires.
    #[error("the contact law has no {flank} flank: a positive load requires it")]
    NoFlank {
        /// "lower" or "upper".
        flank: &'static str,
    },
    /// The algebra evaluates a contact law with edges, but the contact itself has none.
    #[error(
        "the algebra evaluates the law of contact {contact} with edges, but contact({contact}) returns none: \
         solvers cannot locate its crossings"
    )]
    NoEdges {
        /// Index of the contact, from 0.
        contact: usize,
    },
    /// A setting was given to a call that does not read it.
    #[error("{name} is set, but {by} does not read it: leave it out")]
    Unread {
        /// Name of the setting.
        name: &'static str,
        /// What does not read it.
        by: &'static str,
    },
    /// There is no channel with this name.
    #[error("there is no channel \"{name}\"; there are: {known}")]
    NoSuchChannel {
        /// The name given.
        name: String,
        /// The names of all channels that there are.
        known: String,
    },
}
