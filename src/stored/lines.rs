//! The stored form of branches and boundaries.

use crate::branches::line::LinePoint;
use crate::branches::{BranchEnd, BranchNote, Line};
use serde::de::{Deserialize, Deserializer, Error};

#[derive(serde::Deserialize)]
#[serde(rename = "Line", bound(deserialize = "P: Deserialize<'de>, P::Head: Deserialize<'de>"))]
struct StoredLine<P: LinePoint> {
    head: P::Head,
    points: Vec<P>,
    notes: Vec<BranchNote>,
    end: BranchEnd,
    start: Option<BranchEnd>,
    heading: f64,
}

impl<'de, P: LinePoint + Deserialize<'de>> Deserialize<'de> for Line<P>
where
    P::Head: Deserialize<'de>,
{
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let StoredLine { head, points, notes, end, start, heading } = StoredLine::deserialize(deserializer)?;
        let line = Line { head, points, notes, end, first_end: start, heading };
        line.check().map_err(D::Error::custom)?;
        Ok(line)
    }
}
