//! Kinds of points of a branch.

use crate::analysis::RattleState;
use crate::contact::Piece;
use crate::error::ParameterError;
use std::fmt;

/// The kind of a located point of a branch.
///
/// ```
/// use gear_dynamics::branches::PointKind;
/// let kind = PointKind::NeimarkSacker;
/// assert_eq!((kind.to_string(), kind.code()), ("neimark-sacker".into(), 3));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum PointKind {
    /// The branch turns back: dp/ds = 0, a multiplier is 1.
    Fold,
    /// A real multiplier is -1: an orbit of twice the period branches off.
    PeriodDoubling,
    /// A pair of complex multipliers has the absolute value 1: a torus branches off.
    NeimarkSacker,
    /// Two branches cross.
    Branch,
    /// Two branches cross, and the orbits of the other one lack the symmetry x(t + T/2) = -x(t) of this one.
    SymmetryBreaking,
    /// A contact touches an edge without crossing it: the sequence of contacts changes.
    Grazing,
}

impl PointKind {
    /// The kind as a number in tables: 1 fold, 2 period doubling, 3 Neimark-Sacker point, 4 branch point, 5
    /// symmetry breaking, 6 grazing.
    pub fn code(self) -> u8 {
        self as u8 + 1
    }
}

impl fmt::Display for PointKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            PointKind::Fold => "fold",
            PointKind::PeriodDoubling => "period-doubling",
            PointKind::NeimarkSacker => "neimark-sacker",
            PointKind::Branch => "branch",
            PointKind::SymmetryBreaking => "symmetry-breaking",
            PointKind::Grazing => "grazing",
        })
    }
}

/// What a located point of a branch is: a bifurcation or a grazing.
///
/// ```
/// use gear_dynamics::{RattleState, branches::{SpecialPoint, PointKind}, contact::Piece};
/// let rattle = [RattleState::None, RattleState::Unilateral];
/// let onset = SpecialPoint::Grazing { contact: 0, flank: Piece::Upper, rattle };
/// assert_eq!((onset.kind(), onset.changes_rattle()), (PointKind::Grazing, true));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum SpecialPoint {
    /// A bifurcation: any kind but a grazing.
    Bifurcation(PointKind),
    /// A contact touches an edge without crossing it.
    Grazing {
        /// Index of the contact, from 0.
        contact: usize,
        /// The flank of the edge: [`Piece::Lower`] or [`Piece::Upper`].
        flank: Piece,
        /// Rattle state of the contact before and after the point, along the branch.
        rattle: [RattleState; 2],
    },
}

impl SpecialPoint {
    /// The kind of the point.
    pub fn kind(&self) -> PointKind {
        match self {
            SpecialPoint::Bifurcation(kind) => *kind,
            SpecialPoint::Grazing { .. } => PointKind::Grazing,
        }
    }
    /// Checks that a grazing names a flank of one of so many contacts, and that a bifurcation is not a
    /// grazing.
    pub(crate) fn check(&self, contacts: usize) -> Result<(), ParameterError> {
        match *self {
            SpecialPoint::Bifurcation(PointKind::Grazing) => {
                Err(ParameterError::NotSet { name: "the contact of a grazing" })
            }
            SpecialPoint::Grazing { contact, .. } if contact >= contacts => {
                Err(ParameterError::NoSuchContact { contact, contacts })
            }
            SpecialPoint::Grazing { flank: Piece::Gap, .. } => {
                Err(ParameterError::NotSet { name: "the flank of a grazing" })
            }
            _ => Ok(()),
        }
    }
    /// Whether the rattle state of a contact changes: an onset of contact loss or of back contact.
    pub fn changes_rattle(&self) -> bool {
        matches!(self, SpecialPoint::Grazing { rattle: [before, after], .. } if before != after)
    }
}

impl fmt::Display for SpecialPoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SpecialPoint::Grazing { contact, flank, rattle: [before, after] } = self else {
            return self.kind().fmt(f);
        };
        let flank = if *flank == Piece::Lower { "lower" } else { "upper" };
        write!(f, "grazing of contact {contact} at its {flank} edge")?;
        if before != after {
            write!(f, ", rattle {before} to {after}")?;
        }
        Ok(())
    }
}
