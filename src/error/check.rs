//! Checks of parameters, for all constructors and settings.

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

/// An angular frequency or a rate of decay of a path: its Taylor coefficients, the powers up to the order 31
/// over the factorials, stay finite with every amplitude that is a [`quantity`].
pub(crate) fn frequency(name: impl Into<String>, value: f64) -> Checked {
    if value.abs() <= 1e9 {
        Ok(value)
    } else {
        wrong(name, value, |name| E::OutOfRange { name, value, allowed: "[-1e9, 1e9]" })
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
    if value >= 0.0 { quantity(name, value) } else { wrong(name, value, |name| E::Negative { name, value }) }
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
