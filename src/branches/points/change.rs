//! Bifurcations along a branch.

/// A bifurcation between two points that is to be located.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Change {
    Fold,
    Branch,
    PeriodDoubling,
    NeimarkSacker,
    /// Several real multipliers pass 1 together, as those of equal members do. The number is that of the
    /// first of them in falling order.
    Branches(usize),
    /// Several real multipliers pass -1 together. The number is that of the first of them in rising order.
    PeriodDoublings(usize),
}

impl Change {
    /// The changes of single multipliers and pairs.
    pub(crate) const SINGLE: [Change; 4] =
        [Change::Fold, Change::Branch, Change::PeriodDoubling, Change::NeimarkSacker];

    /// What is noted if the point is not located.
    pub(crate) fn unlocated(self) -> &'static str {
        match self {
            Change::Fold => "a fold was passed",
            Change::Branch => "the determinant changed its sign",
            Change::PeriodDoubling => "a multiplier passed -1",
            Change::NeimarkSacker => "a pair of multipliers passed the unit circle",
            Change::Branches(_) => "several multipliers passed 1",
            Change::PeriodDoublings(_) => "several multipliers passed -1",
        }
    }
}

/// Slopes dp/ds below this are rounding: the branch is vertical, as that of a linear model with the
/// multiplier 1.
pub(crate) const VERTICAL: f64 = 1e-8;
