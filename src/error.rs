//! Errors of parameters: the value, what it was, what is allowed.

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
        /// The range allowed.
        allowed: &'static str,
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
    #[error("the matrix is singular: it does not determine unknown {unknown}")]
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
    /// Relative coordinates or rates do not satisfy the closure of the ring.
    #[error("{name} is {found:?}: the closure of the ring requires {expected:?}")]
    Inconsistent {
        /// Name of the sum.
        name: String,
        /// Value of the sum.
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
    /// The shape has no constant with this name.
    #[error("no constant \"{name}\"; there are: {known}")]
    NoSuchConstant {
        /// The name given.
        name: String,
        /// The names of all constants of the shape.
        known: String,
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
    /// The model has no channel with this name.
    #[error("there is no channel \"{name}\"; the model has: {known}")]
    NoSuchChannel {
        /// The name given.
        name: String,
        /// The names of all channels of the model.
        known: String,
    },
}

/// Checks of parameters, for all constructors and settings.
pub(crate) mod check {
    use crate::error::ParameterError as E;

    type Checked = Result<f64, E>;

    /// Maximum number of values in one list: 512 MiB of `f64`.
    pub(crate) const NUMBERS: usize = 1 << 26;
    /// Maximum order of a Fourier series. All orders are summed at every evaluation.
    pub(crate) const ORDERS: usize = 10_000;
    /// Maximum number of periods of a wave in a turn: beyond it, rounding of the phase spoils slopes.
    pub(crate) const TEETH: usize = 1_000_000;
    /// Largest magnitude of a physical quantity.
    const LARGEST: f64 = 1e50;

    /// The index of a channel among `names`.
    pub(crate) fn channel_index<N: AsRef<str>>(names: &[N], name: &str) -> Result<usize, E> {
        names.iter().position(|known| known.as_ref() == name).ok_or_else(|| {
            let known: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
            E::NoSuchChannel { name: name.into(), known: known.join(", ") }
        })
    }

    /// A finite number.
    pub(crate) fn finite(name: impl Into<String>, value: f64) -> Checked {
        if value.is_finite() { Ok(value) } else { Err(E::NotFinite { name: name.into(), value }) }
    }

    /// A physical quantity: in [-1e50, 1e50], so that products of several of them do not overflow.
    pub(crate) fn quantity(name: impl Into<String>, value: f64) -> Checked {
        if value.abs() <= LARGEST {
            Ok(value)
        } else {
            wrong(name, value, |name| E::OutOfRange { name, value, allowed: "[-1e50, 1e50]" })
        }
    }

    /// A positive [`quantity`].
    pub(crate) fn positive(name: impl Into<String>, value: f64) -> Checked {
        if value > 0.0 {
            quantity(name, value)
        } else {
            wrong(name, value, |name| E::NotPositive { name, value })
        }
    }

    /// A positive number of any size.
    pub(crate) fn above_zero(name: impl Into<String>, value: f64) -> Checked {
        if value > 0.0 && value.is_finite() {
            Ok(value)
        } else {
            wrong(name, value, |name| E::NotPositive { name, value })
        }
    }

    /// A share above 0 and below 1.
    pub(crate) fn share(name: impl Into<String>, value: f64) -> Checked {
        if value > 0.0 && value < 1.0 {
            Ok(value)
        } else {
            wrong(name, value, |name| E::OutOfRange { name, value, allowed: "(0, 1)" })
        }
    }

    /// A [`quantity`] that is not negative.
    pub(crate) fn not_negative(name: impl Into<String>, value: f64) -> Checked {
        if value >= 0.0 {
            quantity(name, value)
        } else {
            wrong(name, value, |name| E::Negative { name, value })
        }
    }

    /// A divisor, such as an inertia, a period or a frequency: in [1e-50, 1e50], so that its inverse is a
    /// [`quantity`].
    pub(crate) fn scale(name: impl Into<String>, value: f64) -> Checked {
        match value {
            1e-50..=1e50 => Ok(value),
            _ if value <= 0.0 => positive(name, value),
            _ => wrong(name, value, |name| E::OutOfRange { name, value, allowed: "[1e-50, 1e50]" }),
        }
    }

    /// A tolerance of a flow: in [1e-16, 1), which is not below the rounding of numbers.
    pub(crate) fn tolerance(name: impl Into<String>, value: f64) -> Checked {
        let allowed = "[1e-16, 1)";
        if (1e-16..1.0).contains(&value) {
            Ok(value)
        } else {
            wrong(name, value, |name| E::OutOfRange { name, value, allowed })
        }
    }

    /// A value between two finite bounds.
    pub(crate) fn between(name: &str, value: f64, [low, high]: [f64; 2]) -> Result<(), E> {
        all_finite(&format!("bounds of {name}"), &[low, high])?;
        if low < high && (low..=high).contains(&value) {
            return Ok(());
        }
        Err(E::Bounds { name: name.into(), value, low, high })
    }

    /// A ratio in [0, 1), such as the eccentric ratio.
    pub(crate) fn fraction(name: impl Into<String>, value: f64) -> Checked {
        if (0.0..1.0).contains(&value) {
            Ok(value)
        } else {
            wrong(name, value, |name| E::OutOfRange { name, value, allowed: "[0, 1)" })
        }
    }

    /// The error for a value that is not allowed: `NotFinite`, or `how` for a finite value.
    fn wrong(name: impl Into<String>, value: f64, how: impl FnOnce(String) -> E) -> Checked {
        let name = name.into();
        Err(if value.is_finite() { how(name) } else { E::NotFinite { name, value } })
    }

    /// A list of finite numbers.
    pub(crate) fn all_finite(name: &str, values: &[f64]) -> Result<(), E> {
        first_wrong(name, values, f64::is_finite, finite)
    }

    /// A list of physical quantities; see [`quantity`].
    pub(crate) fn quantities(name: &str, values: &[f64]) -> Result<(), E> {
        first_wrong(name, values, |value| value.abs() <= LARGEST, quantity)
    }

    /// The error for the first value that is not `right`, with its index.
    fn first_wrong(
        name: &str,
        values: &[f64],
        right: impl Fn(f64) -> bool,
        check: impl Fn(String, f64) -> Checked,
    ) -> Result<(), E> {
        let wrong = values.iter().position(|value| !right(*value));
        wrong.map_or(Ok(()), |i| check(format!("{name}[{i}]"), values[i]).map(drop))
    }

    /// The product of `factors`, a count of numbers or of repetitions; an error if it exceeds `max`.
    pub(crate) fn count(name: impl Into<String>, factors: &[usize], max: usize) -> Result<usize, E> {
        let value = factors.iter().try_fold(1usize, |all, x| all.checked_mul(*x)).unwrap_or(usize::MAX);
        if value <= max { Ok(value) } else { Err(E::TooMany { name: name.into(), value, max }) }
    }

    /// A count of at least `min`.
    pub(crate) fn at_least(name: impl Into<String>, value: usize, min: usize) -> Result<usize, E> {
        if value >= min { Ok(value) } else { Err(E::TooFew { name: name.into(), value, min }) }
    }

    /// A quantity `figure` that is computed from `values`; an error if it is not finite.
    pub(crate) fn representable<'v>(
        name: impl Into<String>,
        figure: f64,
        values: impl IntoIterator<Item = &'v f64>,
    ) -> Checked {
        if figure.is_finite() {
            return Ok(figure);
        }
        let value = values.into_iter().fold(0.0, |m: f64, x| if x.abs() > m.abs() { *x } else { m });
        Err(E::Overflow { name: name.into(), value })
    }

    /// A list of the required length.
    pub(crate) fn length(name: impl Into<String>, found: usize, expected: usize) -> Result<(), E> {
        if found == expected { Ok(()) } else { Err(E::Length { name: name.into(), expected, found }) }
    }
}
