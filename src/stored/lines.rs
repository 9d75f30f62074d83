//! The stored form of branches and boundaries.

use crate::analysis::{RattleState, Summary};
use crate::branches::line::LinePoint;
use crate::branches::{BranchEnd, BranchNote, BranchPoint, Line, SpecialPoint};
use crate::periodic::{FourierOrbit, Multipliers, ShootingOrbit};
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

#[derive(serde::Deserialize)]
#[serde(rename = "BranchPoint")]
struct StoredPoint<O> {
    parameter: f64,
    arclength: f64,
    #[serde(deserialize_with = "crate::analysis::summary::read_unchecked")]
    summaries: Vec<Summary>,
    rattle: Vec<RattleState>,
    crossings: Vec<[u32; 2]>,
    located: Option<SpecialPoint>,
    multipliers: Multipliers,
    orbit: O,
}

impl<'de, O: PointOrbit + Deserialize<'de>> Deserialize<'de> for BranchPoint<O> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let StoredPoint { parameter, arclength, summaries, rattle, crossings, located, multipliers, orbit } =
            StoredPoint::<O>::deserialize(deserializer)?;
        if let Some(own) = orbit.multipliers() {
            own.check_same(&multipliers).map_err(D::Error::custom)?;
        }
        Ok(BranchPoint { parameter, arclength, summaries, rattle, crossings, located, multipliers, orbit })
    }
}

/// The orbit of a point of a branch.
pub trait PointOrbit {
    /// Its Floquet multipliers; `None` if they are not stored with it.
    fn multipliers(&self) -> Option<&Multipliers>;
}

impl PointOrbit for ShootingOrbit {
    fn multipliers(&self) -> Option<&Multipliers> {
        Some(ShootingOrbit::multipliers(self))
    }
}

impl PointOrbit for FourierOrbit {
    fn multipliers(&self) -> Option<&Multipliers> {
        None
    }
}
