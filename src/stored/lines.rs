//! The stored form of branches and boundaries.

use crate::analysis::{RattleState, Summary};
use crate::branches::line::LinePoint;
use crate::branches::{BranchEnd, BranchNote, BranchPoint, Line, SpecialPoint};
use crate::error::ParameterError;
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
        if let Some(own) = orbit.crossing_count() {
            check_crossings(&crossings, own).map_err(D::Error::custom)?;
        }
        Ok(BranchPoint { parameter, arclength, summaries, rattle, crossings, located, multipliers, orbit })
    }
}

/// Largest number of crossings of an edge by which two passes over one orbit differ: at a grazing rounding
/// decides about two of them. An orbit may graze an edge twice.
const GRAZED: u64 = 4;

/// Whether the edges of the contacts of a point are crossed no more often than those of its orbit, among
/// which are the kinks inside a law, too.
fn check_crossings(crossings: &[[u32; 2]], own: u64) -> Result<(), ParameterError> {
    let sum = crossings.iter().flatten().map(|count| u64::from(*count)).sum::<u64>();
    let most = own.saturating_add(GRAZED * 2 * crossings.len() as u64);
    if sum > most {
        let (name, value) = ("crossings of a point".into(), sum as f64);
        let must = format!("be at most {most}, with the {own} crossings of its orbit");
        return Err(ParameterError::Wrong { name, value, must });
    }
    Ok(())
}

/// The orbit of a point of a branch.
pub trait PointOrbit {
    /// Its Floquet multipliers; `None` if they are not stored with it.
    fn multipliers(&self) -> Option<&Multipliers>;
    /// The number of crossings; `None` if it is not stored with it.
    fn crossing_count(&self) -> Option<u64>;
}

impl PointOrbit for ShootingOrbit {
    fn multipliers(&self) -> Option<&Multipliers> {
        Some(ShootingOrbit::multipliers(self))
    }
    fn crossing_count(&self) -> Option<u64> {
        Some(ShootingOrbit::crossing_count(self))
    }
}

impl PointOrbit for FourierOrbit {
    fn multipliers(&self) -> Option<&Multipliers> {
        None
    }
    fn crossing_count(&self) -> Option<u64> {
        None
    }
}
