//! Numbers that need not be finite. Text formats such as JSON have no infinity and no NaN.

use serde::de::{Deserialize, Deserializer, Error, Visitor};
use serde::ser::{Serialize, Serializer};
use std::fmt;

/// A number. Text formats store one that is not finite as "inf", "-inf" or "NaN".
#[derive(Clone, Copy)]
pub(crate) struct AnyNumber(pub(crate) f64);

/// A field of a stored form as an [`AnyNumber`], for `#[serde(with = "..")]`.
pub(crate) mod number {
    use crate::numeric::not_finite::AnyNumber;
    use serde::de::{Deserialize, Deserializer};
    use serde::ser::{Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer>(number: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        AnyNumber(*number).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(AnyNumber::deserialize(deserializer)?.0)
    }
}

/// A list of numbers as [`AnyNumber`]s, for `#[serde(with = "..")]`.
pub(crate) mod list {
    use crate::numeric::not_finite::{AnyNumber, numbers, plain};
    use serde::de::{Deserialize, Deserializer};
    use serde::ser::{Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer>(values: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
        numbers(values).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
        Vec::<AnyNumber>::deserialize(deserializer).map(plain)
    }
}

/// A square matrix as the [`list`] of its entries, column by column, for `#[serde(with = "..")]`.
pub(crate) mod square {
    use crate::numeric::not_finite::list;
    use nalgebra::DMatrix;
    use serde::de::{Deserializer, Error};
    use serde::ser::Serializer;

    pub(crate) fn serialize<S: Serializer>(a: &DMatrix<f64>, serializer: S) -> Result<S::Ok, S::Error> {
        list::serialize(a.as_slice(), serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<DMatrix<f64>, D::Error> {
        let entries = list::deserialize(deserializer)?;
        let (length, n) = (entries.len(), entries.len().isqrt());
        let wrong = || D::Error::custom(format!("{length} entries of a square matrix"));
        (n * n == length).then(|| DMatrix::from_vec(n, n, entries)).ok_or_else(wrong)
    }
}

/// A list as [`AnyNumber`]s.
pub(crate) fn numbers(values: &[f64]) -> Vec<AnyNumber> {
    values.iter().map(|x| AnyNumber(*x)).collect()
}

/// A list of [`AnyNumber`]s as plain numbers.
pub(crate) fn plain(values: Vec<AnyNumber>) -> Vec<f64> {
    values.into_iter().map(|x| x.0).collect()
}

impl Serialize for AnyNumber {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if serializer.is_human_readable() && !self.0.is_finite() {
            serializer.collect_str(&self.0)
        } else {
            serializer.serialize_f64(self.0)
        }
    }
}

impl<'de> Deserialize<'de> for AnyNumber {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            deserializer.deserialize_any(NumberOrText)
        } else {
            f64::deserialize(deserializer).map(AnyNumber)
        }
    }
}

struct NumberOrText;

impl Visitor<'_> for NumberOrText {
    type Value = AnyNumber;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, \"inf\", \"-inf\" or \"NaN\"")
    }
    fn visit_f64<E: Error>(self, x: f64) -> Result<AnyNumber, E> {
        Ok(AnyNumber(x))
    }
    fn visit_i64<E: Error>(self, x: i64) -> Result<AnyNumber, E> {
        Ok(AnyNumber(x as f64))
    }
    fn visit_u64<E: Error>(self, x: u64) -> Result<AnyNumber, E> {
        Ok(AnyNumber(x as f64))
    }
    fn visit_str<E: Error>(self, text: &str) -> Result<AnyNumber, E> {
        match text {
            "inf" => Ok(AnyNumber(f64::INFINITY)),
            "-inf" => Ok(AnyNumber(f64::NEG_INFINITY)),
            "NaN" => Ok(AnyNumber(f64::NAN)),
            _ => Err(E::custom(format!("\"{text}\" is not a number"))),
        }
    }
}
