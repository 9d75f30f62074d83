//! The stored form of the points of a sweep.

use crate::sweep::settings::points::PointsKind;
use crate::sweep::{Axis, Points};
use serde::de::{Deserialize, Deserializer, Error};
use serde::ser::{Serialize, Serializer};

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "Axis")]
struct StoredAxis {
    name: String,
    values: Vec<f64>,
}

impl Serialize for Axis {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        StoredAxis { name: self.name().to_owned(), values: self.values().to_vec() }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Axis {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let StoredAxis { name, values } = StoredAxis::deserialize(deserializer)?;
        Axis::of_values(&name, &values).map_err(D::Error::custom)
    }
}

#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "Points", rename_all = "lowercase")]
enum StoredPoints {
    Grid(Vec<Axis>),
    List {
        names: Vec<String>,
        /// The values of all points, one point after the other.
        values: Vec<f64>,
    },
}

impl Serialize for Points {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.kind {
            PointsKind::Grid(axes) => StoredPoints::Grid(axes.clone()),
            PointsKind::List(values) => {
                StoredPoints::List { names: self.names().to_vec(), values: values.clone() }
            }
        }
        .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Points {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match StoredPoints::deserialize(deserializer)? {
            StoredPoints::Grid(axes) => Points::grid(axes),
            StoredPoints::List { names, values } => Points::flat(&names, values),
        }
        .map_err(D::Error::custom)
    }
}
