//! Errors of constructors: which value, what it was, what is allowed.

use thiserror::Error;

/// A parameter that cannot be used. Every variant names the place, the value found and what is allowed.
///
/// Every physical quantity lies within ±1e50, and every quantity that is divided by (an inertia, a radius, a period, a frequency) in
/// 1e-50 .. 1e50. Products of several of them then stay far from the largest `f64`, 1.8e308.
///
/// ```
/// use gear_dynamics::{Backlash, ParameterError};
/// let error = Backlash::new(-1e-5).unwrap_err();
/// assert!(matches!(&error, ParameterError::Negative { name, value } if name == "half width b" && *value == -1e-5));
/// assert_eq!(error.to_string(), "half width b is -0.00001: it must not be negative");
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ParameterError {
    /// A NaN or an infinity.
    #[error("{name} is {value}: it must be a finite number")]
    NotFinite {
        /// Where it stands.
        name: String,
        /// What it was.
        value: f64,
    },
    /// Zero or less where more is needed.
    #[error("{name} is {value}: it must be positive")]
    NotPositive {
        /// Where it stands.
        name: String,
        /// What it was.
        value: f64,
    },
    /// Below zero.
    #[error("{name} is {value}: it must not be negative")]
    Negative {
        /// Where it stands.
        name: String,
        /// What it was.
        value: f64,
    },
    /// Outside its range.
    #[error("{name} is {value}: it must lie in {allowed}")]
    OutOfRange {
        /// Where it stands.
        name: String,
        /// What it was.
        value: f64,
        /// The range, in words.
        allowed: &'static str,
    },
    /// A list without entries.
    #[error("{name} is empty: at least {least} entries are needed")]
    Empty {
        /// Which list.
        name: String,
        /// The smallest length that works.
        least: usize,
    },
    /// A list of the wrong length.
    #[error("{name} has {found} entries: {expected} are needed")]
    Length {
        /// Which list.
        name: String,
        /// The length that fits.
        expected: usize,
        /// The length given.
        found: usize,
    },
    /// Two parameters of one name.
    #[error("there is more than one parameter \"{name}\"")]
    Twice {
        /// The name.
        name: String,
    },
    /// A count that is too small: teeth, gears, samples.
    #[error("{name} is {value}: at least {least} are needed")]
    TooFew {
        /// What was counted.
        name: String,
        /// What it was.
        value: usize,
        /// The smallest count that works.
        least: usize,
    },
    /// A count beyond what there is room or time for.
    #[error("{name} is {value}: at most {most} are allowed")]
    TooMany {
        /// What was counted.
        name: String,
        /// What it was; `usize::MAX` if it is more than can be counted.
        value: usize,
        /// The largest count allowed.
        most: usize,
    },
    /// A figure beyond the largest number.
    #[error("{name} overflows: the largest value in it is {value}")]
    Overflow {
        /// Which figure.
        name: String,
        /// The value, of all that enter it, that is largest in size.
        value: f64,
    },
    /// A ring of an odd number of ordinary external meshes.
    #[error(
        "a closed ring of {gears} ordinary external meshes cannot turn: each mesh reverses the rotation, so an odd ring \
         locks; use an even number of gears, or Ring::as_printed for the form of the paper, which stands for a ring \
         with one mesh that does not reverse"
    )]
    OddRing {
        /// Number of gears in the ring.
        gears: usize,
    },
    /// A wave that does not repeat when the shape says.
    #[error("{name} does not repeat with the angle {period} rad")]
    NotPeriodic {
        /// Which wave.
        name: String,
        /// The angle with which it should repeat `[rad]`.
        period: f64,
    },
    /// A state that breaks the closure of the ring.
    #[error("{name} is {found}: the closure of the ring asks for {expected}")]
    Inconsistent {
        /// Which sum.
        name: String,
        /// What it was.
        found: f64,
        /// What it has to be.
        expected: f64,
    },
    /// A drive slot that the model does not have.
    #[error("drive slot {slot} does not exist: the model has {drives} drives")]
    NoSuchSlot {
        /// The slot asked for.
        slot: usize,
        /// How many the model has.
        drives: usize,
    },
    /// A constant that the shape does not have.
    #[error("no constant \"{name}\"; there are: {known}")]
    NoSuchConstant {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: String,
    },
    /// A constant without a value.
    #[error("constant \"{name}\" has no value")]
    MissingConstant {
        /// Which constant.
        name: String,
    },
    /// A constant with two values.
    #[error("constant \"{name}\" is given twice")]
    ConstantTwice {
        /// Which constant.
        name: String,
    },
    /// A constant that the algebra reads in another form, so that no drive holds it, or the speed.
    #[error(
        "constant \"{name}\" is no drive that may be added to: the algebra reads what is derived from it, or it is the speed of the angle (see VaryingSpeed)"
    )]
    NotADrive {
        /// Which constant.
        name: String,
    },
    /// A contact that the algebra of a shape asks for and its size does not count.
    #[error(
        "the algebra asks the law for contact {contact}, but the size of the shape says {contacts} contacts"
    )]
    NoSuchContact {
        /// The contact asked for; the first one is 0.
        contact: usize,
        /// How many there are.
        contacts: usize,
    },
    /// A law without the flank on which the load rests.
    #[error("the law has no {flank} flank: a positive load presses on that one, and nothing holds it")]
    NoFlank {
        /// Lower or upper.
        flank: &'static str,
    },
    /// A contact whose law has edges where the contact itself has none.
    #[error(
        "the algebra gives edges to the law of contact {contact}, but contact({contact}) has none: solvers would never see it touch"
    )]
    NoEdges {
        /// Which contact; the first one is 0.
        contact: usize,
    },
    /// An output channel that the model does not have.
    #[error("there is no channel \"{name}\"; the model has: {known}")]
    NoSuchChannel {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: String,
    },
}

/// Checks at the door, shared by every constructor.
pub(crate) mod check {
    use crate::error::ParameterError as E;

    type Checked = Result<f64, E>;

    /// Most numbers in one list: half a gigabyte.
    pub(crate) const NUMBERS: usize = 1 << 26;
    /// Highest order of a Fourier series: each is summed at every evaluation.
    pub(crate) const ORDERS: usize = 10_000;
    /// Most times that a wave may repeat in a turn: beyond it the phase of a mesh loses digits that derivatives need.
    pub(crate) const TEETH: usize = 1_000_000;
    /// Largest size of a physical quantity.
    const LARGEST: f64 = 1e50;

    pub(crate) fn finite(name: impl Into<String>, value: f64) -> Checked {
        if value.is_finite() { Ok(value) } else { Err(E::NotFinite { name: name.into(), value }) }
    }

    /// Any physical quantity: at most 1e50 in size, so that products of a few of them do not overflow.
    pub(crate) fn quantity(name: impl Into<String>, value: f64) -> Checked {
        if value.abs() <= LARGEST {
            Ok(value)
        } else {
            wrong(name, value, |name| E::OutOfRange { name, value, allowed: "[-1e50, 1e50]" })
        }
    }

    /// A [`quantity`] above zero.
    pub(crate) fn positive(name: impl Into<String>, value: f64) -> Checked {
        if value > 0.0 {
            quantity(name, value)
        } else {
            wrong(name, value, |name| E::NotPositive { name, value })
        }
    }

    /// A [`quantity`] of zero or more.
    pub(crate) fn not_negative(name: impl Into<String>, value: f64) -> Checked {
        if value >= 0.0 {
            quantity(name, value)
        } else {
            wrong(name, value, |name| E::Negative { name, value })
        }
    }

    /// A quantity that is divided by, such as an inertia, a period or a frequency: positive, and its inverse is a [`quantity`] too.
    pub(crate) fn scale(name: impl Into<String>, value: f64) -> Checked {
        match value {
            1e-50..=1e50 => Ok(value),
            _ if value <= 0.0 => positive(name, value),
            _ => wrong(name, value, |name| E::OutOfRange { name, value, allowed: "[1e-50, 1e50]" }),
        }
    }

    /// A tolerance of a flow: no finer than the rounding of numbers, and below 1.
    pub(crate) fn tolerance(name: impl Into<String>, value: f64) -> Checked {
        let allowed = "[1e-16, 1)";
        if (1e-16..1.0).contains(&value) {
            Ok(value)
        } else {
            wrong(name, value, |name| E::OutOfRange { name, value, allowed })
        }
    }

    /// 0 <= value < 1, for ratios such as the eccentric ratio.
    pub(crate) fn fraction(name: impl Into<String>, value: f64) -> Checked {
        if (0.0..1.0).contains(&value) {
            Ok(value)
        } else {
            wrong(name, value, |name| E::OutOfRange { name, value, allowed: "[0, 1)" })
        }
    }

    /// What is wrong with a value that is not allowed.
    fn wrong(name: impl Into<String>, value: f64, how: impl FnOnce(String) -> E) -> Checked {
        let name = name.into();
        Err(if value.is_finite() { how(name) } else { E::NotFinite { name, value } })
    }

    pub(crate) fn all_finite(name: &str, values: &[f64]) -> Result<(), E> {
        first_wrong(name, values, f64::is_finite, finite)
    }

    pub(crate) fn quantities(name: &str, values: &[f64]) -> Result<(), E> {
        first_wrong(name, values, |value| value.abs() <= LARGEST, quantity)
    }

    /// The error of the first value that is not right.
    fn first_wrong(
        name: &str,
        values: &[f64],
        right: impl Fn(f64) -> bool,
        check: impl Fn(String, f64) -> Checked,
    ) -> Result<(), E> {
        let wrong = values.iter().position(|value| !right(*value));
        wrong.map_or(Ok(()), |i| check(format!("{name}[{i}]"), values[i]).map(drop))
    }

    /// A count of numbers to be stored or of rounds to be made, given as its factors.
    pub(crate) fn count(name: impl Into<String>, factors: &[usize], most: usize) -> Result<usize, E> {
        let value = factors.iter().try_fold(1usize, |all, x| all.checked_mul(*x)).unwrap_or(usize::MAX);
        if value <= most { Ok(value) } else { Err(E::TooMany { name: name.into(), value, most }) }
    }

    /// A figure of `values`, if it has not overflowed.
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

    pub(crate) fn length(name: impl Into<String>, found: usize, expected: usize) -> Result<(), E> {
        if found == expected { Ok(()) } else { Err(E::Length { name: name.into(), expected, found }) }
    }
}
