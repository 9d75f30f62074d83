//! Kinds of points of a branch.

use crate::analysis::contacts::rattle::RattleState;
use crate::contact::piece::Piece;
use std::fmt;

/// What distinguishes a located point of a branch.
///
/// ```
/// use gear_dynamics::branches::PointKind;
/// assert_eq!(PointKind::NeimarkSacker.to_string(), "neimark-sacker");
/// ```
#[derive(Clone, Debug, PartialEq)]
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
    Grazing {
        /// Index of the contact, from 0.
        contact: usize,
        /// The flank of the edge: [`Piece::Lower`] or [`Piece::Upper`].
        edge: Piece,
        /// Rattle state of the contact before and after the point, along the branch.
        rattle: [RattleState; 2],
    },
}

impl PointKind {
    /// The name of the kind, as in tables: `fold`, `period-doubling`, `neimark-sacker`, `branch`,
    /// `symmetry-breaking`, `grazing`.
    pub fn name(&self) -> &'static str {
        match self {
            PointKind::Fold => "fold",
            PointKind::PeriodDoubling => "period-doubling",
            PointKind::NeimarkSacker => "neimark-sacker",
            PointKind::Branch => "branch",
            PointKind::SymmetryBreaking => "symmetry-breaking",
            PointKind::Grazing { .. } => "grazing",
        }
    }
    /// The kind as a number in tables: 1 fold, 2 period doubling, 3 Neimark-Sacker point, 4 branch point, 5 symmetry
    /// breaking, 6 grazing.
    pub fn code(&self) -> u8 {
        match self {
            PointKind::Fold => 1,
            PointKind::PeriodDoubling => 2,
            PointKind::NeimarkSacker => 3,
            PointKind::Branch => 4,
            PointKind::SymmetryBreaking => 5,
            PointKind::Grazing { .. } => 6,
        }
    }
    /// Whether the rattle state of a contact changes: an onset of contact loss or of back contact.
    pub fn changes_rattle(&self) -> bool {
        matches!(self, PointKind::Grazing { rattle: [before, after], .. } if before != after)
    }
}

impl fmt::Display for PointKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PointKind::Grazing { contact, edge, rattle: [before, after] } if before != after => {
                let flank = if *edge == Piece::Lower { "lower" } else { "upper" };
                write!(f, "grazing of contact {contact} at its {flank} edge, rattle {before} to {after}")
            }
            PointKind::Grazing { contact, edge, .. } => {
                let flank = if *edge == Piece::Lower { "lower" } else { "upper" };
                write!(f, "grazing of contact {contact} at its {flank} edge")
            }
            other => f.pad(other.name()),
        }
    }
}
